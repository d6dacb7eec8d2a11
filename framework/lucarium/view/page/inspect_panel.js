// SPDX-License-Identifier: Apache-2.0
// A clicked pixel: values of every layer, and the surface that is seen there.

const coordinates = (values, unit) => `${values.map(v => number(v, 4)).join(', ')}${unit ? ` ${unit}` : ''}`;

class InspectPanel {
  constructor(view, picture, connection) {
    Object.assign(this, {view, picture, connection});
    this.body = h('div', {class: 'inspector', role: 'status'},
      h('p', {class: 'hint'}, 'Click a pixel of the picture, or press P for the middle.'));
    this.node = h('details', {class: 'panel', id: 'inspector'}, h('summary', {}, 'Pixel'), this.body);
    picture.on('pointerdown', event => this.from = {x: event.clientX, y: event.clientY});
    picture.on('pointerup', event => {
      const moved = this.from ? Math.hypot(event.clientX - this.from.x, event.clientY - this.from.y) : 9;
      if (moved < 4 && event.button === 0) this.askAt(event.clientX, event.clientY);
    });
    picture.on('keydown', event => {
      if (event.key.toLowerCase() !== 'p' || event.ctrlKey || event.metaKey || event.altKey) return;
      this.ask(Math.floor(view.size[0] / 2), Math.floor(view.size[1] / 2));
    });
  }

  askAt(clientX, clientY) {
    const {canvas} = this.picture, box = canvas.getBoundingClientRect(), [width, height] = this.view.size;
    const scale = Math.min(box.width / width, box.height / height);
    const x = Math.floor((clientX - box.left - (box.width - width * scale) / 2) / scale);
    const y = Math.floor((clientY - box.top - (box.height - height * scale) / 2) / scale);
    if (x >= 0 && y >= 0 && x < width && y < height) this.ask(x, y);
  }

  ask(x, y) {
    this.node.open = true;
    this.connection.send({do: 'inspect', x, y});
  }

  update(status) {
    const seen = status.inspected, key = JSON.stringify(seen);
    if (!seen || key === this.key) return;
    this.key = key;
    const row = (name, ...cells) => h('tr', {}, h('th', {scope: 'row'}, name), cells.map(c => h('td', {}, c)));
    const table = rows => h('table', {class: 'passes'}, h('tbody', {}, rows));
    this.body.dataset.pixel = `${seen.x} ${seen.y}`;
    this.body.replaceChildren(
      h('p', {class: 'note'}, `Pixel ${seen.x}, ${seen.y}`),
      seen.obstacle ? h('p', {class: 'alert'}, seen.obstacle) : '',
      ...this.surfaceRows(seen, row, table),
      ...seen.sides.flatMap((side, index) => [h('h3', {}, side.technique), table(Object.entries(side.layers).map(
        ([name, values]) => row(name, values.map(v => (typeof v === 'string' ? v : number(v, 4))).join('  ')))),
        ...this.insides(seen, side, index, status, row, table)]));
  }

  // What the technique itself holds there: its words, and a layer that shows the insides of one pixel.
  insides(seen, side, index, status, row, table) {
    const nodes = side.insides.length ? [table(side.insides.map(([name, text]) => row(name, text)))] : [];
    const shown = this.view.techniques.find(t => t.name === side.technique)?.pixel_layer;
    if (!shown) return nodes;
    const given = new Map(status.sides[index].wanted.parameters);
    given.set(shown.x, String(seen.x)).set(shown.y, String(seen.y));
    const show = () => {
      this.connection.send({do: 'technique', name: side.technique, parameters: [...given], side: index});
      this.connection.send({do: 'layer', name: shown.layer});
    };
    return [...nodes, h('button', {type: 'button', class: 'pixel-layer', onclick: show}, `Show its ${shown.layer}`)];
  }

  surfaceRows(seen, row, table) {
    const s = seen.surface;
    if (!seen.known) return [h('p', {class: 'note'}, 'The camera has moved: click again for the surface.')];
    if (!s) return [h('p', {}, 'nothing but the environment')];
    return [table([
      row('material', `${s.material_name || 'unnamed'} (${s.material})`),
      row('instance', `${s.instance}${s.mesh ? ` of ${s.mesh}` : ''}, triangle ${s.triangle}`),
      row('position', coordinates(s.position, 'm')), row('distance', `${number(s.distance, 4)} m`),
      row('normal', coordinates(s.normal)), row('shading normal', coordinates(s.shading))
    ])];
  }
}
