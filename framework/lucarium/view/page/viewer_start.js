// SPDX-License-Identifier: Apache-2.0
// Puts the page together, once the viewer has said what there is.

const keyHelp = [
  ['drag', 'orbit'], ['right drag', 'look around'], ['Shift drag', 'pan'], ['wheel, two fingers', 'nearer, farther'],
  ['W A S D Q E', 'fly'], ['arrows', 'orbit'], ['Shift arrows', 'pan'], ['+ −', 'nearer, farther'], ['[ ]', 'exposure'],
  ['P', 'pixel in the middle'], ['click', 'pixel'], ['Space', 'pause'], ['Home', 'first camera']
];

class Page {
  constructor() {
    this.picture = new Picture();
    this.latest = new Map();
    this.line = new StateLine();
    this.notice = h('div', {role: 'alert', id: 'notice'});
    this.control = h('span', {class: 'note', id: 'control'});
    this.take = h('button', {type: 'button', id: 'take-control', hidden: true,
      onclick: () => this.connection.send({do: 'control'})}, 'Take control');
    this.connection = new Connection({
      open: () => this.notify(''),
      closed: () => this.closed(),
      message: (name, value, whole) => this.receive(name, value, whole)
    });
    this.mover = new CameraMover(message => this.connection.send(message));
    document.addEventListener('visibilitychange', () => this.shown());
  }

  // Over the picture, where it is seen; until it is closed, or void.
  notify(text) {
    this.notice.replaceChildren(...(text ? [h('p', {class: 'alert'}, text), h('button', {type: 'button',
      'aria-label': 'close the message', onclick: () => this.notify('')}, '×')] : []));
  }

  // What this connection has brought is not acknowledged to the next one.
  closed() {
    this.latest.clear();
    this.failure = '';
    this.line.closed();
  }

  receive(name, value, whole) {
    if (name === 'view') this.build(value);
    if (name === 'scene') this.setScene(value);
    if (name === 'status') this.update(value);
    if (name === 'control') this.setControl(value, whole.pages);
    if (name === 'picture') this.takePicture(value);
    if (name === 'file') keepFile(value);
    if (name === 'error') this.notify(value);
  }

  // Connected again, the page stays as it is; where the program has changed, what the reader has made stays.
  build(view) {
    const text = JSON.stringify(view), open = this.panels && this.openPanels();
    if (text === this.viewText) return;
    this.viewText = text;
    this.view = view;
    document.title = `${view.scene} · Lucarium viewer`;
    this.side = 0;
    this.picture.begin();
    this.beside = new BesidePanel(this.picture, this.connection, side => this.chooseSide(side));
    this.technique = new TechniquePanel(view, message => this.connection.ask(message), this.beside.node);
    this.picturePanel = new PicturePanel(this.picture, this.connection);
    this.camera = new CameraPanel(view, this.mover, this.connection, this.camera);
    this.scene = new ScenePanel(this.connection);
    this.inspect = new InspectPanel(view, this.picture, this.connection);
    this.panels = [this.technique, this.picturePanel, this.camera, new TruthPanel(this.connection), this.inspect,
      this.scene, new MachinePanel(), new RepeatPanel(), this.line];
    if (!this.input) this.input = new CameraInput(this.picture.canvas, this.mover, () => this.camera.chooseScene(0));
    const theme = h('button', {type: 'button', id: 'theme',
      onclick: () => {
        document.documentElement.dataset.theme = isDark() ? 'light' : 'dark';
        drawCharts();
        this.picture.changed();
      }}, 'Light / dark');
    document.getElementById('top').replaceChildren(
      h('div', {class: 'title'}, h('h1', {}, 'Lucarium viewer'), h('p', {}, `${view.scene} · ${view.size.join('×')}`)),
      h('div', {class: 'controls'}, this.control, this.take, theme));
    const help = h('details', {class: 'panel'}, h('summary', {}, 'Mouse, fingers and keys'),
      h('dl', {}, keyHelp.flatMap(([keys, text]) => [h('dt', {}, keys), h('dd', {}, text)])));
    document.getElementById('main').replaceChildren(
      h('div', {class: 'stage'},
        h('div', {class: 'frame'}, this.picture.canvas, this.beside.handle, this.beside.labels, this.notice),
        this.line.node),
      h('div', {class: 'panels'}, this.panels.slice(0, -1).map(panel => panel.node), help));
    open?.forEach((isOpen, i) => this.panels[i].node.open = isOpen);
  }

  openPanels() {
    return this.panels.map(panel => panel.node.open);
  }

  setScene(scene) {
    this.scene.setScene(scene);
    this.camera.time.setScene(scene);
  }

  update(status) {
    if (!this.panels) return;
    this.status = status;
    this.beside.update(status);
    if (this.side >= status.sides.length && this.beside.settled()) this.chooseSide(0);
    const side = status.sides[this.side] || status.sides[0];
    this.panels.forEach(panel => panel.update({...status, ...side}));
    const text = side.stage === 'failed' ? side.failure || side.refusal : '';
    if (text !== this.failure) this.notify(text);
    this.failure = text;
  }

  // Whose parameters, state and costs the panels show.
  chooseSide(side) {
    this.side = side;
    this.technique.setSide(side);
    this.beside.mark(side);
    if (this.status?.sides[side]) this.update(this.status);
  }

  setControl(mine, pages) {
    if (mine && !this.mover.enabled) this.notify(this.failure || '');
    if (!mine) this.camera?.time.setPlaying(false);
    this.mover.enabled = mine;
    this.take.hidden = mine;
    this.control.textContent = mine ? (pages > 1 ? `${pages} pages; this one controls` : '') : 'another page controls';
    document.body.classList.toggle('watching', !mine);
  }

  // Of several pictures of a side that have come the last one is drawn. One that is drawn makes room for the next.
  async takePicture(message) {
    this.latest.set(message.header.side, message);
    if (this.decoding || document.hidden) return;
    this.decoding = true;
    while (this.latest.size) {
      const [[side, {header, rest}]] = this.latest, {socket} = this.connection;
      this.latest.delete(side);
      this.picture.show(await decodePicture(header, rest));
      if (side === 0) this.camera?.time.shown(header.time);
      if (socket === this.connection.socket) this.connection.send({do: 'shown', picture: header.picture});
    }
    this.decoding = false;
  }

  // A hidden page takes no pictures.
  shown() {
    const [waiting] = this.latest.values();
    if (!document.hidden && waiting) this.takePicture(waiting);
  }
}

function startViewer() {
  return new Page();
}
