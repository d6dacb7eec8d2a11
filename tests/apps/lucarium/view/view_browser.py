#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""The viewer as its users have it: view_browser.py PROGRAM FOLDER starts `lucarium view` and opens its page in Chromium
through its driver, turns the camera, changes technique and parameters, reloads, opens a second tab, saves, repeats.
FOLDER is for what it writes. One line per check: "ok …" or "FAILED …", then "end". Exit code 77 when Chromium or its
driver is absent."""
import pathlib
import shlex
import shutil
import signal
import struct
import subprocess
import sys
import zlib

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[3] / 'support'))
from browser import Browser, check, wait  # noqa: E402

SIZE, ITERATIONS = (48, 32), 4
SCENE = ['builtin:cornell', '--size', f'{SIZE[0]}x{SIZE[1]}', '--exposure', '0']
DATA = "return {...document.querySelector('.picture').dataset};"
PIXELS = """const c = document.querySelector('.picture');
const copy = Object.assign(document.createElement('canvas'), {width: c.width, height: c.height});
const context = copy.getContext('2d', {willReadFrequently: true});  // else reading complains on the console
context.drawImage(c, 0, 0);
return [c.width, c.height, ...context.getImageData(0, 0, c.width, c.height).data];"""
STAGE = "return document.querySelector('.state')?.dataset.stage;"
LUMINANCE = """const rgb = getComputedStyle(document.body)[arguments[0]].match(/[0-9.]+/g).map(Number);
return .2126 * rgb[0] + .7152 * rgb[1] + .0722 * rgb[2];"""
SET = """const node = document.querySelector(arguments[0]);
if (node.type === 'checkbox') node.checked = arguments[1]; else node.value = arguments[1];
node.dispatchEvent(new Event('change', {bubbles: true}));"""
CLICK = "document.querySelector(arguments[0]).click();"
VALUE = "return document.getElementById(arguments[0]).value;"
TEXT = "return document.querySelector(arguments[0])?.textContent || '';"


def png_pixels(file):
    """Rows of RGB bytes of an 8-bit picture."""
    data, at, packed = file.read_bytes(), 8, b''
    width = height = channels = 0
    while at < len(data):
        length, kind = struct.unpack('>I4s', data[at:at + 8])
        chunk = data[at + 8:at + 8 + length]
        if kind == b'IHDR':
            width, height, _, color = struct.unpack('>IIBB', chunk[:10])
            channels = {2: 3, 6: 4}[color]
        if kind == b'IDAT':
            packed += chunk
        at += length + 12
    raw, stride, above, pixels = zlib.decompress(packed), width * channels, bytes(width * channels), []
    for y in range(height):
        kind, row = raw[y * (stride + 1)], bytearray(raw[y * (stride + 1) + 1:(y + 1) * (stride + 1)])
        for i in range(stride):
            a, b = row[i - channels] if i >= channels else 0, above[i]
            c = above[i - channels] if i >= channels else 0
            p = a + b - c
            paeth = a if abs(p - a) <= min(abs(p - b), abs(p - c)) else b if abs(p - b) <= abs(p - c) else c
            row[i] = (row[i] + (0, a, b, (a + b) // 2, paeth)[kind]) & 255
        above = bytes(row)
        pixels.append([row[i:i + 3] for i in range(0, stride, channels)])
    return pixels


def largest_difference(canvas, file):
    """Between what the canvas shows and a PNG; 255 where the sizes differ."""
    (width, height), values, rows = canvas[:2], canvas[2:], png_pixels(file)
    if len(rows) != height or len(rows[0]) != width:
        return 255
    return max(abs(values[4 * (y * width + x) + c] - rows[y][x][c])
               for y in range(height) for x in range(width) for c in range(3))


class Viewer:
    def __init__(self, program, folder):
        self.program, self.folder = program, folder
        words = ['view', *SCENE, '--iterations', str(ITERATIONS), '-t', 'path_tracing', '-t',
                 'path_tracing:estimator=bsdf']
        self.process = subprocess.Popen([program, *words], stdout=subprocess.PIPE, text=True)
        self.address = self.process.stdout.readline().strip()

    def render(self, name, *words):
        """The picture of `lucarium render`."""
        file = self.folder / name
        subprocess.run([self.program, 'render', *SCENE, '--iterations', str(ITERATIONS), *words, '-q', '-o', file],
                       check=True)
        return file

    def end(self):
        self.process.send_signal(signal.SIGINT)
        return self.process.wait(60)


def is_whole(browser):
    data = browser.run(DATA)
    return data.get('divisor') == '1' and data.get('iterations') == str(ITERATIONS) and browser.run(STAGE) == 'done'


def shows(browser, holds):
    return wait(lambda: is_whole(browser) and holds())


def picture(browser, viewer):
    check('the whole picture comes', shows(browser, lambda: True))
    plain = viewer.render('plain.png')
    difference = largest_difference(browser.run(PIXELS), plain)
    check(f'it is that of lucarium render, to the step of 8 bits ({difference})', difference <= 1)
    check('the layers of the technique are there',
          wait(lambda: browser.run("return document.getElementById('layer').options.length") > 1))
    before = browser.run(PIXELS)
    browser.run(SET, '#layer', 'direct')
    check('a layer is shown', wait(lambda: browser.run(DATA)['layer'] == 'direct' and browser.run(PIXELS) != before))
    browser.run(SET, '#layer', '')
    check('and the image again', wait(lambda: browser.run(PIXELS) == before))
    browser.run("document.querySelector('.picture').focus()")
    browser.press(']')
    check('a key changes the exposure', wait(lambda: browser.run(DATA)['stops'] == '0.5'))
    browser.press('[')
    check('and back', wait(lambda: browser.run(PIXELS) == before))


def camera(browser, viewer):
    before = browser.run(PIXELS)
    text = browser.run(TEXT, '#camera-text')
    browser.run("document.querySelector('.picture').focus()")
    browser.press('ArrowRight')
    check('an arrow turns the camera', shows(browser, lambda: browser.run(PIXELS) != before and
                                             browser.run(TEXT, '#camera-text') != text))
    moved = viewer.render('moved.png', '--camera=' + browser.run(TEXT, '#camera-text'))
    difference = largest_difference(browser.run(PIXELS), moved)
    check(f'the camera\'s text gives this picture ({difference})', difference <= 1)
    number = int(browser.run(DATA)['camera'])
    browser.press('w')
    check('keys fly', shows(browser, lambda: int(browser.run(DATA)['camera']) > number))
    browser.run("""const c = document.querySelector('.picture'), box = c.getBoundingClientRect();
