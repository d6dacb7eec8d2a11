#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""What there is to see in moments of haste: view_moving.py PROGRAM TECHNIQUE... runs `lucarium view` on the atrium at
640×360 with a page that takes every picture, lets each technique work for some seconds, and then turns the camera sixty
times a second. Prints for each how long the first picture took once its kernels were there, the pictures per second
after the first second, their sizes (1/N), the longest gap, and how long after the last move the whole picture came."""
import collections
import json
import math
import pathlib
import signal
import subprocess
import sys
import threading
import time
import urllib.parse

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2] / 'tests/apps/lucarium/view'))
from view_client import Page  # noqa: E402

WARM, MOVING, SETTLED, RATE = 6, 6, 1, 60  # seconds, and moves per second


def is_picture(message, divisor=None):
    header = message.get('binary', {})
    return 'picture' in header and divisor in (None, header['divisor'])


def turn(page, ended):
    begin = time.monotonic()
    while not ended.is_set():
        angle = 0.5 * (time.monotonic() - begin)
        page.send(json.dumps({'do': 'camera', 'eye': [0.3 * math.sin(angle), 1.6, 5 + 0.3 * math.cos(angle)],
                              'target': [0, 1.5, 0], 'vfov': 55}))
        time.sleep(1 / RATE)


def first_picture(page):
    """Seconds to the first picture, since the last kernel of which a state before it says that it is being compiled."""
    compiled = time.monotonic()

    def take(message):
        nonlocal compiled
        preparing = message.get('status', {}).get('sides', [{}])[0].get('preparing', {})
        if 'kernels' in preparing.get('text', ''):
            compiled = time.monotonic()
        return is_picture(message)
    page.until(take)
    return time.monotonic() - compiled


def measure(program, technique):
    viewer = subprocess.Popen([program, 'view', 'builtin:atrium', '--size', '640x360', '-t', technique],
                              stdout=subprocess.PIPE, text=True)
    address = urllib.parse.urlparse(viewer.stdout.readline().strip())
    page = Page((address.hostname, address.port), address.path + 'socket')
    first = first_picture(page)
    page.until(lambda m: is_picture(m, 1))
    end = time.monotonic() + WARM
    page.until(lambda m: time.monotonic() > end)
    ended, pictures = threading.Event(), []
    mover = threading.Thread(target=turn, args=(page, ended))
    mover.start()
    begin = time.monotonic()

    def take(message):
        if is_picture(message):
            pictures.append((time.monotonic() - begin, message['binary']['divisor']))
        return time.monotonic() > begin + MOVING
    page.until(take)
    ended.set()
    mover.join()
    rested = time.monotonic()
    page.until(lambda m: is_picture(m, 1))
    whole = time.monotonic() - rested
    viewer.send_signal(signal.SIGINT)
    viewer.wait()
    later = [picture for picture in pictures if picture[0] > SETTLED]
    sizes = ', '.join(f'{count} of 1/{divisor}' for divisor, count in
                      sorted(collections.Counter(divisor for _, divisor in later).items()))
    gap = max(after[0] - before[0] for before, after in zip(later, later[1:]))
    rate = len(later) / (MOVING - SETTLED)
    print(f'{technique}: first picture after {first:.2f} s, {rate:.1f} pictures per second ({sizes}), longest gap '
          f'{gap:.2f} s, whole picture after {whole:.2f} s', flush=True)


def main():
    for technique in sys.argv[2:]:
        measure(sys.argv[1], technique)


main()
