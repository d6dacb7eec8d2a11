// SPDX-License-Identifier: Apache-2.0
// Values of all pictures at the pixel under the pointer.

function inspector(viewer) {
  const node = h('div', {class: 'inspector', role: 'status'});
  let turn = 0;
  const show = async () => {
    const pixel = viewer.pixel, mine = ++turn;
    if (!pixel) {
      node.replaceChildren(
          h('p', {class: 'hint'}, 'Point at a picture to see its values; click to hold a pixel, Escape to let go.'));
      return;
    }
    const rows = await Promise.all(viewer.sources().map(source => pixelRow(viewer, source, pixel)));
    if (mine !== turn) return;
    const head = ['', 'R', 'G', 'B', 'luminance', 'relative error', 'FLIP'].map(t => h('th', {scope: 'col'}, t));
    node.replaceChildren(
        h('table', {class: 'numbers'},
          h('caption', {}, `Pixel ${pixel.x}, ${pixel.y}${viewer.pinned ? ' (held)' : ''}, linear Rec. 709`),
          h('thead', {}, h('tr', {}, head)), h('tbody', {}, rows)));
  };
  viewer.listeners.push(show);
  show();
  return node;
}

async function pixelRow(viewer, source, pixel) {
  const image = await viewer.image(source);
  const label = h('th', {scope: 'row'}, source.variant === undefined ? null : marker(source.variant), source.label);
  if (!image) return h('tr', {}, label, h('td', {colspan: '6'}, 'not there'));
  const index = of => Math.min(of.height - 1, Math.floor(pixel.y / of.divisor)) * of.width +
      Math.min(of.width - 1, Math.floor(pixel.x / of.divisor));
  const at = index(image), error = source.variant === undefined ? undefined : await viewer.error(source);
  const flip = source.variant === undefined ? undefined : await viewer.image(source, 'flip');
  const cells = [0, 1, 2].map(c => number(channelValue(image, at, c)));
  cells.push(number(luminance(image)[at]));
  cells.push(error ? percent(error[at]) : '');
  cells.push(flip && !viewer.layer ? number(flip.bits[index(flip)] / 255, 2) : '');
  return h('tr', {}, label, cells.map(c => h('td', {}, c)));
}
