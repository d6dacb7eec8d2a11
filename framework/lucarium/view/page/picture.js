// SPDX-License-Identifier: Apache-2.0
// The picture on its canvas. Exposure and tone are the page's: the viewer sends linear light.

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

class Picture {
  constructor() {
    this.stops = 0;
    this.automatic = true;
    this.curve = 'clip';
    this.image = undefined;
    this.listeners = [];
    this.canvas = h('canvas', {class: 'picture', tabindex: '0', width: '16', height: '9', role: 'img',
      'aria-label': 'the picture; arrow keys orbit, W A S D fly'});
  }

  show(image) {
    this.image = image;
    // A new exposure only where it matters: a picture that refines must not flicker.
    if (this.automatic && Math.abs(image.header.exposure - this.stops) > 0.35) this.stops = image.header.exposure;
    this.draw();
    this.listeners.forEach(listener => listener());
  }

  setExposure(stops, automatic) {
    this.stops = automatic && this.image ? this.image.header.exposure : stops;
    this.automatic = automatic;
    this.draw();
    this.listeners.forEach(listener => listener());
  }

  setCurve(curve) {
    this.curve = curve;
    this.draw();
  }

  draw() {
    if (!this.image) return;
    const {width, height, bits, scale, header} = this.image;
    const table = toneTable(scale * 2 ** this.stops, this.curve);
    if (this.canvas.width !== width || this.canvas.height !== height) Object.assign(this.canvas, {width, height});
    const context = this.canvas.getContext('2d'), data = context.createImageData(width, height);
    const out = new Uint32Array(data.data.buffer);
    for (let i = 0, k = 0; i < out.length; ++i, k += 3) {
      const r = bits[k], g = bits[k + 1], b = bits[k + 2];
      out[i] = isBad(r) || isBad(g) || isBad(b) ? nonFiniteColor : packColor(table[r], table[g], table[b]);
    }
    context.putImageData(data, 0, 0);
    Object.assign(this.canvas.dataset, {picture: header.picture, iterations: header.iterations,
      divisor: header.divisor, camera: header.camera_number, layer: header.layer, stops: this.stops});
  }
}
