// SPDX-License-Identifier: Apache-2.0
// A walk of the camera, recorded as keys, and the time of the scene's animation.

const keyNumber = v => String(Number(v.toPrecision(6)));

function keyText({seconds: at, camera}) {
  const point = p => p.map(keyNumber).join(',');
  return `${keyNumber(at)}@${point(camera.eye)}:${point(camera.target)}:${keyNumber(camera.vfov)}`;
}

class PathPanel {
  constructor(mover) {
    this.mover = mover;
    this.keys = [];
    this.interval = h('input', {type: 'number', id: 'key-interval', min: '0.1', step: 'any', value: '2'});
    this.kind = selectBox('Curve', [['spline', 'smooth'], ['linear', 'straight']], 'spline', kind => {
      this.interpolation = kind;
      this.show();
    });
    this.interpolation = 'spline';
    this.list = h('div', {class: 'row', id: 'camera-keys'});
    this.text = h('code', {class: 'line', id: 'path-text'});
    this.node = h('details', {class: 'camera-path'}, h('summary', {}, 'Camera path'),
      h('div', {class: 'row'},
        h('button', {type: 'button', id: 'add-key', onclick: () => this.add()}, 'Add this camera'),
        h('label', {class: 'control', for: 'key-interval'}, h('span', {}, 'after [s]'), this.interval), this.kind),
      this.list, this.text, copyButton('Copy for --camera-path', () => this.text.textContent));
  }

  add() {
    if (!this.mover.camera) return;
    const last = this.keys.at(-1), step = Math.max(0.1, Number(this.interval.value) || 2);
    this.keys.push({seconds: last ? last.seconds + step : 0, camera: this.mover.camera});
    this.show();
  }

  show() {
    this.list.replaceChildren(...this.keys.map((key, i) => h('span', {class: 'key'},
      h('button', {type: 'button', onclick: () => this.mover.set(key.camera)}, seconds(key.seconds)),
      h('button', {type: 'button', 'aria-label': `remove the key at ${seconds(key.seconds)}`, onclick: () => {
        this.keys.splice(i, 1);
        this.show();
      }}, '×'))));
    this.text.textContent = this.keys.length < 2 ? '' :
        `${this.interpolation}:${this.keys.map(keyText).join(';')}`;
  }
}

class TimePanel {
  constructor(connection) {
    this.connection = connection;
    this.play = h('button', {type: 'button', id: 'play', onclick: () => this.toggle()}, 'Play');
    this.bar = h('input', {type: 'range', id: 'time', min: '0', max: '1', step: '0.01', 'aria-label': 'time [s]',
      oninput: () => {
        this.playFrom(Number(this.bar.value));
        this.go(Number(this.bar.value));
      }});
    this.readout = h('output', {}, '');
    this.node = h('div', {class: 'row', id: 'animation', hidden: true}, h('span', {class: 'note'}, 'Animation'),
      this.play, this.bar, this.readout);
  }

  setScene(scene) {
    this.duration = scene.duration;
    this.node.hidden = !(scene.duration > 0);
    this.bar.max = String(scene.duration);
    if (!this.asked()) this.show(scene.time);
  }

  // What was asked for a moment ago is not undone by what was on its way.
  asked() {
    return this.wanted !== undefined || performance.now() - this.moved < 700;
  }

  show(time) {
    this.present = time;
    this.bar.value = String(time);
    this.readout.textContent = seconds(time);
  }

  go(time) {
    this.show(time);
    this.wanted = time;
    this.moved = performance.now();
    clearTimeout(this.timer);
    this.timer = setTimeout(() => {
      this.wanted = undefined;
      this.sent = Number(time.toFixed(4));
      this.connection.send({do: 'time', seconds: this.sent});
    }, 20);
  }

  // A picture of that time is on the screen: the next one may come. Another page may have asked for it.
  shown(time) {
    if (this.playing) {
      if (Math.abs(time - this.sent) < 1e-3) this.step();
    } else if (!this.asked() && this.duration > 0) {
      this.show(time);
    }
  }

  toggle() {
    this.setPlaying(!this.playing);
  }

  setPlaying(playing) {
    this.playing = playing;
    this.play.textContent = playing ? 'Pause animation' : 'Play';
    this.playFrom(this.present || 0);
    if (playing) this.step();
  }

  playFrom(time) {
    this.began = performance.now() - 1000 * time;
  }

  // Where the wall clock is; a slow technique shows fewer pictures, not a slower motion.
  step() {
    if (this.playing) this.go(((performance.now() - this.began) / 1000) % this.duration);
  }
}
