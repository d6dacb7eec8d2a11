#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""What a page sees while a technique prepares itself, and while the camera moves: view_motion.py PROGRAM starts viewers
of techniques that keep their light, and of one that does not. One line per check: "ok …" or "FAILED …", then "end"."""
import json
import signal
import subprocess
import sys
import threading
import time
import urllib.parse

from view_client import PATIENCE, Page, check, status_where

MOVING, PERIOD = 2, 0.03  # [s]
# Exchanges without an end in sight.
KEEPING = {'bundle_exchange': ['texels=2048', 'directions=65536', 'stop_error=0'],
           'bundle_exchange:pixel_rays=bundle': ['final_gather=all', 'texels=2048', 'directions=65536', 'stop_error=0'],
           'virtual_light_field': ['dir_n=32', 'cells=64', 'texels=2048']}


def move(page, coarse):
    """Turns the camera for a while. Returns what the pictures and states of that time say. `coarse`: waits until some
    of the states are."""
    moving = threading.Event()

    def turn():
        step = 0
        while not moving.is_set():
            step += 1
            page.send(json.dumps({'do': 'camera', 'eye': [0.1 + 0.002 * step, 0.3, 0.9], 'target': [0, 0.25, 0],
                                  'vfov': 40}))
            time.sleep(PERIOD)
    pictures, states = [], []
    thread = threading.Thread(target=turn)
    thread.start()
    end = time.monotonic() + MOVING

    def take(message):
        if 'picture' in message.get('binary', {}):
            pictures.append(message['binary'])
        if 'machine' in message.get('status', {}).get('sides', [{}])[0]:
            states.append(message['status']['sides'][0])
        enough = len(pictures) > 4 and sum(state['divisor'] > 1 or not coarse for state in states) > 4
        return enough and time.monotonic() > end
    try:
        page.until(take)
    finally:
        moving.set()
        thread.join()
    return pictures, states


def progress_of(side):
    counters = side['machine']['counters']
    return counters.get('directions', counters.get('lines', 0))


def start(program, technique):
    viewer = subprocess.Popen([program, 'view', 'builtin:cornell', '--size', '192x128', '-t', technique],
                              stdout=subprocess.PIPE, text=True)
    address = urllib.parse.urlparse(viewer.stdout.readline().strip())
    return viewer, Page((address.hostname, address.port), address.path + 'socket')


def prepared(program):
    """Nobody waits for the directions and texels of this one: another picture comes before."""
    viewer, page = start(program, 'virtual_light_field:dir_n=64,cells=512,texels=1048576,access_rays=4096')
    try:
        picture = page.until(lambda m: 'picture' in m.get('binary', {}))['binary']
        check(f'a coarse picture comes at once {picture["width"]}', picture['divisor'] == 4 and picture['width'] == 48)
        side = status_where(page, lambda s: s['sides'][0]['meanwhile'])['sides'][0]
        check(f'by path_tracing, while the technique prepares itself {side["stage"]}',
              (side['meanwhile'], side['stage']) == ('path_tracing', 'preparing'))
        begin = time.monotonic()
        viewer.send_signal(signal.SIGINT)
        code = viewer.wait(PATIENCE)
        check(f'Ctrl-C ends it all the same ({time.monotonic() - begin:.2f} s)', code == 0)
    finally:
        viewer.kill()


def moved(program, technique, options):
    words = f'{technique}{"," if ":" in technique else ":"}{",".join(options)}' if options else technique
    viewer, page = start(program, words)
    try:
        before = status_where(page, lambda s: s['sides'][0].get('divisor') == 1 and (
            not options or progress_of(s['sides'][0]) > 0))['camera']['number']
        pictures, states = move(page, bool(options))
        of_moves = [picture for picture in pictures if picture['camera_number'] > before]
        check(f'{technique}: pictures come while the camera moves ({len(of_moves)})', len(of_moves) > 3)
        if options:
            check('each is coarse', all(picture['divisor'] > 1 and picture['width'] < 192 for picture in of_moves))
            coarse = [progress_of(side) for side in states if side['divisor'] > 1][1:]  # a batch may have ended
            check(f'and its light rests {coarse[0]} to {coarse[-1]}', coarse[0] == coarse[-1] > 0)
        last = status_where(page, lambda s: s['sides'][0].get('divisor') == 1)
        whole = page.until(lambda m: m.get('binary', {}).get('divisor') == 1 and
                           m['binary']['camera_number'] == last['camera']['number'])['binary']
        check('then the whole picture comes', (whole['width'], whole['height']) == (192, 128))
        if options:
            side = status_where(page, lambda s: s['sides'][0].get('divisor') == 1 and
                                progress_of(s['sides'][0]) > coarse[-1])['sides'][0]
            check('and the light goes on', side['stage'] == 'rendering' and not side['meanwhile'])
        viewer.send_signal(signal.SIGINT)
        check('Ctrl-C ends it', viewer.wait(PATIENCE) == 0)
    finally:
        viewer.kill()


def main():
    prepared(sys.argv[1])
    for technique, options in KEEPING.items():
        moved(sys.argv[1], technique, options)
    moved(sys.argv[1], 'path_tracing', [])
    print('end')


main()
