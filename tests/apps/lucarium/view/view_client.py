#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""What pages and strangers say to `lucarium view`, without a browser: view_client.py WORD... starts the command line
`WORD...`, which must be a viewer with a small picture, talks to it over sockets and ends it. One line per check: "ok …"
or "FAILED …", then "end"."""
import base64
import json
import os
import signal
import socket
import struct
import subprocess
import sys
import threading
import time
import urllib.parse

PATIENCE = 120  # seconds; a busy machine is slow, not wrong


def check(name, passed):
    print('ok' if passed else 'FAILED', name, flush=True)


def request(place, path, method='GET', **headers):
    """The status of an HTTP request, its headers in small letters, its body."""
    lines = [f'{method} {path} HTTP/1.1'] + [f'{k.replace("_", "-")}: {v}' for k, v in headers.items() if v is not None]
    with socket.create_connection(place, PATIENCE) as connection:
        connection.sendall(('\r\n'.join(lines) + '\r\n\r\n').encode())
        data = b''
        while part := connection.recv(65536):
            data += part
            head, found, body = data.partition(b'\r\n\r\n')
            fields = dict(line.lower().split(': ', 1) for line in head.decode().split('\r\n')[1:] if ': ' in line)
            if found and len(body) >= int(fields.get('content-length', 1 << 40)):
                break
    if not data:
        return 0, {}, b''
    return int(data.split()[1]), fields, body


class Page:
    """A WebSocket to the viewer."""

    def __init__(self, place, path, host=None, origin=None, protocol='lucarium-view'):
        host = host or f'127.0.0.1:{place[1]}'
        self.socket = socket.create_connection(place, PATIENCE)
        key = base64.b64encode(os.urandom(16)).decode()
        self.socket.sendall((f'GET {path} HTTP/1.1\r\nHost: {host}\r\nOrigin: {origin or "http://" + host}\r\n'
                             f'Upgrade: websocket\r\nConnection: Upgrade\r\nSec-WebSocket-Key: {key}\r\n'
                             f'Sec-WebSocket-Protocol: {protocol}\r\nSec-WebSocket-Version: 13\r\n\r\n').encode())
        self.data, self.sending = b'', threading.Lock()
        try:
            while b'\r\n\r\n' not in self.data:
                part = self.socket.recv(65536)
                if not part:
                    break
                self.data += part
        except ConnectionError:
            pass
        head, _, self.data = self.data.partition(b'\r\n\r\n')
        self.open = head.startswith(b'HTTP/1.1 101')

    def send(self, message, kind=1):
        payload = message if isinstance(message, bytes) else message.encode()
        length = struct.pack('!BB', 0x80 | kind, 0x80 | len(payload)) if len(payload) < 126 else \
            struct.pack('!BBH', 0x80 | kind, 0x80 | 126, len(payload)) if len(payload) < 65536 else \
            struct.pack('!BBQ', 0x80 | kind, 0x80 | 127, len(payload))
        with self.sending:
            self.socket.sendall(length + bytes(4) + payload)

    def take(self, count):
        while len(self.data) < count:
            part = self.socket.recv(1 << 20)
            if not part:
                raise EOFError
            self.data += part
        taken, self.data = self.data[:count], self.data[count:]
        return taken

    def receive(self):
        """The next text as what JSON says, the next picture or file as its header."""
        kind, length = self.take(2)
        length &= 127
        if length == 126:
            length, = struct.unpack('!H', self.take(2))
        elif length == 127:
            length, = struct.unpack('!Q', self.take(8))
        payload = self.take(length)
        if kind & 15 == 8:
            raise EOFError
        if kind & 15 == 2:
            size, = struct.unpack('<I', payload[:4])
            return {'binary': json.loads(payload[4:4 + size])}
        if kind & 15 == 9:
            self.send(payload, 10)  # else the viewer takes the page for lost
        return json.loads(payload) if kind & 15 == 1 else self.receive()

    def until(self, holds):
        """The first message of which that holds."""
        end = time.monotonic() + PATIENCE
        while time.monotonic() < end:
            message = self.receive()
            if 'picture' in message.get('binary', {}):
                self.send(json.dumps({'do': 'shown', 'picture': message['binary']['picture']}))
            if holds(message):
                return message
        raise TimeoutError


def refused_requests(place, path, host):
    own = {'Host': host}
    status, headers, body = request(place, path, **own)
    check('the page is served', status == 200 and b'<!DOCTYPE html>' in body)
    policy = headers.get('content-security-policy', '')
    check('with a policy that keeps strangers out',
          "default-src 'none'" in policy and "frame-ancestors 'none'" in policy)
    check('scripts and style too', all(
        request(place, path + name, **own)[0] == 200 for name in ('view.js', 'view.css')))
    check('other names are not there', request(place, path + 'view.html', **own)[0] == 404 and
          request(place, path + '../../../etc/passwd', **own)[0] in (403, 404))
    check('nothing without the token', request(place, '/', **own)[0] == 403)
    check('nothing for another token', request(place, f'/{"0" * 32}/', **own)[0] == 403 and
          request(place, path[:-2] + '/', **own)[0] == 403)
    check('nothing for a stranger\'s host', request(place, path, Host='evil.example')[0] == 403 and
          request(place, path, Host=None)[0] in (0, 400, 403))
    check('nothing but GET', request(place, path, 'POST', Content_Length='0', **own)[0] in (0, 403, 405))


def refused_sockets(place, path, host):
    check('a socket of the page opens', Page(place, path + 'socket').open)
    check('not without the token', not Page(place, '/socket').open and not Page(place, f'/{"0" * 32}/socket').open)
    check('not from another origin', not Page(place, path + 'socket', origin='http://evil.example').open)
    check('not under a stranger\'s host', not Page(place, path + 'socket', host='evil.example').open)
    check('not of another protocol', not Page(place, path + 'socket', protocol='http').open)


def saved(page):
    """The header of a file, once there is a whole picture."""
    while True:
        page.send('{"do": "save", "kind": "png", "exposure": 0}')
        message = page.until(lambda m: 'file' in m.get('binary', {}) or 'error' in m)
        if 'binary' in message:
            return message['binary']
        time.sleep(0.2)


def malformed(place, path):
    page = Page(place, path + 'socket')
    for name, data, kind in (('no JSON', '{', 1), ('another message', '{"do": "dance"}', 1), ('bytes', b'\0\1\2', 2),
                             ('a long one', 'x' * 100000, 1), ('no message at all', '', 1)):
        page.send(data, kind)
        check(f'{name}: answered with an error', 'error' in page.until(lambda m: 'answer' in m))
    page.send('{"do": "technique", "name": "no_such", "parameters": []}')
    check('an unknown technique is refused with the reason',
          'no_such' in page.until(
              lambda m: 'status' in m and m['status']['sides'][0]['refusal'])['status']['sides'][0]['refusal'])
    check('a file comes', saved(page)['file'] == 'picture.png')
    return page


def status_where(page, holds):
    return page.until(lambda m: 'status' in m and holds(m['status']))['status']


def inspector(page):
    """The constant technique's picture is blue; the room's back wall lies behind the middle."""
    page.send('{"do": "inspect", "x": 1000000, "y": 2}')
    seen = status_where(page, lambda s: s['inspected'])['inspected']
    check('a pixel outside is the last one', seen['x'] > 0 and seen['y'] == 2)
    page.send(json.dumps({'do': 'inspect', 'x': seen['x'] // 2, 'y': 4}))
    seen = status_where(page, lambda s: s['inspected']['y'] == 4 and s['inspected']['sides'])['inspected']
    surface = seen['surface']
    length = sum(v * v for v in surface['normal']) ** 0.5
    check(f'a pixel shows values and surface {seen}', abs(seen['sides'][0]['layers']['image'][2] - 0.25) < 1e-6 and
          surface['material_name'] and surface['distance'] > 0 and abs(length - 1) < 1e-4)
    rows = dict(seen['sides'][0]['insides'])
    check(f'and what the technique says of it {rows}', rows['colour'] == '0.25 0.5 0.25' and
          rows['seen at'].startswith(f'{seen["x"]} {seen["y"]} of triangle '))
    page.send(json.dumps({'do': 'technique', 'name': 'constant', 'parameters': [['blue', '0.5'],
                                                                                ['converge_at', '2']]}))
    side = status_where(page, lambda s: s['sides'][0]['stage'] == 'done' and s['inspected']['sides'] and
                        s['inspected']['sides'][0]['layers']['image'][2] == 0.5)['inspected']['sides'][0]
    check(f'another technique that is done at once says its own {side["insides"]}',
          dict(side['insides']).get('colour') == '0.25 0.5 0.5')
    page.send(json.dumps({'do': 'technique', 'name': 'constant', 'parameters': [['blue', '0.25']]}))


def edits(page):
    """Lights, materials, time; a file is none of the page's business."""
    def ask(identity, **members):
        page.send(json.dumps({'do': 'scene', 'lights': None, 'materials': [], 'environment': '', **members,
                              'id': identity}))
        return page.until(lambda m: m.get('answer') == identity).get('error')
    check('an environment file is refused', 'opens no file' in (ask(10, environment='/etc/passwd.hdr') or ''))
    check('a malformed light is refused', 'bulb' in (ask(11, lights=['bulb']) or ''))
    check('and a material', 'roughness' in (ask(12, materials=['white:roughness=2']) or ''))
    check('a light is added', ask(13, lights=['point:0,1,0:1,2,3']) is None)
    scene = page.until(lambda m: 'scene' in m)['scene']
    check('which every page hears', scene['lights'][0]['text'] == 'point:0,1,0:1,2,3')
    check('a material that is not there is refused', ask(14, materials=['no_such:roughness=0.5']) is None and
          'no_such' in status_where(page, lambda s: s['scene_refusal'])['scene_refusal'])
    check('the scene as it was', ask(15) is None and page.until(lambda m: 'scene' in m)['scene']['lights'] == [])


