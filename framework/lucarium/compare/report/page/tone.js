// SPDX-License-Identifier: Apache-2.0
// From values to colours, by tables: one entry per half float or per step of a colour scale. Colours are 0xAABBGGRR, as
// a little-endian canvas has them.

const nonFiniteColor = 0xffff00ff;  // magenta

function packColor(r, g, b) {
  return (0xff000000 | (b << 16) | (g << 8) | r) >>> 0;
}

function srgb(linear) {
  const v = Math.min(1, Math.max(0, linear));
  return Math.round(255 * (v <= 0.0031308 ? 12.92 * v : 1.055 * v ** (1 / 2.4) - 0.055));
}

// 8-bit sRGB of every half float at a gain.
function exposureTable(gain) {
  const table = new Uint8Array(65536);
  for (let bits = 0; bits < 0x7c00; ++bits) table[bits] = srgb(halfValues[bits] * gain);
  table[0x7c00] = 255;
  return table;
}

function mixTable(stops, steps) {
  const table = new Uint32Array(steps);
  for (let i = 0; i < steps; ++i) {
    const at = i / (steps - 1) * (stops.length - 1), k = Math.min(stops.length - 2, Math.floor(at)), t = at - k;
    table[i] = packColor(...[0, 1, 2].map(c => Math.round(stops[k][c] * (1 - t) + stops[k + 1][c] * t)));
  }
  return table;
}

// Too dark is blue, too bright orange; what is right is the colour of the page.
const scaleSteps = 511;
function divergingTable() {
  return isDark() ?
      mixTable(
          [[150, 205, 255], [40, 130, 210], [16, 60, 105], [18, 21, 26], [110, 58, 8], [222, 125, 10], [255, 214, 140]],
          scaleSteps) :
      mixTable(
          [[3, 48, 97], [33, 113, 181], [146, 197, 222], [248, 248, 248], [253, 190, 110], [224, 110, 5], [110, 45, 0]],
          scaleSteps);
}

// Black over purple to pale yellow, after the stops of matplotlib's "magma".
const magmaTable = mixTable(
    [
      [0, 0, 4], [28, 16, 68], [79, 18, 123], [129, 37, 129], [181, 54, 122], [229, 80, 100], [251, 135, 97],
      [254, 194, 135], [252, 253, 191]
    ],
    256);

function cssGradient(table) {
  const stops = [];
  for (let i = 0; i <= 16; ++i) {
    const c = table[Math.round(i / 16 * (table.length - 1))];
    stops.push(`rgb(${c & 255},${(c >> 8) & 255},${(c >> 16) & 255})`);
  }
  return `linear-gradient(90deg,${stops.join(',')})`;
}
