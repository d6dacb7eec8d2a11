# SPDX-License-Identifier: Apache-2.0
"""A viewer and its page in a browser, for view_browser.py and scene_browser.py."""
import atexit
import pathlib
import signal
import struct
import subprocess
import sys
import zlib

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[3] / 'support'))
from browser import wait  # noqa: E402

SIZE, ITERATIONS = (48, 32), 4
SCENE = ['builtin:cornell', '--size', f'{SIZE[0]}x{SIZE[1]}', '--exposure', '0']
DATA = "return {...document.querySelector('.picture')?.dataset};  // the page may not be built yet"
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
    def __init__(self, program, folder, words=(*SCENE, '--iterations', str(ITERATIONS), '-t', 'path_tracing', '-t',
                                               'path_tracing:estimator=bsdf')):
        self.program, self.folder = program, folder
        self.process = subprocess.Popen([program, 'view', *words], stdout=subprocess.PIPE, text=True)
        atexit.register(self.process.kill)  # also where no browser starts
        self.address = self.process.stdout.readline().strip()

    def render(self, name, *words):
        """The picture of `lucarium render`."""
        file = self.folder / name
        scene = SCENE if file.suffix == '.png' else SCENE[:SCENE.index('--exposure')]
        subprocess.run([self.program, 'render', *scene, '--iterations', str(ITERATIONS), *words, '-q', '-o', file],
                       check=True)
        return file

    def end(self):
        self.process.send_signal(signal.SIGINT)
        return self.process.wait(60)


def is_whole(browser):
    data = browser.run(DATA)
    return data.get('divisor') == '1' and data.get('iterations') == str(ITERATIONS) and browser.run(STAGE) == 'done'


def shows(browser, holds):
    # Whole before may have been the last picture, and coarse what was seen between.
    return wait(lambda: is_whole(browser) and holds() and is_whole(browser))
