#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""The viewer as its users have it: view_browser.py PROGRAM FOLDER starts `lucarium view` and opens its page in Chromium
through its driver, turns the camera, changes technique and parameters, reloads, opens a second tab, saves, repeats.
FOLDER is for what it writes. One line per check: "ok …" or "FAILED …", then "end". Exit code 77 when Chromium or its
driver is absent."""
import pathlib
import shlex
import shutil
import subprocess
import sys

from scene_browser import edits, errors, inspector
from viewer_page import (CLICK, DATA, ITERATIONS, LUMINANCE, PIXELS, SET, SIZE, STAGE, TEXT, VALUE, Viewer,
                         largest_difference, png_pixels, shows)
from browser import Browser, check, wait

SEEN_LABEL = """const label = document.querySelector('.side-label.side-0');
return label.hidden ? '' : label.textContent;"""
# After a failure, before and after the camera has moved; and without one.
LABELS = """const by = {name: 'constant', parameters: [['red', '1']]};
const side = stage => ({stage, wanted: by}), image = {header: {by, camera_number: 7}};
const text = (stage, camera, mode = 'first', at = 0) => BesidePanel.prototype.labelText.call({camera,
  sides: [side('rendering'), side(stage)].slice(1 - at), picture: {mode, images: [image, image].slice(1 - at)}}, at,
  false);
return [text('failed', 7), text('failed', 8), text('rendering', 8), text('failed', 7, 'difference', 1)];"""


def picture(browser, viewer):
    check('the whole picture comes', shows(browser, lambda: True))
    plain = viewer.render('plain.png')
    difference = largest_difference(browser.run(PIXELS), plain)
    check(f'it is that of lucarium render, to the step of 8 bits ({difference})', difference <= 1)
    check('all light paths are computed', wait(lambda: browser.run(TEXT, '#light-paths') == 'Light paths: all'))
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
    page = pathlib.Path(__file__).parents[4] / 'framework/lucarium/view/page'
    script = (page / 'state_panels.js').read_text()
    check('a picture by another technique is called so in every stage, until the own one has come', browser.run(
        script + "return ['path_tracing', ''].map(meanwhile => stageText({stage: 'rendering', meanwhile}));") ==
          ['rendering; meanwhile a picture by path_tracing', 'rendering'])
    script = ''.join((page / name).read_text() for name in ('technique_panel.js', 'beside_panel.js'))
    check('a picture that is seen after a failure says whose it is', browser.run(
        script + LABELS) == ['picture by constant red=1', 'picture by constant red=1, from an earlier camera', '',
                             'second: picture by constant red=1'])
    browser.run(SET, '#parameter-estimator', 'bsdf')
    check('a parameter changes the picture', shows(browser, lambda: browser.run(PIXELS) != before))
    other = viewer.render('other.png', '-t', 'path_tracing:estimator=bsdf')
    difference = largest_difference(browser.run(PIXELS), other)
    check(f'as it does for lucarium render ({difference})', difference <= 1)
    browser.run(SET, '#parameter-roulette_start', '9999')
    check('a value out of range is refused, with the range', wait(
        lambda: 'outside' in browser.run(TEXT, '.refusal')))
    check('the picture says whose it is', wait(
        lambda: browser.run(SEEN_LABEL) == 'picture by path_tracing estimator=bsdf'))
    check('and what ran before still runs', shows(browser, lambda: largest_difference(browser.run(PIXELS), other) <= 1))
    browser.run(CLICK, '.refusal button')
    check('one goes back to it', wait(lambda: browser.run(TEXT, '.refusal') == '' and
                                      browser.run(VALUE, 'parameter-estimator') == 'bsdf'))
    check('whose picture it is need not be said then', wait(lambda: browser.run(SEEN_LABEL) == ''))
    browser.run(CLICK, '[aria-label="named at the start"] button')
    check('techniques of the command line are at hand', shows(browser, lambda: browser.run(PIXELS) == before))


def has_second(browser):
    data = browser.run(DATA)
    return data.get('second') == str(ITERATIONS) and data.get('secondDivisor') == '1'


def beside(browser, viewer):
    """The second technique of the command line on the second side."""
    plain, other = browser.run(PIXELS), viewer.folder / 'other.png'
    browser.run(SET, '#beside', 'split')
    check('a second technique renders beside the first', shows(browser, lambda: has_second(browser)))
    browser.run("document.querySelector('.handle').focus()")
    browser.press('Home')
    check('the handle moves by keys: all is the second one', wait(
        lambda: largest_difference(browser.run(PIXELS), other) <= 1))
    browser.run("""const handle = document.querySelector('.handle'), box = document.querySelector('.picture')
    .getBoundingClientRect();
