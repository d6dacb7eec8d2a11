// SPDX-License-Identifier: Apache-2.0
// The reader of PackedImage (framework/lucarium/compare/report/packed_image.h).

// Half floats as numbers, by their bits.
const halfValues = (() => {
  const table = new Float32Array(65536);
  for (let bits = 0; bits < 65536; ++bits) {
    const exponent = (bits >> 10) & 31, mantissa = bits & 1023, sign = bits & 0x8000 ? -1 : 1;
    table[bits] = sign *
        (exponent === 31 ? (mantissa ? NaN : Infinity) :
             exponent    ? (1 + mantissa / 1024) * 2 ** (exponent - 15) :
                           mantissa * 2 ** -24);
  }
  return table;
})();

async function inflate(base64) {
  const text = atob(base64), packed = new Uint8Array(text.length);
  for (let i = 0; i < text.length; ++i) packed[i] = text.charCodeAt(i);
  const stream = new Blob([packed]).stream().pipeThrough(new DecompressionStream('deflate'));
  return new Uint8Array(await new Response(stream).arrayBuffer());
}

// Rows of one plane of integer codes; the predictors are those of packed_image.cpp.
function decodeRow(plane, width, y, kind, bytes, low, high) {
  const row = y * width;
  for (let x = 0; x < width; ++x) {
    const above = y > 0 ? plane[row + x - width] : x > 0 ? plane[row + x - 1] : 0;
    const left = x > 0 ? plane[row + x - 1] : above;
    let prediction = left;
    if (kind === 1)
      prediction = above;
    else if (kind === 2)
      prediction = (left + above) >> 1;
    else if (kind === 3) {
      const corner = x > 0 && y > 0 ? plane[row + x - width - 1] : above;
      const gradient = left + above - corner, least = Math.min(left, above), most = Math.max(left, above);
      prediction = gradient < least ? least : gradient > most ? most : gradient;
    }
    const zigzag = bytes[low + x] | (bytes[high + x] << 8);
    plane[row + x] = prediction + (zigzag & 1 ? -(zigzag >> 1) - 1 : zigzag >> 1);
  }
}

// { width, height, channels, scale, bits }: `bits` are half floats, interleaved; a value is halfValues[bits] · scale.
// 8-bit images have the codes 0 … 255 in `bits`, and `unit` set.
async function decodeImage(entry, base64) {
  const {width, height, channels} = entry, pixels = width * height, rows = height * channels;
  const bytes = await inflate(base64);
  const planes = [];
  for (let c = 0; c < channels; ++c) {
    const plane = new Int32Array(pixels);
    for (let y = 0; y < height; ++y) {
      const row = c * height + y, low = rows + row * width;
      decodeRow(plane, width, y, bytes[row], bytes, low, low + pixels * channels);
    }
    planes.push(plane);
  }
  const image =
      {width, height, channels, divisor: entry.divisor, scale: 2 ** entry.exponent, unit: entry.mantissa_bits === 0};
  image.bits = new Uint16Array(pixels * channels);
  const shift = image.unit ? 0 : 10 - entry.mantissa_bits;
  const toBits = code => (code < 0 ? 0x8000 | (-code << shift) : code << shift);
  for (let i = 0; i < pixels; ++i) {
    const first = planes[0][i];
    if (channels === 1) {
      image.bits[i] = toBits(first);
    } else {
      image.bits[3 * i] = toBits(first + planes[1][i]);
      image.bits[3 * i + 1] = toBits(first);
      image.bits[3 * i + 2] = toBits(first + planes[2][i]);
    }
  }
  return image;
}
