#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""clang-tidy with the list of .clang-tidy: tidy.py BUILD recent|all|FOLDER…, where BUILD holds compile_commands.json.
  recent    the sources of the library, the techniques and the program that were changed or committed last
  all       all of them (25 processor minutes)
  FOLDER    those below it
Prints each warning once. Exits with 1 if there is one, with 77 where clang-tidy or, for recent, git's history is
absent."""
import concurrent.futures
import json
import os
import re
import shutil
import subprocess
import sys
import tempfile

from sources import ROOT, committed_last, compile_commands, skip

RECENT = 16  # sources: about two processor minutes
FOLDERS = ('framework/', 'techniques/', 'apps/')


def commands(build):
    """The compile commands by source's name, without GCC's precompiled headers, which clang cannot read."""
    known = compile_commands(build, FOLDERS)
    for entry in known.values():
        entry['command'] = re.sub(r'-include \S*cmake_pch\.hxx|-Winvalid-pch|-fpch-preprocess', '', entry['command'])
    return known


def main():
    chosen = sys.argv[2:]
    if not chosen or (chosen not in (['recent'], ['all']) and not all(name.startswith(FOLDERS) for name in chosen)):
        sys.exit(__doc__)
    tool = shutil.which('clang-tidy-14') or shutil.which('clang-tidy')
    if not tool:
        skip('clang-tidy is not installed')
    build = os.path.abspath(sys.argv[1])
    os.chdir(ROOT)
    known = commands(build)
    names = committed_last(known, RECENT) if chosen == ['recent'] else sorted(
        name for name in known if chosen == ['all'] or name.startswith(tuple(chosen)))
    if not names:
        sys.exit('no source lies below ' + ', '.join(chosen))
    with tempfile.TemporaryDirectory() as folder:
        with open(os.path.join(folder, 'compile_commands.json'), 'w', encoding='utf8') as file:
            json.dump([known[name] for name in names], file)

        def check(name):
            run = subprocess.run([tool, '-p', folder, '--quiet', name], capture_output=True, text=True)
            found = re.findall(r'^.*: (?:warning|error): .*$', run.stdout, re.M)
            if run.returncode and not found:
                found = [f'{name}: {os.path.basename(tool)} failed: {run.stderr.strip()[-300:]}']
            return [line.replace(ROOT + '/', '') for line in found]

        with concurrent.futures.ThreadPoolExecutor(os.cpu_count()) as pool:
            warnings = dict.fromkeys(line for lines in pool.map(check, names) for line in lines)
    print('\n'.join(warnings) if warnings else f'{len(names)} sources are clean')
    sys.exit(1 if warnings else 0)


main()
