#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""What happens to a page as time goes by: life_browser.py PROGRAM FOLDER plays an animation, loses the connection, is
watched by a second tab. FOLDER is for what it writes. One line per check: "ok …" or "FAILED …", then "end". Exit code
77 when Chromium or its driver is absent."""
import pathlib
import shutil
import sys

from viewer_page import CLICK, DATA, STAGE, TEXT, VALUE, Viewer

from browser import Browser, check, wait

# Sockets, and for each the pictures that it has brought and those that were acknowledged to it. Nothing is unpacked
# while the gate is closed.
KEEP_SOCKETS = """window.sockets = [];
window.WebSocket = class extends WebSocket {
  constructor(...words) {
    super(...words);
    sockets.push(this);
    this.brought = [];
    this.acknowledged = [];
    this.addEventListener('message', ({data}) => {
      if (typeof data === 'string') return;
      const length = new DataView(data).getUint32(0, true);
      this.brought.push(JSON.parse(new TextDecoder().decode(new Uint8Array(data, 4, length))).picture);
    });
  }
  send(text) {
    const message = JSON.parse(text);
    if (message.do === 'shown') this.acknowledged.push(message.picture);
    super.send(text);
  }
};
window.gate = Promise.resolve();
window.held = 0;
const {arrayBuffer} = Response.prototype;
Response.prototype.arrayBuffer = async function() {
  const bytes = await arrayBuffer.call(this);
  ++held;
  await gate;
  --held;
  return bytes;
};"""
SHUT = "window.gate = new Promise(open => window.openGate = open);"
TIME = "return Number(document.getElementById('time').value);"
SCRUB = """const bar = document.getElementById('time');
bar.value = arguments[0];
bar.dispatchEvent(new Event('input', {bubbles: true}));
return Number(bar.value);"""
MADE = """return [document.querySelectorAll('#bookmarks button').length,
  document.getElementById('path-text').textContent,
  [...document.querySelectorAll('select')].map(box => box.value), document.querySelector('.picture').dataset.stops,
  [...document.querySelectorAll('details')].map(panel => panel.open)];"""
SELECT = """const box = [...document.querySelectorAll('select')].find(node =>
  [...node.options].some(option => option.value === arguments[0]));
