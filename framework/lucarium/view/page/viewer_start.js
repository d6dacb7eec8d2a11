// SPDX-License-Identifier: Apache-2.0
// Puts the page together, once the viewer has said what there is.

const keyHelp = [
  ['drag', 'orbit'], ['right drag', 'look around'], ['Shift drag', 'pan'], ['wheel, two fingers', 'nearer, farther'],
  ['W A S D Q E', 'fly'], ['arrows', 'orbit'], ['Shift arrows', 'pan'], ['+ −', 'nearer, farther'], ['[ ]', 'exposure'],
  ['Space', 'pause'], ['Home', 'first camera']
];

class Page {
  constructor() {
    this.picture = new Picture();
    this.line = new StateLine();
    this.notice = h('div', {role: 'alert', id: 'notice'});
    this.control = h('span', {class: 'note', id: 'control'});
    this.take = h('button', {type: 'button', id: 'take-control', hidden: true,
      onclick: () => this.connection.send({do: 'control'})}, 'Take control');
    this.connection = new Connection({
      open: () => this.notify(''),
      closed: () => this.line.closed(),
      message: (name, value, whole) => this.receive(name, value, whole)
    });
    this.mover = new CameraMover(message => this.connection.send(message));
    document.addEventListener('visibilitychange', () => this.shown());
  }

  notify(text) {
    this.notice.replaceChildren(...(text ? [h('p', {class: 'alert'}, text)] : []));
  }

  receive(name, value, whole) {
    if (name === 'view') this.build(value);
    if (name === 'status') this.update(value);
    if (name === 'control') this.setControl(value, whole.pages);
    if (name === 'picture') this.takePicture(value);
    if (name === 'file') keepFile(value);
    if (name === 'error') this.notify(value);
  }

  build(view) {
    this.view = view;
    document.title = `${view.scene} · Lucarium viewer`;
    this.technique = new TechniquePanel(view, message => this.connection.ask(message));
    this.picturePanel = new PicturePanel(this.picture, this.connection);
    this.camera = new CameraPanel(view, this.mover, this.connection);
    this.panels = [this.technique, this.picturePanel, this.camera, new MachinePanel(), new RepeatPanel(), this.line];
    if (!this.input) this.input = new CameraInput(this.picture.canvas, this.mover, () => this.camera.chooseScene(0));
    const theme = h('button', {type: 'button', id: 'theme',
      onclick: () => document.documentElement.dataset.theme = isDark() ? 'light' : 'dark'}, 'Light / dark');
    document.getElementById('top').replaceChildren(
      h('div', {class: 'title'}, h('h1', {}, 'Lucarium viewer'), h('p', {}, `${view.scene} · ${view.size.join('×')}`)),
      h('div', {class: 'controls'}, this.control, this.take, theme));
    const help = h('details', {class: 'panel'}, h('summary', {}, 'Mouse, fingers and keys'),
      h('dl', {}, keyHelp.flatMap(([keys, text]) => [h('dt', {}, keys), h('dd', {}, text)])));
    document.getElementById('main').replaceChildren(
      h('div', {class: 'stage'}, this.picture.canvas, this.line.node, this.notice),
      h('div', {class: 'panels'}, this.panels.slice(0, -1).map(panel => panel.node), help));
  }

  update(status) {
    if (!this.panels) return;
    this.panels.forEach(panel => panel.update(status));
    const text = status.stage === 'failed' ? status.failure || status.refusal : '';
    if (text !== this.failure) this.notify(text);
    this.failure = text;
  }

  setControl(mine, pages) {
    this.mover.enabled = mine;
    this.take.hidden = mine;
    this.control.textContent = mine ? (pages > 1 ? `${pages} pages; this one controls` : '') : 'another page controls';
    document.body.classList.toggle('watching', !mine);
  }

  // Of several pictures that have come the last one is drawn. One that is drawn makes room for the next.
  async takePicture(message) {
    this.latest = message;
    if (this.decoding || document.hidden) return;
    this.decoding = true;
    while (this.latest) {
      const {header, rest} = this.latest;
      this.latest = undefined;
      this.picture.show(await decodePicture(header, rest));
      this.connection.send({do: 'shown', picture: header.picture});
    }
    this.decoding = false;
  }

  // A hidden page takes no pictures.
  shown() {
    if (!document.hidden && this.latest) this.takePicture(this.latest);
  }
}

function startViewer() {
  return new Page();
}
