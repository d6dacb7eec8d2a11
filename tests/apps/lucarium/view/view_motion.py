#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""What a page sees while a technique prepares itself, and while camera or scene move: view_motion.py PROGRAM WORD...
starts viewers of techniques that keep their light, of one that does not, and of one that is too slow, which `WORD...`
choose and which has a parameter `sleep`. One line per check: "ok …" or "FAILED …", then "end"."""
import contextlib
import json
import signal
import subprocess
import sys
import threading
import time
import urllib.parse

from view_client import PATIENCE, Page, check, status_where

MOVING, PERIOD = 2, 0.03  # [s]
# [s] A move that is the last one for longer: the machine is busy, and the viewer may have heard of the next one so late
# that it rendered the whole size.
LATE = 2 * PERIOD
# Exchanges without an end in sight.
KEEPING = {'bundle_exchange': ['texels=2048', 'directions=65536', 'stop_error=0'],
           'bundle_exchange:pixel_rays=bundle': ['final_gather=all', 'texels=2048', 'directions=65536', 'stop_error=0'],
           'virtual_light_field': ['dir_n=32', 'cells=64', 'texels=2048']}


@contextlib.contextmanager
def turning(page):
    """Turns the camera meanwhile. Gives a list that gets begin and end of each message."""
    ended, sent = threading.Event(), []

    def turn():
        step = 0
        while not ended.is_set():
            step += 1
            begin = time.monotonic()
            page.send(json.dumps({'do': 'camera', 'eye': [0.1 + 0.002 * step, 0.3, 0.9], 'target': [0, 0.25, 0],
                                  'vfov': 40}))
            sent.append((begin, time.monotonic()))
            time.sleep(PERIOD)
    thread = threading.Thread(target=turn)
    thread.start()
    try:
        yield sent
    finally:
        ended.set()
        thread.join()


def move(page, coarse):
    """Turns the camera for a while. Returns what the pictures and states of that time say, and how long each move was
    the last one, at most. `coarse`: waits until some of the states are."""
    pictures, states = [], []
    end = time.monotonic() + MOVING

    def take(message):
        if 'picture' in message.get('binary', {}):
            pictures.append(message['binary'])
        if 'machine' in message.get('status', {}).get('sides', [{}])[0]:
            states.append({**message['status']['sides'][0], 'number': message['status']['camera']['number']})
        enough = len(pictures) > 4 and sum(state['divisor'] > 1 or not coarse for state in states) > 4
        return enough and time.monotonic() > end
    with turning(page) as sent:
        page.until(take)
    ends = [end for _, end in sent[1:]] + [time.monotonic()]
    return pictures, states, [end - begin for (begin, _), end in zip(sent, ends)]


def progress_of(side):
    counters = side['machine']['counters']
    return counters.get('directions', counters.get('lines', 0))


def resting(states, long_moves):
    """The progress that coarse states show, one list for the time between two moves that were the last one for long:
    then the light goes on."""
    parts = {}
    for side in states:
        if side['divisor'] > 1:
            part = sum(number < side['number'] for number in long_moves)
            parts.setdefault(part, []).append(progress_of(side))
    return [part[1:] for part in parts.values() if len(part) > 1]  # a batch may have ended before the first


def start(program, *words, late=0, scene='builtin:cornell'):
    """A viewer, and a page that comes so late [s]."""
    viewer = subprocess.Popen([program, 'view', scene, *words, '--size', '192x128'],
                              stdout=subprocess.PIPE, text=True)
    address = urllib.parse.urlparse(viewer.stdout.readline().strip())
    time.sleep(late)
    return viewer, Page((address.hostname, address.port), address.path + 'socket')


def prepared(program):
    """Nobody waits for the directions and texels of this one: another picture comes before."""
    technique = 'virtual_light_field:dir_n=64,cells=512,texels=1048576,access_rays=4096'
    viewer, page = start(program, '-t', technique, late=2)
    try:
        picture = page.until(lambda m: 'picture' in m.get('binary', {}))['binary']
        check(f'a coarse picture is there, made before there was a page {picture["width"]}',
              picture['divisor'] == 4 and picture['width'] == 48)
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
    viewer, page = start(program, '-t', words)
    try:
        before = status_where(page, lambda s: s['sides'][0].get('divisor') == 1 and (
            not options or progress_of(s['sides'][0]) > 0))['camera']['number']
        pictures, states, lasted = move(page, bool(options))
        of_moves = [picture for picture in pictures if picture['camera_number'] > before]
        check(f'{technique}: pictures come while the camera moves ({len(of_moves)})', len(of_moves) > 3)
        if options:
            # A busy machine may hold up this program between two moves.
            whole = [picture for picture in of_moves if picture['divisor'] == 1 or picture['width'] == 192]
            seconds = [lasted[picture['camera_number'] - before - 1] for picture in whole]
            check(f'each is coarse, unless no move came for long {seconds}', all(s > LATE for s in seconds))
            coarse = resting(states, [index for index, s in enumerate(lasted, before + 1) if s > LATE])
            check(f'and its light rests {coarse}', all(len(set(light)) == 1 and light[0] > 0 for light in coarse))
            light = max(progress_of(side) for side in states)
        last = status_where(page, lambda s: s['sides'][0].get('divisor') == 1)
        whole = page.until(lambda m: m.get('binary', {}).get('divisor') == 1 and
                           m['binary']['camera_number'] >= last['camera']['number'])['binary']
        check('then the whole picture comes', (whole['width'], whole['height']) == (192, 128))
        if options:
            side = status_where(page, lambda s: s['sides'][0].get('divisor') == 1 and
                                progress_of(s['sides'][0]) > light)['sides'][0]
            check('and the light goes on', side['stage'] == 'rendering' and not side['meanwhile'])
        viewer.send_signal(signal.SIGINT)
        check('Ctrl-C ends it', viewer.wait(PATIENCE) == 0)
    finally:
        viewer.kill()


def played(program):
    """The pictures of an animation have the light of their time, as those of a scene at rest."""
    viewer, page = start(program, '-t', 'micro_rendering:points_log2=12,jacobi_level=6', scene='builtin:statue')
    try:
        status_where(page, lambda s: s['sides'][0].get('divisor') == 1)
        page.send(json.dumps({'do': 'layer', 'name': 'indirect'}))
        page.until(lambda m: m.get('binary', {}).get('layer') == 'indirect')
        pictures = []
        for step in range(1, 9):
            page.send(json.dumps({'do': 'time', 'seconds': step / 8}))
            pictures.append(page.until(lambda m: abs(m.get('binary', {}).get('time', -1) - step / 8) < 1e-6)['binary'])
        # Black ones have no exponent.
        lit = [(p['by']['name'], p['divisor'], p['exponent']) for p in pictures]
        check(f'an animation is played with its indirect light {lit}', all(p['exponent'] for p in pictures))
        whole = page.until(lambda m: m.get('binary', {}).get('divisor') == 1)['binary']
        check('then the whole picture comes, of the last time', whole['time'] == 1 and whole['width'] == 192)
        viewer.send_signal(signal.SIGINT)
        check('Ctrl-C ends it', viewer.wait(PATIENCE) == 0)
    finally:
        viewer.kill()


def played_and_turned(program):
    """A camera that moves long before the light of another time has come to its end."""
    technique = 'virtual_light_field'
    viewer, page = start(program, '-t', f'{technique}:{",".join(KEEPING[technique])}', scene='builtin:statue:levels=2')
    try:
        status_where(page, lambda s: s['sides'][0].get('divisor') == 1 and progress_of(s['sides'][0]) > 0)
        page.send(json.dumps({'do': 'time', 'seconds': 0.5}))
        page.until(lambda m: m.get('binary', {}).get('time') == 0.5)
        before = status_where(page, lambda s: s['sides'][0].get('divisor') == 1)['camera']['number']
        _, states, lasted = move(page, True)
        coarse = resting(states, [index for index, s in enumerate(lasted, before + 1) if s > LATE])
        check(f'at another time light rests for a camera that moves {coarse}',
              len(coarse) > 0 and all(len(set(light)) == 1 for light in coarse))
        viewer.send_signal(signal.SIGINT)
        check('Ctrl-C ends it', viewer.wait(PATIENCE) == 0)
    finally:
        viewer.kill()


def is_move(header):
    return 'picture' in header and header['divisor'] > 1


def too_slow(program, words):
    """Another technique's pictures, while the camera moves, in place of those that come too late."""
    viewer, page = start(program, *words)
    try:
        status_where(page, lambda s: s['sides'][0].get('divisor') == 1)
        pictures, seen = 0, None

        def take(message):
            nonlocal pictures, seen
            header = message.get('binary', {})
            pictures += is_move(header) and header['by']['name'] == 'path_tracing'
            side = message.get('status', {}).get('sides', [{}])[0]
            if side.get('meanwhile') and side['stage'] == 'rendering':  # its kernels are there
                seen = side
            return pictures > 9 and seen
        with turning(page):
            page.until(take)
        check(f'too slow: path_tracing stands in while the camera moves {seen["stage"]}',
              (seen['meanwhile'], seen['stage']) == ('path_tracing', 'rendering') and seen['divisor'] > 1)
        own = seen['running']['name']
        check(f'and the panels show what runs {own}', own == 'constant' and 'repeat' not in seen)
        begin = status_where(page, lambda s: s['sides'][0].get('divisor') == 1 and not s['sides'][0]['meanwhile'])
        check(f'once it rests its own picture comes {begin["sides"][0]["progress"]}', begin['sides'][0]['running'][
            'name'] == own and begin['sides'][0]['progress']['samples'] > 0)
        header = page.until(lambda m: m.get('binary', {}).get('divisor') == 1)['binary']
        check(f'whole, and of the last camera {header["by"]}',
              (header['width'], header['by']['name']) == (192, own) and
              header['camera_number'] == begin['camera']['number'])
        first = None

        def take_first(message):
            nonlocal first
            header = message.get('binary', {})
            first = header if is_move(header) else None
            return first
        with turning(page):
            page.until(take_first)
        check(f'the next time it stands in at once {first["by"]}', first['by']['name'] == 'path_tracing')
        page.send(json.dumps({'do': 'technique', 'name': own, 'parameters': [['sleep', '0']]}))
        last = status_where(page, lambda s: s['sides'][0].get('running', {}).get('parameters') == [['sleep', '0']])
        with turning(page):
            by = [page.until(lambda m: m.get('binary', {}).get('camera_number', 0) > last['camera']['number'])[
                'binary']['by']['name'] for _ in range(9)]
        check(f'quick enough it shows itself {by}', set(by) == {own})
        viewer.send_signal(signal.SIGINT)
        check('Ctrl-C ends it', viewer.wait(PATIENCE) == 0)
    finally:
        viewer.kill()


def main():
    prepared(sys.argv[1])
    for technique, options in KEEPING.items():
        moved(sys.argv[1], technique, options)
    for technique in ('path_tracing', 'micro_rendering:points_log2=12,jacobi_level=6'):
        moved(sys.argv[1], technique, [])
    played(sys.argv[1])
    played_and_turned(sys.argv[1])
    too_slow(sys.argv[1], sys.argv[2:])
    print('end')


main()
