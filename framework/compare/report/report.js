'use strict';
const data = JSON.parse(document.getElementById('data').textContent);
const element = (tag, attributes = {}, ...children) => {
  const node = document.createElement(tag);
  for (const [key, value] of Object.entries(attributes)) node.setAttribute(key, value);
  node.append(...children);
  return node;
};
const number = (value, digits = 3) => value === 0 ? '0' : Number(value).toPrecision(digits);

document.getElementById('summary').textContent = data.summary;

function table(scene) {
  const head = element('tr', {}, ...['technique', 'seeds', 'samples', 'iterate [s]', 'prepare [s]', 'compile [s]',
    'relMSE', 'lowest … highest', 'RMSE', 'memory [MB]'].map(t => element('th', { scope: 'col' }, t)));
  const body = scene.rows.map(row => {
    const cells = row.failure
      ? [row.label, element('span', { class: 'note' }, row.failure), '', '', '', '', '', '', '', '']
      : [row.label, row.seeds, row.samples, number(row.seconds), number(row.prepare_seconds), number(row.compile_seconds),
         number(row.relmse), `${number(row.relmse_low)} … ${number(row.relmse_high)}`, number(row.rmse),
         Math.round(row.peak_memory_bytes / 1e6)];
    const line = element('tr', row.best ? { class: 'best' } : {}, ...cells.map(c => element('td', {}, c)));
    if (row.note) line.firstChild.append(element('div', { class: 'note' }, row.note));
    return line;
  });
  return element('table', {}, element('thead', {}, head), element('tbody', {}, ...body));
}

// Dot plot of relMSE on a logarithmic axis, with the reference's own error as a line.
function plot(scene) {
  const rows = scene.rows.filter(r => !r.failure && r.relmse > 0);
  if (!rows.length) return '';
  const values = rows.flatMap(r => [r.relmse_low, r.relmse_high]).concat(scene.reference_relmse > 0 ? [scene.reference_relmse] : []);
  const low = Math.floor(Math.log10(Math.min(...values))), high = Math.max(low + 1, Math.ceil(Math.log10(Math.max(...values))));
  const width = 900, left = 330, step = 26, height = rows.length * step + 34;
  const x = v => left + (Math.log10(v) - low) / (high - low) * (width - left - 20);
  let svg = '';
  for (let e = low; e <= high; ++e) {
    svg += `<line x1="${x(10 ** e)}" x2="${x(10 ** e)}" y1="4" y2="${height - 24}"/><text x="${x(10 ** e)}" y="${height - 8}" text-anchor="middle">1e${e}</text>`;
  }
  if (scene.reference_relmse > 0) {
    const at = x(scene.reference_relmse);
    svg += `<line class="limit" x1="${at}" x2="${at}" y1="4" y2="${height - 24}"><title>the reference's own error</title></line>`;
  }
  rows.forEach((row, i) => {
    const y = i * step + 18;
    svg += `<text x="${left - 10}" y="${y + 4}" text-anchor="end">${row.label.replace(/[<&]/g, '')}</text>`
      + `<line class="range" x1="${x(row.relmse_low)}" x2="${x(row.relmse_high)}" y1="${y}" y2="${y}"/>`
      + `<circle class="dot" cx="${x(row.relmse)}" cy="${y}" r="5"/>`;
  });
  const figure = element('figure', { style: 'margin:0' });
  figure.innerHTML = `<svg role="img" aria-label="relMSE per technique" viewBox="0 0 ${width} ${height}" width="100%">${svg}</svg>`
    + '<figcaption class="caption">relMSE (lower is better), mean and range over seeds; dashed: the reference\'s own error.</figcaption>';
  return figure;
}

