// SPDX-License-Identifier: Apache-2.0
// Where techniques differ most: windows with the widest spread of error between them.

// Sums of min(|relative error|, 1) over tiles; the limit keeps single bright pixels from deciding.
function tileErrors(error, width, height, tile) {
  const columns = Math.ceil(width / tile), sums = new Float64Array(columns * Math.ceil(height / tile));
  for (let y = 0; y < height; ++y) {
    const row = Math.floor(y / tile) * columns;
    for (let x = 0; x < width; ++x) {
      const e = Math.abs(error[y * width + x]);
      sums[row + Math.floor(x / tile)] += e < 1 ? e : 1;
    }
  }
  return sums;
}

// Up to `count` windows { x, y, width, height } in pixels of the error maps, none overlapping another.
function chooseCrops(errors, width, height, count = 3) {
  const tile = Math.max(4, Math.round(width / 40)), columns = Math.ceil(width / tile), rows = Math.ceil(height / tile);
  const across = Math.min(columns, 6), down = Math.min(rows, 4);
  const sums = errors.map(error => tileErrors(error, width, height, tile));
  const candidates = [];
  for (let y = 0; y + down <= rows; ++y) {
    for (let x = 0; x + across <= columns; ++x) {
      const totals = sums.map(sum => {
        let total = 0;
        for (let j = 0; j < down; ++j)
          for (let i = 0; i < across; ++i) total += sum[(y + j) * columns + x + i];
        return total;
      });
      candidates.push({x, y, spread: totals.length > 1 ? Math.max(...totals) - Math.min(...totals) : totals[0]});
    }
  }
  candidates.sort((a, b) => b.spread - a.spread);
  const chosen = [];
  for (const c of candidates) {
    if (chosen.length === count) break;
    if (chosen.every(o => Math.abs(o.x - c.x) >= across || Math.abs(o.y - c.y) >= down)) chosen.push(c);
  }
  return chosen.map(c => ({
                      x: c.x * tile,
                      y: c.y * tile,
                      width: Math.min(across * tile, width),
                      height: Math.min(down * tile, height)
                    }));
}

// A row of magnified windows, reference first; a click shows the place in the viewer.
async function cropStrips(viewer) {
  const sources = viewer.sources(), techniques = sources.filter(s => s.variant !== undefined);
  const images = await Promise.all(sources.map(s => viewer.image(s)));
  const errors = (await Promise.all(techniques.map(s => viewer.error(s)))).filter(Boolean);
  if (!errors.length) return [];
  const full = images.find(Boolean);
  return chooseCrops(errors, full.width, full.height).map((crop, n) => {
    const cells = sources.map((source, i) => {
      if (!images[i]) return null;
      const canvas = canvasOf(crop.width, crop.height);
      const painted = viewer.paintedImage(images[i]);
      canvas.getContext('2d').drawImage(
          painted, crop.x, crop.y, crop.width, crop.height, 0, 0, crop.width, crop.height);
      const label = `${source.label}, window ${n + 1}`;
      return h(
          'button', {
            class: 'crop',
            title: 'show this place in the viewer',
            'aria-label': label,
            onclick: () => viewer.showWindow(crop, full.divisor)
          },
          canvas, h('span', {}, source.label));
    });
    return h('div', {class: 'crops'}, cells);
  });
}
