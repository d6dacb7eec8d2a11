// SPDX-License-Identifier: Apache-2.0
// The WebSocket to the viewer: messages of framework/lucarium/view/protocol.h there, states and pictures back.

// The bytes of a zlib stream.
async function inflateBytes(packed) {
  const stream = new Blob([packed]).stream().pipeThrough(new DecompressionStream('deflate'));
  return new Uint8Array(await new Response(stream).arrayBuffer());
}

// { header, rest } of a binary message (framework/lucarium/view/picture_code.h).
function splitMessage(buffer) {
  const length = new DataView(buffer).getUint32(0, true);
  const header = JSON.parse(new TextDecoder().decode(new Uint8Array(buffer, 4, length)));
  return {header, rest: new Uint8Array(buffer, 4 + length)};
}

// An image as report/page/pixels.js takes it: interleaved half floats.
async function decodePicture(header, packed) {
  const planes = await inflateBytes(packed), pixels = header.width * header.height, values = 3 * pixels;
  const bits = new Uint16Array(values);
  for (let c = 0; c < 3; ++c) {
    for (let i = 0, from = c * pixels, to = c; i < pixels; ++i, ++from, to += 3)
      bits[to] = (planes[from] << 8) | planes[values + from];
  }
  return {width: header.width, height: header.height, channels: 3, scale: 2 ** header.exponent, bits, header};
}

class Connection {
  // `on`: open(), closed(), and message(name, value) for "view", "status", "control", "answer", "picture", "file".
  constructor(on) {
    this.on = on;
    this.patience = 500;
    this.answers = new Map();
    this.lastId = 0;
    this.connect();
  }

  connect() {
    const address = new URL('socket', location.href);
    address.protocol = address.protocol.replace('http', 'ws');
    this.socket = new WebSocket(address, 'lucarium-view');
    this.socket.binaryType = 'arraybuffer';
    this.socket.addEventListener('open', () => {
      this.patience = 500;
      this.on.open();
    });
    this.socket.addEventListener('close', () => {
      this.on.closed();
      this.answers.forEach(done => done('not connected'));
      this.answers.clear();
      setTimeout(() => this.connect(), this.patience);
      this.patience = Math.min(2 * this.patience, 8000);
    });
    this.socket.addEventListener('message', event => this.receive(event.data));
  }

  receive(data) {
    if (typeof data === 'string') {
      const message = JSON.parse(data);
      if ('answer' in message) return this.answered(message);
      for (const [name, value] of Object.entries(message)) this.on.message(name, value, message);
      return undefined;
    }
    const {header, rest} = splitMessage(data);
    return this.on.message(header.file ? 'file' : 'picture', {header, rest});
  }

  answered(message) {
    const done = this.answers.get(message.answer);
    this.answers.delete(message.answer);
    if (done)
      done(message.error);
    else if (message.error)
      this.on.message('error', message.error);
  }

  isOpen() {
    return this.socket.readyState === WebSocket.OPEN;
  }

  // Answered only where it is refused.
  send(message) {
    if (this.isOpen()) this.socket.send(JSON.stringify(message));
  }

  // The reason of a refusal, or undefined.
  ask(message) {
    return new Promise(done => {
      if (!this.isOpen()) return done('not connected');
      const id = ++this.lastId;
      this.answers.set(id, done);
      return this.send({...message, id});
    });
  }
}
