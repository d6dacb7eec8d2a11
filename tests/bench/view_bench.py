#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""What serving costs: view_bench.py PROGRAM [WORD...] runs `lucarium view` with a page that takes every picture, and
`lucarium render`, in turns, on the scene and technique that the words name (default: the Cornell box, path_tracing).
Prints iterations per second of processor time of both, which other programs on the machine disturb little, their ratio,
and how long the first picture took once the kernels were there."""
import json
import os
import pathlib
import signal
import statistics
import subprocess
import sys
import tempfile
import time
import urllib.parse

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2] / 'tests/apps/lucarium/view'))
from view_client import Page  # noqa: E402

ROUNDS, SECONDS = 5, 12  # seconds of a viewer's life that are looked at, after those in which it starts
SETTLED = 3              # seconds after the first whole picture


def processor_seconds(process):
    """Of all its threads so far, user and system."""
    fields = pathlib.Path(f'/proc/{process}/stat').read_text().rpartition(')')[2].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf('SC_CLK_TCK')


def viewed(program, words):
    """Iterations per second of processor time, pictures per second, seconds from prepared to the first picture."""
    process = subprocess.Popen([program, 'view', *words], stdout=subprocess.PIPE, text=True)
    address = urllib.parse.urlparse(process.stdout.readline().strip())
    page = Page((address.hostname, address.port), address.path + 'socket')
    prepared = first = None
    marks, pictures, end = [], 0, None
    while end is None or time.monotonic() < end:
        message = page.receive()
        now = time.monotonic()
        if 'picture' in message.get('binary', {}):
            page.send(json.dumps({'do': 'shown', 'picture': message['binary']['picture']}))
            first = first or now
            pictures += end is not None
        side = message.get('status', {}).get('sides', [{}])[0]
        if side.get('stage') == 'preparing':
            prepared = now
        if side.get('stage') == 'rendering' and side['divisor'] == 1 and now > first + SETTLED:
            marks.append((side['progress']['iterations'], processor_seconds(process.pid)))
            end = end or now + SECONDS
    process.send_signal(signal.SIGINT)
    process.wait()
    (before, spent), (after, spent_then) = marks[0], marks[-1]
    return (after - before) / (spent_then - spent), pictures / SECONDS, first - prepared


def rendered(program, words, iterations):
    """Iterations per second of processor time: those of twice as many, less those of the first."""
    spent = []
    for count in (iterations, 2 * iterations):
        with tempfile.TemporaryDirectory() as folder:
            before = os.times()
            subprocess.run([program, 'render', *words, '--iterations', str(count), '-q', '-o', f'{folder}/a.exr'],
                           check=True)
            after = os.times()
        spent.append(after.children_user + after.children_system - before.children_user - before.children_system)
    return iterations / (spent[1] - spent[0])


def main():
    program, words = sys.argv[1], sys.argv[2:] or ['builtin:cornell']
    views, renders = [], []
    iterations = 100
    for _ in range(ROUNDS):
        views.append(viewed(program, words))
        iterations = max(20, round(views[-1][0] * SECONDS))
        renders.append(rendered(program, words, iterations))
    ratios = [view[0] / render for view, render in zip(views, renders)]
    print(f'view:   {statistics.median(v[0] for v in views):.2f} iterations per processor second, '
          f'{statistics.median(v[1] for v in views):.1f} pictures per second')
    print(f'render: {statistics.median(renders):.2f} iterations per processor second')
    print(f'ratio:  {statistics.median(ratios):.3f} (from {min(ratios):.3f} to {max(ratios):.3f})')
    print(f'first picture after the kernels: {statistics.median(v[2] for v in views):.2f} s '
          f'(at most {max(v[2] for v in views):.2f} s)')


main()