// Two pictures in one frame: left of the split one, right of it the other; zoom and pan move both.
function viewer(scene) {
  const left = element('img', { alt: 'left picture', draggable: 'false' }), right = element('img', { alt: 'right picture', draggable: 'false' });
  const cover = element('div', { class: 'right' }, right);
  const stage = element('div', { class: 'stage', tabindex: '0', 'aria-label': 'comparison of two pictures' }, left, cover);
  const split = element('input', { type: 'range', min: '0', max: '100', value: '100', 'aria-label': 'split position' });
  const view = { zoom: 1, x: 0, y: 0 };
  const chosen = { left: 0, right: scene.pictures.length - 1 };
  const buttons = { left: [], right: [] };
  const update = () => {
    left.src = scene.pictures[chosen.left].data;
    right.src = scene.pictures[chosen.right].data;
    for (const side of ['left', 'right']) buttons[side].forEach((b, i) => b.setAttribute('aria-pressed', i === chosen[side]));
    const transform = `translate(${view.x}px, ${view.y}px) scale(${view.zoom})`;
    for (const image of [left, right]) {
      image.style.transform = transform;
      image.classList.toggle('zoomed', view.zoom > 2);
    }
    cover.style.clipPath = `inset(0 0 0 ${split.value}%)`;
  };
  const bar = side => element('div', { class: 'buttons' }, `${side}: `, ...scene.pictures.map((picture, i) => {
    const button = element('button', { type: 'button', title: side === 'left' && i < 9 ? `key ${i + 1}` : '' }, picture.name);
    button.addEventListener('click', () => { chosen[side] = i; if (side === 'right' && split.value === '100') split.value = 50; update(); });
    buttons[side].push(button);
    return button;
  }));
  split.addEventListener('input', update);
  stage.addEventListener('keydown', event => {
    const count = scene.pictures.length;
    if (event.key >= '1' && event.key <= '9' && event.key <= String(count)) chosen.left = Number(event.key) - 1;
    else if (event.key === 'ArrowRight') chosen.left = (chosen.left + 1) % count;
    else if (event.key === 'ArrowLeft') chosen.left = (chosen.left + count - 1) % count;
    else if (event.key === '0') Object.assign(view, { zoom: 1, x: 0, y: 0 });
    else return;
    event.preventDefault();
    update();
  });
  stage.addEventListener('wheel', event => {
    event.preventDefault();
    const box = stage.getBoundingClientRect(), px = event.clientX - box.left, py = event.clientY - box.top;
    const zoom = Math.min(40, Math.max(1, view.zoom * Math.exp(-event.deltaY * 0.002)));
    view.x = px - (px - view.x) * zoom / view.zoom;
    view.y = py - (py - view.y) * zoom / view.zoom;
    view.zoom = zoom;
    if (zoom === 1) view.x = view.y = 0;
    update();
  }, { passive: false });
  stage.addEventListener('pointermove', event => {
    if (!(event.buttons & 1)) return;
    view.x += event.movementX;
    view.y += event.movementY;
    update();
  });
  const bars = [bar('left'), bar('right')];
  update();
  return element('div', {}, ...bars, element('div', { class: 'buttons' }, 'split ', split), stage,
    element('p', { class: 'caption' }, 'Keys on the picture: 1 to 9 or arrows flip the left one, 0 resets the zoom; wheel zooms, drag pans. Error maps: ',
      element('span', { class: 'scale' }), ' −100 % (too dark) to +100 % (too bright) of the reference\'s luminance.'));
}

for (const scene of data.scenes) {
  const section = element('section', {}, element('h2', {}, scene.name), element('p', {}, scene.text));
  for (const warning of scene.warnings) section.append(element('p', { class: 'note' }, warning));
  if (scene.rows.length) section.append(element('div', { class: 'wide' }, table(scene)), plot(scene));
  if (scene.pictures.length) section.append(viewer(scene));
  document.getElementById('scenes').append(section);
}
document.getElementById('provenance').append(
  element('details', {}, element('summary', {}, 'Parameters and provenance'), element('pre', {}, data.provenance)));