const at = (type, x) => handle.dispatchEvent(new PointerEvent(type, {pointerId: 1, bubbles: true, clientX: x}));
at('pointerdown', box.left); at('pointermove', box.left + box.width / 2); at('pointerup', box.left);""")
    width, height = SIZE
    left = [4 * (y * width + x) for y in range(height) for x in range(width // 2)]
    rows = png_pixels(other)

    def is_split():
        values = browser.run(PIXELS)[2:]
        return all(values[i + c] == plain[2 + i + c] for i in left for c in range(3)) and all(
            abs(values[4 * (y * width + x) + c] - rows[y][x][c]) <= 1
            for y in range(height) for x in range(width // 2, width) for c in range(3))
    check('and by dragging: left of it the first, right of it the second', wait(is_split))
    browser.run(SET, '#beside', 'blink')
    check('blinking shows one, then the other', wait(lambda: browser.run(PIXELS) == plain) and wait(
        lambda: largest_difference(browser.run(PIXELS), other) <= 1))
    browser.run(SET, '#beside', 'difference')
    check('the difference is shown', wait(lambda: browser.run(DATA)['mode'] == 'difference' and browser.run(
        PIXELS) != plain and largest_difference(browser.run(PIXELS), other) > 1))
    browser.run(SET, '#beside', 'flip')
    check('FLIP between them is measured', wait(lambda: 0 < float(browser.run(DATA)['flip'] or 0) < 1))
    browser.run(CLICK, '#side-1')
    check('each side has its own parameters', wait(lambda: browser.run(VALUE, 'parameter-estimator') == 'bsdf'))
    browser.run(SET, '#beside', 'split')
    browser.run(SET, '#parameter-estimator', 'mis')
    browser.run("document.querySelector('.handle').focus()")
    browser.press('Home')
    check('a change of the second leaves the first', shows(browser, lambda: has_second(browser) and browser.run(
        PIXELS) == plain) and browser.run(CLICK, '#side-0') is None and wait(
            lambda: browser.run(VALUE, 'parameter-estimator') == 'mis'))
    (viewer.folder / 'split.png').write_bytes(browser.picture())
    browser.run(SET, '#beside', 'first')
    check('one technique again', shows(browser, lambda: browser.run(DATA)['second'] == '' and
                                       browser.run(PIXELS) == plain))


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
    compare(browser, viewer)


def compare(browser, viewer):
    """The command of a comparison, and its file, give the picture of `render`."""
    picture_file = viewer.folder / 'whole.exr'
    viewer.render('whole.exr')
    line = shlex.split(browser.run(TEXT, '[data-command="compare"]'))
    check('there is a comparison, too', line[:2] == ['lucarium', 'compare'])
    browser.run(CLICK, '[data-file="comparison.json"]')
    saved = viewer.folder / 'comparison.json'
    check('and its file is saved', wait(saved.exists))
    for name, words in (('by_line', line[1:-1]), ('by_file', ['compare', '--comparison', saved, '-o'])):
        folder = viewer.folder / name
        subprocess.run([viewer.program, *words, folder, '-q'], check=False)
        piece = folder / 'pieces/scene1-variant1-budget1-seed1.exr'
        same = subprocess.run([viewer.program, 'diff', piece, picture_file, '--json'], capture_output=True, text=True,
                              check=False)
        check(f'{name}: the same pixels', same.returncode == 0 and '"relMSE": 0.0' in same.stdout)


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
        beside(session, viewer)
        inspector(session, viewer)
        errors(session, viewer)
        edits(session, viewer)
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