box.value = arguments[0];
box.dispatchEvent(new Event('change', {bubbles: true}));"""


def play(browser):
    check('a scene that moves has a slider of time', wait(
        lambda: browser.run("return !document.getElementById('animation').hidden")))
    duration = float(browser.run("return document.getElementById('time').max"))
    browser.run(CLICK, '#play')
    check('it plays', wait(lambda: browser.run(TIME) > 0))
    browser.run(CLICK, '#play')
    begin = browser.run(SCRUB, str(duration / 2))
    check('it can be scrubbed', wait(lambda: browser.run(TIME) == begin))
    first = browser.run(CLICK + TIME, '#play')  # at once: no time passes between them
    check(f'and plays on from there, not from its beginning ({first})', abs(first - begin) < 0.02 * duration)
    scrubbed = browser.run(SCRUB, str(duration / 4))
    later = browser.run(TIME)
    check(f'a slider that is moved while it plays is followed ({scrubbed}, {later})',
          wait(lambda: browser.run(TIME) != scrubbed) and scrubbed <= later)
    paused = browser.run(CLICK + TIME, '#play')
    resumed = browser.run(CLICK + TIME, '#play')
    check(f'a pause keeps the time ({paused}, {resumed})', abs(resumed - paused) < 0.02 * duration)
    browser.run(CLICK, '#play')


def connected_again(browser):
    browser.run(CLICK, '.bookmark')
    browser.run(CLICK, '#add-key')
    browser.run(CLICK, '#add-key')
    browser.run(SELECT, 'reinhard')
    browser.run("document.getElementById('scene').open = true;")
    browser.run("document.querySelector('.picture').focus()")
    browser.press(']')
    before = browser.run(MADE)
    check(f'bookmark, path, tone and exposure are made {before}', before[0] == 1 and before[1] and
          'reinhard' in before[2])
    count = browser.run('return sockets.length')
    browser.run('sockets.at(-1).close()')
    check('a connection that is lost is made again', wait(lambda: browser.run(
        'return sockets.length > arguments[0] && sockets.at(-1).readyState === 1', count)) and wait(
            lambda: browser.run(STAGE) == 'rendering'))
    after = browser.run(MADE)
    check(f'and the page is as it was {after}', after == before)


def acknowledged(browser):
    """A picture that is being unpacked while the connection is lost belongs to no picture of the next one."""
    browser.run(SHUT)
    check('a picture waits to be unpacked', wait(lambda: browser.run('return held > 0')))
    browser.run(CLICK, '.pause')
    count = browser.run('return sockets.length')
    browser.run('sockets.at(-1).close()')
    check('another connection brings a picture', wait(lambda: browser.run(
        'return sockets.length > arguments[0] && sockets.at(-1).brought.length > 0', count)))
    browser.run('openGate(); window.gate = Promise.resolve();')
    check('which is shown', wait(lambda: browser.run('return sockets.at(-1).acknowledged.length > 0')))
    browser.run(CLICK, '.pause')
    check('and those that follow', wait(lambda: browser.run('return sockets.at(-1).acknowledged.length > 4')))
    brought, shown = browser.run('return [sockets.at(-1).brought, sockets.at(-1).acknowledged];')
    check(f'each is acknowledged once, to the connection that has brought it {brought[:3]} {shown[:3]}',
          set(shown) <= set(brought) and len(set(shown)) == len(shown))


def watched(browser, viewer):
    browser.run(CLICK, '#play')
    first = browser.call('/window')
    second = browser.call('/window/new', {'type': 'tab'})['handle']
    browser.call('/window', {'handle': second})
    browser.call('/url', {'url': viewer.address})
    wait(lambda: browser.run(TEXT, '#control'))
    check('the time of the page that controls is seen on others', wait(lambda: browser.run(TIME) > 0))
    browser.run(CLICK, '.pause')
    check('a page that watches hears that', wait(lambda: 'another page' in browser.run(TEXT, '#notice')))
    check('where it is seen', browser.run("""const box = document.querySelector('#notice').getBoundingClientRect();
return box.height > 0 && box.top >= 0 && box.bottom <= innerHeight;"""))
    browser.run(CLICK, '#take-control')
    check('until it has control', wait(lambda: browser.run(TEXT, '#notice') == '' and browser.run(
        "return document.getElementById('take-control').hidden")))
    browser.call('/window', {'handle': first})
    check('the other one plays no more', wait(lambda: browser.run(TEXT, '#play') == 'Play'))
    check(f'and has heard of nothing else {browser.run(TEXT, "#notice")}', browser.run(TEXT, '#notice') == '')


def main():
    program, folder = sys.argv[1], pathlib.Path(sys.argv[2]).resolve()
    chromium, driver = shutil.which('chromium'), shutil.which('chromedriver')
    if not chromium or not driver:
        print('skipped: chromium or chromedriver is not installed')
        sys.exit(77)
    viewer = Viewer(program, folder, ['builtin:statue', '--size', '24x16'])
    browser = Browser(chromium, driver, folder)
    try:
        browser.devtools('Page.addScriptToEvaluateOnNewDocument', source=KEEP_SOCKETS)
        browser.call('/url', {'url': viewer.address})
        check('the picture comes', wait(lambda: int(browser.run(DATA).get('iterations', 0)) > 0))
        play(browser)
        connected_again(browser)
        acknowledged(browser)
        watched(browser, viewer)
        messages = browser.call('/se/log', {'type': 'browser'})
        check(f'nothing on the console {[m["message"] for m in messages]}', not messages)
        check('Ctrl-C ends the viewer', viewer.end() == 0)
    finally:
        browser.close()
        viewer.process.kill()
    print('end')


main()
