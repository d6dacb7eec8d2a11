#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Each source compiles alone, without a warning: alone.py BUILD recent|all, where BUILD holds compile_commands.json.
Where the sources of a folder are compiled as one (LucariumUnity.cmake), a source may take a name that another one
defines, and then mean something else than it says.
  recent    the sources that were changed or committed last
  all       all of them (15 processor minutes)
Prints each error and warning. Exits with 1 if there is one, with 77 where git's history is absent for recent."""
import concurrent.futures
import os
import re
import subprocess
import sys

from sources import ROOT, committed_last, compile_commands

FOLDERS = ('framework/', 'techniques/', 'apps/', 'tests/')
RECENT = 16


def messages(entry):
    """What the compiler says of a source that it only reads."""
    command = re.sub(r' -o \S+ -c ', ' -fsyntax-only ', entry['command'])
    run = subprocess.run(command, shell=True, cwd=entry['directory'], capture_output=True, text=True)
    found = re.findall(r'^.*: (?:fatal error|error|warning): .*$', run.stderr, re.M)
    if run.returncode and not found:
        found = [f"{entry['file']}: {run.stderr.strip()[-300:]}"]
    return [line.replace(ROOT + '/', '') for line in found]


def main():
    if len(sys.argv) != 3 or sys.argv[2] not in ('recent', 'all'):
        sys.exit(__doc__)
    build = os.path.abspath(sys.argv[1])
    os.chdir(ROOT)
    known = compile_commands(build, FOLDERS)
    names = committed_last(known, RECENT) if sys.argv[2] == 'recent' else sorted(known)
    with concurrent.futures.ThreadPoolExecutor(os.cpu_count()) as pool:
        lines = dict.fromkeys(line for found in pool.map(lambda name: messages(known[name]), names) for line in found)
    print('\n'.join(lines) if lines else f'{len(names)} sources compile alone')
    sys.exit(1 if lines else 0)


main()
