// SPDX-License-Identifier: Apache-2.0
// Cameras of the scene, field of view, the text for a command line, bookmarks.

class CameraPanel {
  // `before`: a panel whose bookmarks and path go on.
  constructor(view, mover, connection, before) {
    Object.assign(this, {view, mover, connection});
    const chosen = event => event.target.value && this.chooseScene(event.target.value);
    this.box = h('select', {id: 'scene-camera', onchange: chosen},
      h('option', {value: ''}, 'moved'),
      view.cameras.map((camera, i) => h('option', {value: String(i)}, camera.name || `camera ${i}`)));
    this.vfov = slider('Field of view', [5, 120, 1], 40, v => `${number(v)}°`,
      v => this.quiet || mover.move(c => ({...c, vfov: v})), 'vertical; a double click sets it back');
    this.text = h('code', {class: 'line', id: 'camera-text'});
    this.marks = before?.marks ?? h('div', {class: 'row', id: 'bookmarks'});
    this.path = before?.path ?? new PathPanel(mover);
    this.time = new TimePanel(connection);
    this.node = h('details', {class: 'panel', open: true}, h('summary', {}, 'Camera'),
      h('div', {class: 'row'}, h('label', {class: 'control'}, h('span', {}, 'Camera'), this.box),
        h('button', {type: 'button', class: 'bookmark', onclick: () => this.keep()}, 'Bookmark')),
      this.marks, h('div', {class: 'row'}, this.vfov), this.text,
      copyButton('Copy for --camera', () => this.text.textContent), this.path.node, this.time.node);
  }

  chooseScene(index) {
    this.mover.moved = -Infinity;
    this.connection.send({do: 'scene_camera', index: Number(index)});
  }

  keep() {
    if (!this.mover.camera) return;
    const camera = this.mover.camera;
    this.marks.append(h('button', {type: 'button', onclick: () => this.mover.set(camera)},
      `View ${this.marks.children.length + 1}`));
  }

  update(status) {
    const camera = status.camera;
    this.mover.adopt(camera);
    this.box.value = camera.of_scene === null ? '' : String(camera.of_scene);
    this.text.textContent = camera.text;
    this.quiet = true;
    if (performance.now() - this.mover.moved > 700) this.vfov.setValue(camera.vfov);
    this.quiet = false;
  }
}

// `text` at the moment of the click. Without the right to write the clipboard the text is selected.
function copyButton(label, text) {
  const button = h('button', {type: 'button', onclick: async () => {
    try {
      await navigator.clipboard.writeText(text());
      button.textContent = 'Copied';
    } catch {
      const range = document.createRange();
      range.selectNodeContents(button.previousElementSibling);
      getSelection().removeAllRanges();
      getSelection().addRange(range);
      button.textContent = 'Selected: copy it';
    }
    setTimeout(() => button.textContent = label, 1500);
  }}, label);
  return button;
}
