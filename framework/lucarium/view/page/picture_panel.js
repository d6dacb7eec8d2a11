// SPDX-License-Identifier: Apache-2.0
// Exposure, tone, layer; pause, restart, files.

class PicturePanel {
  constructor(picture, connection) {
    this.picture = picture;
    this.connection = connection;
    this.exposure = slider('Exposure', [-12, 12, 0.1], 0, v => `${number(v)} stops`,
      v => this.quiet || picture.setExposure(v, false), 'brackets [ and ] on the picture');
    this.automatic = h('input', {type: 'checkbox', checked: true, id: 'auto-exposure',
      onchange: event => picture.setExposure(picture.stops, event.target.checked)});
    this.layer = h('select', {id: 'layer',
      onchange: event => connection.send({do: 'layer', name: event.target.value})});
    this.pause = h('button', {type: 'button', class: 'pause',
      onclick: () => connection.send({do: 'pause', on: !this.paused})},
      'Pause');
    const save = kind => h('button', {type: 'button', class: `save-${kind}`,
      onclick: () => connection.send({do: 'save', kind, exposure: picture.stops})}, `Save ${kind.toUpperCase()}`);
    this.node = h('details', {class: 'panel', open: true}, h('summary', {}, 'Picture'),
      h('div', {class: 'row'}, this.exposure,
        h('label', {class: 'control', for: 'auto-exposure'}, this.automatic, h('span', {}, 'automatic'))),
      h('div', {class: 'row'},
        selectBox('Tone', [['clip', 'clip, as PNG files'], ['reinhard', 'Reinhard']], picture.curve,
          v => picture.setCurve(v)),
        h('label', {class: 'control'}, h('span', {}, 'Layer'), this.layer)),
      h('div', {class: 'row'}, this.pause,
        h('button', {type: 'button', onclick: () => connection.send({do: 'restart'})}, 'Restart'),
        save('exr'), save('png')));
    picture.listeners.push(() => this.showExposure());
    this.showExposure();
    picture.on('keydown', event => {
      if (event.key === '[' || event.key === ']')
        picture.setExposure(picture.stops + (event.key === ']' ? 0.5 : -0.5), false);
      if (event.key === ' ') {
        connection.send({do: 'pause', on: !this.paused});
        event.preventDefault();
      }
    });
  }

  showExposure() {
    this.quiet = true;
    this.exposure.setValue(this.picture.stops);
    this.quiet = false;
    this.automatic.checked = this.picture.automatic;
  }

  update(status) {
    this.paused = status.paused;
    this.pause.textContent = status.paused ? 'Continue' : 'Pause';
    const names = ['', ...status.layers];
    if (names.join('\n') !== this.names) {
      this.names = names.join('\n');
      this.layer.replaceChildren(...names.map(name => h('option', {value: name}, name || 'image')));
    }
    this.layer.value = status.layer;
  }
}

// Hands a file of the viewer to the reader.
function keepFile({header, rest}) {
  const address = URL.createObjectURL(new Blob([rest]));
  h('a', {href: address, download: header.file}).click();
  setTimeout(() => URL.revokeObjectURL(address), 60000);
}
