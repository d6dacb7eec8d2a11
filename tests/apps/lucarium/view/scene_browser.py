# SPDX-License-Identifier: Apache-2.0
"""Pixels, errors, scene and camera paths on the page of view_browser.py."""
import shlex
import subprocess

from viewer_page import (CLICK, DATA, PIXELS, SET, SIZE, TEXT, VALUE, is_whole, largest_difference, shows)

from browser import check, wait


def insides(browser):
    """What techniques hold at the pixel that is inspected: in words, and as a layer of that pixel."""
    browser.run(SET, '#technique', 'bidirectional_vpl')
    check('the words of a technique stand beside the values', wait(lambda: all(name in browser.run(
        TEXT, '#inspector') for name in ('samples in the weights', 'light vertices', 'the strongest'))))
    sliders = browser.run("return ['candidates', 'g_max'].map(name => "
                          "document.querySelectorAll(`[data-name=${name}] input[type=range]`).length);")
    check(f'a number has a slider, one from a millionth to a million millions a field alone {sliders}',
          sliders == [1, 0])
    browser.run(SET, '#technique', 'micro_rendering')
    check('a technique with insides has a button for them', wait(
        lambda: browser.run(TEXT, '.pixel-layer') == 'Show its micro_buffer'))
    pixel = browser.run("return document.querySelector('#inspector .inspector').dataset.pixel").split()
    browser.run(CLICK, '.pixel-layer')
    check('its layer is shown, of that pixel', wait(lambda: browser.run(VALUE, 'layer') == 'micro_buffer' and [
        browser.run(VALUE, f'parameter-inspect_{axis}') for axis in 'xy'] == pixel))
    check('and has light', wait(lambda: is_whole(browser) and any(browser.run(PIXELS)[2:][0:3 * 48])))
    browser.run(SET, '#layer', '')
    browser.run(CLICK, '[aria-label="named at the start"] button')
    check('back to what was', wait(lambda: browser.run(VALUE, 'technique') == 'path_tracing'))


def inspector(browser, viewer):
    width, height = SIZE
    x, y = width // 2, 2 * height // 3
    values = browser.run(PIXELS)[2:]
    browser.run("""const c = document.querySelector('.picture'), box = c.getBoundingClientRect();
const scale = Math.min(box.width / c.width, box.height / c.height);
const at = {pointerId: 1, bubbles: true, buttons: 1, button: 0,
  clientX: box.left + (box.width - c.width * scale) / 2 + (arguments[0] + 0.5) * scale,
  clientY: box.top + (box.height - c.height * scale) / 2 + (arguments[1] + 0.5) * scale};
c.dispatchEvent(new PointerEvent('pointerdown', at)); c.dispatchEvent(new PointerEvent('pointerup', at));""", x, y)
    check('a click asks for its pixel', wait(lambda: browser.run(
        "return document.querySelector('#inspector .inspector').dataset.pixel") == f'{x} {y}'))
    rows = dict(browser.run("return [...document.querySelectorAll('#inspector tr')].map(row =>"
                            " [row.children[0].textContent, row.children[1].textContent]);"))
    linear = [float(v.replace('−', '-')) for v in rows['image'].split()]
    shown = [round(255 * (12.92 * v if v <= 0.0031308 else 1.055 * min(v, 1) ** (1 / 2.4) - 0.055)) for v in linear]
    pixel = values[4 * (y * width + x):][:3]
    check(f'with the values that are seen {shown} {pixel}', all(abs(a - b) <= 1 for a, b in zip(shown, pixel)))
    check(f'every layer, normal, material, instance {sorted(rows)}',
          {'direct', 'indirect', 'material', 'instance', 'normal'} <= set(rows) and rows['material'])
    browser.run("document.querySelector('.picture').focus()")
    browser.press('p')
    check('P asks for the middle', wait(lambda: browser.run(
        "return document.querySelector('#inspector .inspector').dataset.pixel") == f'{width // 2} {height // 2}'))
    insides(browser)
    check('with its picture', shows(browser, lambda: browser.run(PIXELS)[2:] == values))


ERRORS = """return [...document.querySelectorAll('#errors tbody tr')].map(row =>
  [...row.children].map(cell => cell.textContent));"""


def errors(browser, viewer):
    browser.run(CLICK, '#grow-reference')
    check('a reference grows and an error is measured', wait(lambda: browser.run(ERRORS)))
    first = browser.run(ERRORS)[0]
    check(f'relMSE and FLIP are numbers {first}', float(first[2]) > 0 and float(first[5]) > 0)
    browser.run(SET, '#parameter-estimator', 'bsdf')
    check('another technique joins it', wait(lambda: len(browser.run(ERRORS)) == 2))
    browser.run(SET, '#parameter-replicates', '4')
    check('noise stands apart from bias where the variance is known', wait(
        lambda: len(browser.run(ERRORS)) == 3 and browser.run(ERRORS)[2][3] not in ('', '–')))
    browser.run(CLICK, '[aria-label="named at the start"] button')
    check('and all are kept when one goes back', shows(browser, lambda: len(browser.run(ERRORS)) == 3))
    check('there is a plot', browser.run("return document.querySelector('.chart canvas').width > 100"))
    (viewer.folder / 'errors.png').write_bytes(browser.picture())
    browser.run(CLICK, '#grow-reference')
    check('without a reference there are no errors', wait(lambda: not browser.run(ERRORS)))


