#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""sizes.py [ROOT]: a source has at most LINES lines, a folder holds at most FILES sources, and kernels/README.md says
what every file of the device library is for. Prints one line per breach and exits with 1 if there is one."""
import collections
import os
import sys

from check import SOURCES, read, tracked

LINES = 400
FILES = 31  # sources: README.md and CMakeLists.txt do not count
LIBRARY, MANUAL = 'kernels/lucarium/', 'kernels/README.md'


def breaches():
    folders = collections.Counter()
    manual = read(MANUAL)
    for file in tracked(SOURCES + ('.py', '.js')):
        lines = read(file).count('\n')
        if lines > LINES:
            yield f'{file}: {lines} lines, more than {LINES}: give one of its jobs a file of its own'
        folders[os.path.dirname(file)] += 1
        if file.startswith(LIBRARY) and file.endswith('.clh') and f'`{os.path.basename(file)}`' not in manual:
            yield f'{file}: {MANUAL} does not say what it is for'
    for folder, count in folders.items():
        if count > FILES:
            yield f'{folder}: {count} sources, more than {FILES}: make folders of what belongs together'


os.chdir(sys.argv[1] if len(sys.argv) == 2 else os.path.join(os.path.dirname(__file__), '../..'))
found = list(breaches())
print('\n'.join(found))
sys.exit(1 if found else 0)
