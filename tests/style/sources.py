# SPDX-License-Identifier: Apache-2.0
"""The sources of a build and their compile commands, for the checks that read each source alone."""
import json
import os
import re
import subprocess
import sys

ROOT = os.path.realpath(os.path.join(os.path.dirname(__file__), '../..'))


def skip(reason):
    """Ends the check as one that was left out."""
    print('skipped: ' + reason)
    sys.exit(77)


def each_source(entry):
    """The compile command of a source; of those compiled as one (LucariumUnity.cmake), one of each."""
    if not os.path.basename(entry['file']).startswith('unity_'):
        return [entry]
    with open(entry['file'], encoding='utf8') as file:
        names = re.findall(r'^#include "(.*)"$', file.read(), re.M)
    return [dict(entry, file=name, command=entry['command'].replace(entry['file'], name)) for name in names]


def compile_commands(build, folders):
    """Entries of compile_commands.json by source's name below ROOT, of sources below `folders` (prefixes)."""
    with open(os.path.join(build, 'compile_commands.json'), encoding='utf8') as file:
        entries = json.load(file)
    result = {}
    for entry in [one for unit in entries for one in each_source(unit)]:
        result.setdefault(os.path.relpath(entry['file'], ROOT), entry)
    return {name: entry for name, entry in result.items() if name.startswith(folders)}


def committed_last(known, count):
    """Names of at most `count` of the `known` sources: those not committed yet, then those committed last."""
    log = subprocess.run(['git', 'log', '-n', '200', '--name-only', '--format='], capture_output=True, text=True)
    if log.returncode:
        skip('this is no checkout')
    changed = subprocess.run(['git', 'diff', '--name-only', 'HEAD'], capture_output=True, text=True)
    names = dict.fromkeys(name for name in (changed.stdout + log.stdout).split('\n') if name in known)
    if not names:
        skip('the history names no source')
    return list(names)[:count]