def failures(page):
    """A technique that has thrown is forgotten with the next one, be that refused."""
    def side(name, parameters, holds):
        page.send(json.dumps({'do': 'technique', 'name': name, 'parameters': parameters}))
        return status_where(page, lambda s: holds(s['sides'][0]))['sides'][0]
    failed = side('constant', [['failure', 'exception'], ['fail_at', '1']], lambda s: s['stage'] == 'failed')
    check(f'a technique that throws shows its message {failed["failure"]}',
          'an exception that is no Error' in failed['failure'])
    page.send('{"do": "layer", "name": "direct"}')
    page.send(json.dumps({'do': 'technique', 'name': 'constant', 'parameters': [['blue', '0.5']]}))
    by = page.until(lambda m: m.get('binary', {}).get('layer') == 'direct')['binary']['by']
    check(f'pictures say whose they are {by}', by == {'name': 'constant', 'parameters': [['blue', '0.5']]})
    page.send('{"do": "layer", "name": ""}')
    side('constant', [['failure', 'exception'], ['fail_at', '1']], lambda s: s['stage'] == 'failed')
    refused = side('no_such', [], lambda s: 'no_such' in s['refusal'])
    check(f'which is gone when the next one is refused {refused["failure"]}', refused['failure'] == '')
    running = side('constant', [['blue', '0.25']], lambda s: s['stage'] == 'rendering' and 'running' in s)
    check('and the viewer lives on', running['failure'] == '' and running['refusal'] == '')


