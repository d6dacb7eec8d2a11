// SPDX-License-Identifier: Apache-2.0
// The pictures of both sides on one canvas. Exposure and tone are the page's: the viewer sends linear light.

// Curves from exposed linear light to linear display light, by name.
const toneCurves = {
  clip: v => v,
  // Reinhard et al. 2002, equation 4, with white at 4.
  reinhard: v => v * (1 + v / 16) / (1 + v)
};

// 8-bit sRGB of every half float at a gain, through a curve; a clipped picture has report/page/tone.js's table.
function toneTable(gain, curve) {
  if (curve === 'clip') return exposureTable(gain);
  const table = new Uint8Array(65536), map = toneCurves[curve];
  for (let bits = 0; bits < 0x7c00; ++bits) table[bits] = srgb(map(halfValues[bits] * gain));
  table[0x7c00] = 255;
  return table;
}

// The slot of FLIP between the sides.
const flipSlot = 2;

class Picture {
  constructor() {
    this.stops = 0;
    this.automatic = true;
    this.curve = 'clip';
    this.images = [];
    this.painted = [];
    this.mode = 'first';
    this.split = 0.5;
    this.range = 0.5;
    this.blink = 0;
    this.listeners = [];
    this.canvas = h('canvas', {class: 'picture', tabindex: '0', width: '16', height: '9', role: 'img',
      'aria-label': 'the picture; arrow keys orbit, W A S D fly'});
  }

  // Panels are made again with each connection: those before hear nothing any more.
  begin() {
    this.listeners = [];
    this.ended?.abort();
    this.ended = new AbortController();
  }

  // For as long as the present panels are there.
  on(type, listener) {
    this.canvas.addEventListener(type, listener, {signal: this.ended.signal});
  }

  get image() {
    return this.images[0];
  }

  show(image) {
    const side = image.header.side;
    this.images[side] = image;
    this.painted[side] = undefined;
    // A new exposure only where it matters: a picture that refines must not flicker.
    if (side === 0 && this.automatic && Math.abs(image.header.exposure - this.stops) > 0.35) {
      this.stops = image.header.exposure;
      this.painted = [];
    }
    this.changed();
  }

  changed() {
    this.draw();
    this.listeners.forEach(listener => listener());
  }

  setExposure(stops, automatic) {
    this.stops = automatic && this.image ? this.image.header.exposure : stops;
    this.automatic = automatic;
    this.painted = [];
    this.changed();
  }

  setCurve(curve) {
    this.curve = curve;
    this.painted = [];
    this.draw();
  }

  // first, split, blink, difference, flip
  setMode(mode) {
    if (mode === this.mode) return;
    this.mode = mode;
    if (mode === 'first') this.images.length = this.painted.length = Math.min(1, this.images.length);
    clearInterval(this.blinking);
    if (mode === 'blink') {
      this.blinking = setInterval(() => {
        this.blink = 1 - this.blink;
        this.changed();
      }, 500);
    }
    this.changed();
  }

  // Linear light as a canvas, kept until it changes.
  paintedSide(side) {
    const image = this.images[side];
    if (!image || this.painted[side]) return this.painted[side];
    if (side === flipSlot) return (this.painted[side] = paint(image.width, image.height,
      i => magmaTable[Math.round(255 * Math.min(1, channelValue(image, i, 0)))]));
    const table = toneTable(image.scale * 2 ** this.stops, this.curve), bits = image.bits;
    return (this.painted[side] = paint(image.width, image.height, i => {
      const r = bits[3 * i], g = bits[3 * i + 1], b = bits[3 * i + 2];
      return isBad(r) || isBad(g) || isBad(b) ? nonFiniteColor : packColor(table[r], table[g], table[b]);
    }));
  }

  // The second side's error against the first.
  paintedDifference() {
    const [first, second] = this.images, key = `${first.header.picture} ${second.header.picture} ${this.range} ${
      isDark()}`;
    if (this.difference?.key === key) return this.difference.canvas;
    const error = relativeError(second, first);
    const canvas = error && paintError(error, first.width, first.height, this.range);
    this.difference = {key, canvas};
    return canvas;
  }

  // [canvas, from, to]: what is seen, over which part of the width.
  layers() {
    const first = this.paintedSide(0), second = this.paintedSide(1);
    if (this.mode === 'split' && second) return [[first, 0, this.split], [second, this.split, 1]];
    if (this.mode === 'blink' && second) return [[this.blink ? second : first, 0, 1]];
    if (this.mode === 'difference' && second) return [[this.paintedDifference() || first, 0, 1]];
    if (this.mode === 'flip' && this.images[flipSlot]) return [[this.paintedSide(flipSlot), 0, 1]];
    return [[first, 0, 1]];
  }

  draw() {
    if (!this.image) return;
    const layers = this.layers();
    const width = Math.max(...layers.map(([c]) => c.width)), height = Math.max(...layers.map(([c]) => c.height));
    if (this.canvas.width !== width || this.canvas.height !== height) Object.assign(this.canvas, {width, height});
    const context = this.canvas.getContext('2d');
    for (const [canvas, from, to] of layers) {
      const x = Math.round(from * width), end = Math.round(to * width), scale = canvas.width / width;
      if (end > x)
        context.drawImage(canvas, x * scale, 0, (end - x) * scale, canvas.height, x, 0, end - x, height);
    }
    const {header} = this.image, second = this.images[1]?.header, flip = this.images[flipSlot]?.header;
    Object.assign(this.canvas.dataset, {picture: header.picture, iterations: header.iterations,
      divisor: header.divisor, camera: header.camera_number, layer: header.layer, stops: this.stops, mode: this.mode,
      second: second ? second.iterations : '', secondDivisor: second ? second.divisor : '',
      flip: flip ? flip.flip : ''});
  }
}
