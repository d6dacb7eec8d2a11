#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""`lucarium view --watch`: view_watch.py PROGRAM KERNEL FOLDER starts a viewer whose KERNEL (a file of the device
library) comes from FOLDER, spoils it, and mends it. One line per check: "ok …" or "FAILED …", then "end"."""
import json
import os
import pathlib
import signal
import subprocess
import sys
import time
import urllib.parse

from view_client import PATIENCE, Page, check, status_where

KEPT = {'eye': [0.1, 0.3, 0.9], 'target': [0, 0.25, 0], 'vfov': 35}


def again(place, path):
    """A page of the program that has taken the other's place."""
    end = time.monotonic() + PATIENCE
    while time.monotonic() < end:
        try:
            page = Page(place, path + 'socket')
            if page.open:
                return page
        except ConnectionError:
            pass
        time.sleep(0.2)
    raise TimeoutError


def left(page):
    """Whether the program closes the connection."""
    try:
        page.until(lambda message: False)
    except (EOFError, ConnectionError):
        return True
    return False


def main():
    program, kernel, folder = sys.argv[1], pathlib.Path(sys.argv[2]), pathlib.Path(sys.argv[3])
    text = kernel.read_text(encoding='utf-8')
    copy = folder / pathlib.Path(*kernel.parts[kernel.parts.index('framework') + 1:])
    copy.parent.mkdir(parents=True)
    copy.write_text(text, encoding='utf-8')
    viewer = subprocess.Popen([program, 'view', 'builtin:cornell', '--size', '16x8', '--iterations', '2', '--watch'],
                              stdout=subprocess.PIPE, text=True,
                              env={**os.environ, 'LUCARIUM_KERNEL_PATH': str(folder)})
    address = urllib.parse.urlparse(viewer.stdout.readline().strip())
    place, path = (address.hostname, address.port), address.path
    page = Page(place, path + 'socket')
    page.send(json.dumps({'do': 'camera', **KEPT}))
    page.send(json.dumps({'do': 'technique', 'name': 'path_tracing', 'parameters': [['estimator', 'bsdf']]}))
    status_where(page, lambda s: s['sides'][0].get('running', {}).get('parameters') == [['estimator', 'bsdf']])
    copy.write_text(text + '\nthis is no kernel\n', encoding='utf-8')
    check('a changed kernel starts the viewer again', left(page))
    page = again(place, path)
    side = status_where(page, lambda s: s['sides'][0]['refusal'])['sides'][0]
    check(f'under the same address, with the compiler\'s message {side["refusal"][-300:]}',
          side['stage'] in ('failed', 'preparing') and copy.name in side['refusal'] and 'error' in side['refusal'])
    copy.write_text(text, encoding='utf-8')
    check('mended it starts again', left(page))
    page = again(place, path)
    status = status_where(page, lambda s: s['sides'][0]['stage'] == 'done')
    camera = status['camera']
    check(f'with camera, technique and parameters {camera}', all(
        abs(a - b) < 1e-5 for a, b in zip(camera['eye'] + camera['target'], KEPT['eye'] + KEPT['target'])) and
        status['sides'][0]['running']['parameters'] == [['estimator', 'bsdf']])
    viewer.send_signal(signal.SIGINT)
    check('Ctrl-C ends it', viewer.wait(PATIENCE) == 0)
    print('end')


main()
