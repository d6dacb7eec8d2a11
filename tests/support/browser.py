# SPDX-License-Identifier: Apache-2.0
"""Chromium through its driver (WebDriver over HTTP), for the tests of pages."""
import atexit
import base64
import json
import subprocess
import time
import urllib.request

PATIENCE = 480  # seconds; a busy machine is slow, not wrong, and report_browser_test ends what takes longer than 540
END = time.monotonic() + PATIENCE
KEYS = {'ArrowRight': '\ue014', 'ArrowLeft': '\ue012', 'Escape': '\ue00c', 'Tab': '\ue004', 'Home': '\ue011'}


class Browser:
    """One session of chromedriver."""

    def __init__(self, browser, driver, folder):
        self.driver = subprocess.Popen([driver, '--port=0'], stdout=subprocess.PIPE, stderr=subprocess.DEVNULL,
                                       text=True)
        atexit.register(self.driver.kill)  # also where no session begins
        port = None
        for line in self.driver.stdout:  # "ChromeDriver was started successfully on port N."
            if 'started successfully on port' in line:
                port = line.rstrip().rstrip('.').split()[-1]
                break
        self.url = f'http://127.0.0.1:{port}/session'
        options = {'binary': browser, 'args': ['--headless', '--no-sandbox', '--disable-gpu', '--window-size=1280,900',
                                               f'--user-data-dir={folder}/profile']}
        capabilities = {'browserName': 'chrome', 'goog:chromeOptions': options, 'goog:loggingPrefs': {'browser': 'ALL'},
                        'timeouts': {'script': PATIENCE * 1000, 'pageLoad': PATIENCE * 1000}}
        answer = self.call('', {'capabilities': {'alwaysMatch': capabilities}})
        self.url += '/' + answer['sessionId']

    def call(self, path, body=None, method=None):
        data = None if body is None else json.dumps(body).encode()
        request = urllib.request.Request(self.url + path, data, {'Content-Type': 'application/json'},
                                         method=method or ('GET' if data is None else 'POST'))
        with urllib.request.urlopen(request, timeout=PATIENCE) as answer:
            return json.load(answer)['value']

    def run(self, script, *arguments):
        return self.call('/execute/sync', {'script': script, 'args': list(arguments)})

    def press(self, key):
        key = KEYS.get(key, key)
        strokes = [{'type': 'keyDown', 'value': key}, {'type': 'keyUp', 'value': key}]
        self.call('/actions', {'actions': [{'type': 'key', 'id': 'keys', 'actions': strokes}]})

    def devtools(self, command, **parameters):
        return self.call('/goog/cdp/execute', {'cmd': command, 'params': parameters})

    def media(self, **features):
        """prefers-color-scheme and the medium (screen or print), as the reader's system says."""
        self.devtools('Emulation.setEmulatedMedia', **features)

    def picture(self):
        return base64.b64decode(self.call('/screenshot'))

    def close(self):
        try:
            self.call('', method='DELETE')
        except OSError:
            pass
        self.driver.terminate()
        self.driver.wait()


def wait(condition):
    """Waits for what is waited for."""
    while time.monotonic() < END:
        if condition():
            return True
        time.sleep(0.1)
    return False


def check(name, passed):
    print('ok' if passed else 'FAILED', name, flush=True)