def edits(browser, viewer):
    before = browser.run(PIXELS)
    browser.run("document.getElementById('scene').open = true")
    browser.run(CLICK, '#add-light')
    check('a light is added', shows(browser, lambda: browser.run(PIXELS) != before))
    text = browser.run("return document.querySelector('#lights input[type=number]').value")
    check(f'at the eye ({text})', text != '')
    lit = browser.run(PIXELS)
    line = shlex.split(browser.run(TEXT, '[data-command="render"]'))
    check('the command says so', '--light' in line)
    subprocess.run([viewer.program, *line[1:-1], viewer.folder / 'lit.png', '-q', '--exposure', '0'], check=False)
    difference = largest_difference(lit, viewer.folder / 'lit.png')
    check(f'and repeats it ({difference})', difference <= 1)
    browser.run(CLICK, '[data-light="0"] input[type="checkbox"]')
    check('switched off the picture is as before', shows(browser, lambda: browser.run(PIXELS) == before))
    browser.run(CLICK, '[data-light="0"] input[type="checkbox"]')
    check('and on again', shows(browser, lambda: browser.run(PIXELS) == lit))
    browser.run(SET, '#lights input[type=number]', '0.1')
    check('a light moves', shows(browser, lambda: browser.run(PIXELS) not in (lit, before)))
    check('the sidecar holds it', wait(lambda: '"lights"' in browser.run(TEXT, '[data-command="beside the scene"]')))
    browser.run(CLICK, '#scene-reset')
    check('the scene as it was', shows(browser, lambda: browser.run(PIXELS) == before))
    browser.run(SET, '#material-roughness', '2')
    check('a value out of range is refused, and the field shows what is', wait(lambda: 'roughness=2' in browser.run(
        TEXT, '#scene-refusal') and browser.run(VALUE, 'material-roughness') == '1'))
    lamp = browser.run("return [...document.querySelectorAll('#material option')].find(o => o.text === 'lamp').value")
    browser.run(SET, '#material', lamp)
    strength = browser.run(VALUE, 'material-emissive_strength')
    browser.run(SET, '#material-emissive_strength', '0')
    check('a scene without light, too', wait(lambda: 'no light' in browser.run(TEXT, '#scene-refusal') and browser.run(
        VALUE, 'material-emissive_strength') == strength))
    browser.run(SET, '#material', '0')
    browser.run(SET, '#material-roughness', '0.123')
    check('a material changes, without what was refused before', wait(
        lambda: ':roughness=0.123 ' in browser.run(TEXT, '[data-command="render"]')))
    browser.run(CLICK, '#scene-reset')
    check('and goes back', shows(browser, lambda: browser.run(PIXELS) == before and
                                 'roughness' not in browser.run(TEXT, '[data-command="render"]')))
    recorded(browser, viewer, before)


def recorded(browser, viewer, first):
    """A walk whose keys are recorded here and there is the one that `lucarium render` goes: its frames at the times of
    the keys are the pictures that were seen then."""
    browser.run(CLICK, '#add-key')
    browser.run("document.querySelector('.picture').focus()")
    browser.press('ArrowRight')
    check('the camera turns for a second key', shows(browser, lambda: browser.run(PIXELS) != first))
    second = browser.run(PIXELS)
    browser.run(CLICK, '#add-key')
    path = browser.run(TEXT, '#path-text')
    times = [float(key.split('@')[0]) for key in path.partition(':')[2].split(';')]
    check(f'a walk of two keys is one for --camera-path {path}', path.startswith('spline:0@') and len(times) == 2)
    rate = 2 / times[1]
    viewer.render('walk.png', '--exposure', '0', '--camera-path', path, '--frames', '0:2', '--fps', str(rate))
    frames = [viewer.folder / f'walk.000{frame}.png' for frame in range(3)]
    ends = [largest_difference(seen, frame) for seen, frame in ((first, frames[0]), (second, frames[2]))]
    between = [largest_difference(seen, frames[1]) for seen in (first, second)]
    check(f'its first and last frames are what was seen at its keys {ends}, the one between is not {between}',
          max(ends) <= 1 and min(between) > 1)
    browser.run("document.querySelector('.picture').focus()")
    browser.press('Home')
    check('and back home', shows(browser, lambda: browser.run(PIXELS) == first))