def reference(page):
    page.send('{"do": "reference", "on": true}')
    truth = status_where(page, lambda s: s['truth']['on'] and (s['truth']['obstacle'] or s['truth']['references']))
    check('a reference is wanted, or cannot be had', truth['truth']['on'])
    # What shows a new picture begins at the reference's time: a reference that has grown long goes on growing.
    page.send(json.dumps({'do': 'technique', 'name': 'constant', 'parameters': [['sleep', '50'],
                                                                                ['converge_at', '40']]}))
    status_where(page, lambda s: s['sides'][0]['stage'] == 'done')
    time.sleep(3)
    page.send('{"do": "restart", "id": 20}')
    page.until(lambda m: m.get('answer') == 20)  # what was on its way is read

    def samples(stage):
        status = status_where(page, lambda s: s['sides'][0]['stage'] == stage)
        return status['truth']['references'][0]['samples']
    first = samples('rendering')
    counts = [first]
    while (status := status_where(page, lambda s: True))['sides'][0]['stage'] == 'rendering':
        counts.append(status['truth']['references'][0]['samples'])
    check(f'it grows beside a technique that has begun again {counts}', counts[-1] > first)
    page.send('{"do": "reference", "on": false}')
    check('and no more', status_where(page, lambda s: not s['truth']['on'])['truth']['references'] == [])


def several(place, path, first):
    second = Page(place, path + 'socket')
    check('a second page watches', second.until(lambda m: 'control' in m)['control'] is False)
    check('and sees the picture', second.until(lambda m: 'picture' in m.get('binary', {})))
    second.send('{"do": "pause", "on": true, "id": 1}')
    check('but may not control', 'error' in second.until(lambda m: m.get('answer') == 1))
    second.send('{"do": "control"}')
    check('until it takes control', second.until(lambda m: m.get('control')))
    check('which the first one hears', first.until(lambda m: m.get('control') is False))
    return second


def main():
    viewer = subprocess.Popen(sys.argv[1:], stdout=subprocess.PIPE, text=True)
    address = urllib.parse.urlparse(viewer.stdout.readline().strip())
    place, path = (address.hostname, address.port), address.path
    check('the address is of this machine, with a token', address.hostname == '127.0.0.1' and len(path) == 34)
    refused_requests(place, path, address.netloc)
    refused_sockets(place, path, address.netloc)
    page = malformed(place, path)
    inspector(page)
    edits(page)
    failures(page)
    reference(page)
    second = several(place, path, page)
    sleeping = Page(place, path + 'socket')  # takes nothing from now on
    second.send('{"do": "restart"}')
    check('a sleeping page holds up nobody', all(second.until(lambda m: 'picture' in m.get('binary', {}))
                                                 for _ in range(3)))
    begin = time.monotonic()
    viewer.send_signal(signal.SIGINT)
    code = viewer.wait(PATIENCE)
    check(f'Ctrl-C ends it in order, soon ({time.monotonic() - begin:.2f} s)', code == 0)
    try:
        while True:
            second.receive()
    except (EOFError, ConnectionError):
        check('and its pages hear of it', True)
    sleeping.socket.close()
    print('end')


if __name__ == '__main__':
    main()