const at = (type, x) => c.dispatchEvent(new PointerEvent(type, {pointerId: 1, bubbles: true, buttons: 1,
  clientX: box.left + x * box.width, clientY: box.top + box.height / 2}));
at('pointerdown', 0.5); at('pointermove', 0.6); at('pointerup', 0.6);""")
    check('a drag orbits', shows(browser, lambda: int(browser.run(DATA)['camera']) > number + 1))
    browser.press('Home')
    check('Home goes back', shows(browser, lambda: browser.run(PIXELS) == before))


def technique(browser, viewer):
    before = browser.run(PIXELS)
    browser.run(SET, '#parameter-estimator', 'bsdf')
    check('a parameter changes the picture', shows(browser, lambda: browser.run(PIXELS) != before))
    other = viewer.render('other.png', '-t', 'path_tracing:estimator=bsdf')
    difference = largest_difference(browser.run(PIXELS), other)
    check(f'as it does for lucarium render ({difference})', difference <= 1)
    browser.run(SET, '#parameter-roulette_start', '9999')
    check('a value out of range is refused, with the range', wait(
        lambda: 'outside' in browser.run(TEXT, '.refusal')))
    check('and what ran before still runs', shows(browser, lambda: largest_difference(browser.run(PIXELS), other) <= 1))
    browser.run(CLICK, '.refusal button')
    check('one goes back to it', wait(lambda: browser.run(TEXT, '.refusal') == '' and
                                      browser.run(VALUE, 'parameter-estimator') == 'bsdf'))
    browser.run(CLICK, '[aria-label="named at the start"] button')
    check('techniques of the command line are at hand', shows(browser, lambda: browser.run(PIXELS) == before))


def tabs(browser, viewer):
    before = browser.run(PIXELS)
    browser.call('/refresh', {})
    check('a reload shows the same again', shows(browser, lambda: browser.run(PIXELS) == before))
    first = browser.call('/window')
    second = browser.call('/window/new', {'type': 'tab'})['handle']
    browser.call('/window', {'handle': second})
    browser.call('/url', {'url': viewer.address})
    check('a second tab watches', wait(lambda: browser.run(TEXT, '#control') == 'another page controls'))
    check('and shows the picture', shows(browser, lambda: browser.run(PIXELS) == before))
    browser.run("document.querySelector('.picture').focus()")
    number = browser.run(DATA)['camera']
    browser.press('ArrowLeft')
    check('its keys do nothing', browser.run(DATA)['camera'] == number)
    browser.run(CLICK, '#take-control')
    check('until it takes control', wait(lambda: browser.run("return document.getElementById('take-control').hidden")))
    browser.call('/window', method='DELETE')
    browser.call('/window', {'handle': first})
    check('the first one controls again when it is closed', wait(
        lambda: browser.run("return document.getElementById('take-control').hidden")))


def files(browser, viewer):
    browser.devtools('Browser.setDownloadBehavior', behavior='allow', downloadPath=str(viewer.folder))
    browser.run(CLICK, '.save-png')
    saved = viewer.folder / 'picture.png'
    check('a picture is saved', wait(saved.exists))
    check('it is the file that lucarium render writes', wait(
        lambda: saved.read_bytes() == (viewer.folder / 'plain.png').read_bytes()))
    line = shlex.split(browser.run(TEXT, '[data-command="render"]'))
    check('there is a command that repeats it', line[:2] == ['lucarium', 'render'])
    subprocess.run([viewer.program, *line[1:-1], viewer.folder / 'repeated.png', '-q', '--exposure', '0'], check=False)
    check('which it does', (viewer.folder / 'repeated.png').read_bytes() == saved.read_bytes())


def looks(browser, viewer):
    for theme, dark in (('light', False), ('dark', True)):
        browser.media(features=[{'name': 'prefers-color-scheme', 'value': theme}])
        page, text = browser.run(LUMINANCE, 'backgroundColor'), browser.run(LUMINANCE, 'color')
        check(f'{theme}: the page is {theme}, and text can be read', (page < 64) == dark and abs(page - text) > 120)
    browser.media(features=[])
    browser.devtools('Emulation.setDeviceMetricsOverride', width=360, height=740, deviceScaleFactor=2, mobile=True)
    check('on a phone nothing is wider than the page', wait(
        lambda: browser.run('return document.documentElement.scrollWidth <= 360 && innerWidth === 360')))
    check('and the picture comes first', browser.run(
        "return document.querySelector('.picture').getBoundingClientRect().top < 300"))
    (viewer.folder / 'phone.png').write_bytes(browser.picture())
    browser.devtools('Emulation.clearDeviceMetricsOverride')
    browser.run("document.activeElement.blur()")
    reached = set()
    for _ in range(60):
        browser.press('Tab')
        reached.add(browser.run("const e = document.activeElement; return e.id || e.className || e.textContent;"))
    check('Tab reaches picture, technique, parameters, camera and files', {
        'picture', 'technique', 'parameter-estimator', 'scene-camera', 'save-exr'} <= reached)
    (viewer.folder / 'page.png').write_bytes(browser.picture())


def main():
    program, folder = sys.argv[1], pathlib.Path(sys.argv[2]).resolve()
    browser, driver = shutil.which('chromium'), shutil.which('chromedriver')
    if not browser or not driver:
        print('skipped: chromium or chromedriver is not installed')
        sys.exit(77)
    viewer = Viewer(program, folder)
    session = Browser(browser, driver, folder)
    try:
        session.call('/url', {'url': viewer.address})
        picture(session, viewer)
        camera(session, viewer)
        technique(session, viewer)
        tabs(session, viewer)
        files(session, viewer)
        looks(session, viewer)
        messages = session.call('/se/log', {'type': 'browser'})
        check(f'nothing on the console {[m["message"] for m in messages]}', not messages)
        check('Ctrl-C ends the viewer', viewer.end() == 0)
        check('which the page says', wait(lambda: 'not connected' in session.run(TEXT, '.lamp')))
    finally:
        session.close()
        viewer.process.kill()
    print('end')


main()
