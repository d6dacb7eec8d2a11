// SPDX-License-Identifier: Apache-2.0
// Two techniques at once: how they are shown, and the handle between them.

const besideModes = [
  ['first', 'one technique'], ['split', 'split with a handle'], ['blink', 'blink'],
  ['difference', 'relative difference'], ['flip', 'FLIP']
];

class BesidePanel {
  constructor(picture, connection, chooseSide) {
    Object.assign(this, {picture, connection, chooseSide, sides: []});
    this.mode = h('select', {id: 'beside', onchange: () => this.setMode(this.mode.value)},
      besideModes.map(([value, text]) => h('option', {value}, text)));
    this.tabs = [0, 1].map(side => h('button', {type: 'button', id: `side-${side}`, 'aria-pressed': String(!side),
      onclick: () => chooseSide(side)}, ''));
    this.tabRow = h('div', {class: 'row', role: 'group', 'aria-label': 'side', hidden: true}, this.tabs);
    this.scale = slider('Scale', [-2.5, 1, 0.05], Math.log10(picture.range), v => `±${number(100 * 10 ** v, 2)} %`,
      v => {
        picture.range = 10 ** v;
        picture.changed();
        this.showLegend();
      }, 'relative luminance difference');
    this.legend = h('div', {class: 'legend'});
    this.node = h('div', {class: 'beside-choice'},
      h('div', {class: 'row'}, h('label', {class: 'control'}, h('span', {}, 'Show'), this.mode)), this.tabRow,
      this.scale, this.legend);
    this.handle = h('div', {class: 'handle', role: 'slider', tabindex: '0', 'aria-label': 'border between the sides',
      'aria-valuemin': '0', 'aria-valuemax': '100', hidden: true});
    this.labels = [0, 1].map(side => h('div', {class: `side-label side-${side}`, hidden: true}));
    this.followHandle();
    picture.listeners.push(() => this.place());
    const sizes = new ResizeObserver(() => this.place());
    sizes.observe(picture.canvas);
    picture.ended.signal.addEventListener('abort', () => sizes.disconnect());
    this.showLegend();
  }

  setMode(mode) {
    this.asked = performance.now();
    this.picture.setMode(mode);
    this.connection.send({do: 'beside', as: mode === 'first' ? 'none' : mode === 'flip' ? 'flip' : 'pictures'});
    if (mode === 'first') this.chooseSide(0);
    this.showLegend();
    this.place();
  }

  followHandle() {
    const handle = this.handle;
    handle.addEventListener('pointerdown', event => {
      if (event.isTrusted) handle.setPointerCapture(event.pointerId);
      this.dragging = true;
    });
    handle.addEventListener('pointermove', event => this.dragging && this.moveTo(event.clientX));
    for (const type of ['pointerup', 'pointercancel']) handle.addEventListener(type, () => this.dragging = false);
    handle.addEventListener('keydown', event => {
      const step = {ArrowLeft: -0.02, ArrowRight: 0.02, Home: -1, End: 1}[event.key];
      if (!step) return;
      this.setSplit(this.picture.split + step);
      event.preventDefault();
    });
  }

  // Where the picture is in the canvas's box, which may be wider.
  box() {
    const {canvas} = this.picture, box = canvas.getBoundingClientRect();
    const scale = Math.min(box.width / canvas.width, box.height / canvas.height);
    const width = canvas.width * scale, height = canvas.height * scale;
    return {left: box.left + (box.width - width) / 2, top: box.top + (box.height - height) / 2, width, height};
  }

  moveTo(clientX) {
    const box = this.box();
    this.setSplit((clientX - box.left) / box.width);
  }

  setSplit(split) {
    this.picture.split = Math.min(1, Math.max(0, split));
    this.picture.changed();
  }

  place() {
    const {picture} = this, shown = picture.mode === 'split', outer = picture.canvas.offsetParent;
    this.handle.hidden = !shown;
    const named = picture.mode === 'split' || picture.mode === 'blink';
    this.labels.forEach((label, side) => {
      label.textContent = this.labelText(side, named);
      label.hidden = !label.textContent || (picture.mode === 'blink' && picture.blink !== side);
    });
    if (!outer || this.labels.every(label => label.hidden)) return;
    const box = this.box(), origin = outer.getBoundingClientRect();
    const left = box.left - origin.left, top = box.top - origin.top;
    Object.assign(this.handle.style, {left: `${left + picture.split * box.width}px`, top: `${top}px`,
      height: `${box.height}px`});
    this.handle.setAttribute('aria-valuenow', String(Math.round(100 * picture.split)));
    Object.assign(this.labels[0].style, {left: `${left}px`, top: `${top}px`});
    Object.assign(this.labels[1].style, {right: `${origin.width - left - box.width}px`, top: `${top}px`});
  }

  // Two techniques are named. What is seen is not always what is wanted: another technique stands in, or a change has
  // failed, or brought nothing yet. Then it says whose picture it is.
  labelText(side, named) {
    const status = this.sides[side], header = this.picture.images[side]?.header;
    if (!status) return '';
    const {wanted} = status, failed = status.stage === 'failed';
    const old = header && failed && header.camera_number !== this.camera ? ', from an earlier camera' : '';
    const other = header && (failed || nameOf(header.by) !== nameOf(wanted));
    const shown = other ? `picture by ${nameOf(header.by)}${old}` : '';
    if (this.picture.mode === 'first') return side === 0 ? shown : '';
    if (!named) return shown && `${side ? 'second' : 'first'}: ${shown}`;  // what is compared
    // Two of one name differ in their parameters.
    const alike = this.sides[0].wanted.name === this.sides[1]?.wanted.name;
    const samples = !shown && status.progress ? `${number(status.progress.samples)} samples` : '';
    return [alike ? nameOf(wanted) : wanted.name, failed && 'failed', shown, samples].filter(Boolean).join(' · ');
  }

  showLegend() {
    const {mode, range} = this.picture, side = number(100 * range, 2);
    const strip = (low, table, high) => h('div', {class: 'scale'}, h('span', {}, low),
      h('span', {class: 'gradient', style: `background:${cssGradient(table)}`}), h('span', {}, high));
    this.scale.hidden = mode !== 'difference';
    this.legend.replaceChildren(
      ...(mode === 'difference' ? [strip(`second darker −${side} %`, divergingTable(), `+${side} % brighter`)] : []),
      ...(mode === 'flip' ? [strip('FLIP 0', magmaTable, '1'), this.mean = h('span', {class: 'note'})] : []));
  }

  update(status) {
    const two = status.beside !== 'none';
    // Another page may have chosen.
    if (!two && this.picture.mode !== 'first' && this.settled()) this.picture.setMode('first');
    if (two && this.picture.mode === 'first' && this.settled()) this.picture.setMode('split');
    this.mode.value = this.picture.mode;
    this.tabRow.hidden = !two;
    const [a, b] = status.sides, alike = b && a.wanted.name === b.wanted.name;
    this.sides = status.sides;
    this.camera = status.camera.number;
    status.sides.forEach(({wanted}, i) =>
      this.tabs[i].textContent = `${i ? 'Second' : 'First'}: ${alike ? nameOf(wanted) : wanted.name}`);
    const flip = this.picture.images[flipSlot]?.header.flip;
    if (this.mean && flip !== undefined) this.mean.textContent = `mean ${number(flip)}`;
    this.place();
  }

  settled() {
    return !this.asked || performance.now() - this.asked > 600;
  }

  mark(side) {
    this.tabs.forEach((tab, i) => tab.setAttribute('aria-pressed', String(i === side)));
  }
}
