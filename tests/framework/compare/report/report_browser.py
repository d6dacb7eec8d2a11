#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""A report as a reader uses it: report_browser.py FOLDER opens FOLDER/report.html in Chromium through its driver
(WebDriver over HTTP), presses real keys, clicks, looks at it in light, dark and on paper, and reads the console. One
line per check: "ok …" or "FAILED …", then "end". Exit code 77 when Chromium or its driver is absent."""
import base64
import pathlib
import shutil
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[3] / 'support'))
from browser import Browser, check, wait  # noqa: E402

# What was asked for last has been drawn.
DRAWN = """const drawn = document.querySelector('.viewer-canvas')?.dataset;
return Boolean(drawn?.asked && drawn.drawn === drawn.asked);"""
PIXELS = """const url = document.querySelector('.viewer-canvas').toDataURL();
let sum = 0;
for (let i = 0; i < url.length; ++i) sum = (sum * 31 + url.charCodeAt(i)) % 4294967291;
return sum;"""
LUMINANCE = """const rgb = getComputedStyle(document.body).backgroundColor.match(/[0-9.]+/g).map(Number);
return .2126 * rgb[0] + .7152 * rgb[1] + .0722 * rgb[2];"""
CONTRAST = """const rgb = getComputedStyle(document.body).color.match(/[0-9.]+/g).map(Number);
return .2126 * rgb[0] + .7152 * rgb[1] + .0722 * rgb[2];"""


def keys(browser):
    """Real keys reach the viewer after a click, and every one changes or restores the picture."""
    browser.run("document.querySelector('.viewer-canvas').scrollIntoView(); "
                "document.querySelector('.viewer-canvas').focus()")
    for key in '2', '1', 'x', 'x', ']', '[', 'e', 'e', 'e', '+', 'ArrowRight', '0', 'm', 'm', 'g', 'g':
        wait(lambda: browser.run(DRAWN))
        before = browser.run(PIXELS)
        browser.press(key)
        if key in '2]e+':
            check(f'key {key} changes the picture', wait(lambda: browser.run(DRAWN) and browser.run(PIXELS) != before))
    browser.press('Tab')
    check('the keyboard leaves the viewer', browser.run("return document.activeElement.className !== 'viewer-canvas'"))


def themes(browser, address):
    for theme, dark in (('light', False), ('dark', True)):
        browser.media(features=[{'name': 'prefers-color-scheme', 'value': theme}])
        browser.call('/url', {'url': address})
        check(f'{theme}: it is drawn', wait(lambda: browser.run(DRAWN)))
        page, text = browser.run(LUMINANCE), browser.run(CONTRAST)
        check(f'{theme}: the page is {theme}', (page < 64) == dark)
        check(f'{theme}: text can be read', abs(page - text) > 120)
        check(f'{theme}: there is a picture of it', wait(lambda: len(browser.picture()) > 10000))
    browser.media(features=[])


def paper(browser):
    browser.media(media='print')
    check('print: no control is on paper except headings of tables and windows, which are pictures', browser.run(
        "return [...document.querySelectorAll('button, select, input')].every(e => e.offsetParent === null ||"
        " e.closest('table, .crops'))"))
    check('print: black on white', browser.run(LUMINANCE) > 200)
    browser.media(media='')
    document = base64.b64decode(browser.call('/print', {'background': True}))
    check('print: there are pages', document.startswith(b'%PDF') and len(document) > 10000)


def main():
    folder = pathlib.Path(sys.argv[1]).resolve()
    browser, driver = shutil.which('chromium'), shutil.which('chromedriver')
    if not browser or not driver:
        print('skipped: chromium or chromedriver is not installed')
        sys.exit(77)
    session = Browser(browser, driver, folder)
    try:
        address = (folder / 'report.html').as_uri()
        session.call('/url', {'url': address})
        check('it is drawn', wait(lambda: session.run(DRAWN)))
        keys(session)
        themes(session, address)
        paper(session)
        messages = session.call('/se/log', {'type': 'browser'})
        check(f'nothing on the console {[m["message"] for m in messages]}', not messages)
        # The controls, one by one, from inside of the page.
        session.call('/url', {'url': (folder / 'selftest.html').as_uri()})
        found = "return document.getElementById('selftest')?.textContent"
        check('the controls have been tried', wait(lambda: session.run(found)))
        print((session.run(found) or '').removesuffix('end').rstrip())
    finally:
        session.close()
    print('end')


main()
