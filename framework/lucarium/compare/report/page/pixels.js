// SPDX-License-Identifier: Apache-2.0
// Arithmetic on decoded images.

const channelValue = (image, pixel, c) =>
    halfValues[image.bits[image.channels === 3 ? 3 * pixel + c : pixel]] * image.scale;

// Luminance of every pixel, Rec. 709; kept with the image.
function luminance(image) {
  if (image.luminance) return image.luminance;
  const y = new Float32Array(image.width * image.height), bits = image.bits, scale = image.scale;
  for (let i = 0; i < y.length; ++i) {
    y[i] = scale *
        (image.channels === 1 ? halfValues[bits[i]] :
                                0.2126 * halfValues[bits[3 * i]] + 0.7152 * halfValues[bits[3 * i + 1]] +
                 0.0722 * halfValues[bits[3 * i + 2]]);
  }
  return (image.luminance = y);
}

function meanLuminance(image) {
  if (image.mean !== undefined) return image.mean;
  let sum = 0, count = 0;
  for (const y of luminance(image))
    if (Number.isFinite(y)) {
      sum += y;
      ++count;
    }
  return (image.mean = count ? sum / count : 0);
}

// (Y − Y_ref) / (Y_ref + 0.01 mean Y_ref): signed relative error of every pixel; undefined when sizes differ.
function relativeError(test, reference) {
  if (test.width !== reference.width || test.height !== reference.height) return undefined;
  const y = luminance(test), truth = luminance(reference), floor = 0.01 * meanLuminance(reference) || 1e-30;
  const error = new Float32Array(y.length);
  for (let i = 0; i < y.length; ++i) error[i] = (y[i] - truth[i]) / (Math.abs(truth[i]) + floor);
  return error;
}

const canvasOf = (width, height) => Object.assign(document.createElement('canvas'), {width, height});

function paint(width, height, colorAt) {
  const canvas = canvasOf(width, height), context = canvas.getContext('2d');
  const data = context.createImageData(width, height), out = new Uint32Array(data.data.buffer);
  for (let i = 0; i < out.length; ++i) out[i] = colorAt(i);
  context.putImageData(data, 0, 0);
  return canvas;
}

const isBad = bits => (bits & 0x7c00) === 0x7c00;

function paintImage(image, stops) {
  const table = exposureTable(image.scale * 2 ** stops), bits = image.bits;
  if (image.channels === 1) {
    return paint(
        image.width, image.height,
        i => (isBad(bits[i]) ? nonFiniteColor : packColor(table[bits[i]], table[bits[i]], table[bits[i]])));
  }
  return paint(image.width, image.height, i => {
    const r = bits[3 * i], g = bits[3 * i + 1], b = bits[3 * i + 2];
    return isBad(r) || isBad(g) || isBad(b) ? nonFiniteColor : packColor(table[r], table[g], table[b]);
  });
}

// Errors of −range … range on the diverging scale.
function paintError(error, width, height, range) {
  const table = divergingTable(), half = (scaleSteps - 1) / 2;
  return paint(width, height, i => {
    const e = error[i];
    if (Number.isNaN(e)) return nonFiniteColor;
    return table[Math.round(half * (1 + Math.min(1, Math.max(-1, e / range))))];
  });
}

function paintFlip(image) {
  return paint(image.width, image.height, i => magmaTable[Math.min(255, image.bits[i])]);
}
