// SPDX-License-Identifier: Apache-2.0
// Mouse, touch and keyboard on the picture.

const radiansPerWidth = Math.PI;  // a drag across the whole picture turns half around
const heldKeys = {
  w: [0, 0, 1], s: [0, 0, -1], a: [-1, 0, 0], d: [1, 0, 0], e: [0, 1, 0], q: [0, -1, 0]
};
const turnKeys = {
  ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1]
};

class CameraInput {
  constructor(canvas, mover, home) {
    Object.assign(this, {canvas, mover, home});
    this.pointers = new Map();
    this.held = new Set();
    canvas.addEventListener('pointerdown', event => this.down(event));
    canvas.addEventListener('pointermove', event => this.drag(event));
    for (const type of ['pointerup', 'pointercancel'])
      canvas.addEventListener(type, event => this.pointers.delete(event.pointerId));
    canvas.addEventListener('wheel', event => this.wheel(event), {passive: false});
    canvas.addEventListener('contextmenu', event => event.preventDefault());
    canvas.addEventListener('keydown', event => this.press(event));
    canvas.addEventListener('keyup', event => this.held.delete(event.key.toLowerCase()));
    canvas.addEventListener('blur', () => this.held.clear());
  }

  down(event) {
    this.canvas.focus({preventScroll: true});
    if (event.isTrusted) this.canvas.setPointerCapture(event.pointerId);
    this.pointers.set(event.pointerId, {x: event.clientX, y: event.clientY});
    if (event.button === 1) event.preventDefault();
  }

  drag(event) {
    const before = this.pointers.get(event.pointerId);
    if (!before) return;
    const width = this.canvas.clientWidth || 1;
    const dx = (event.clientX - before.x) / width, dy = (event.clientY - before.y) / width;
    if (this.pointers.size === 2) this.pinch(event, before, dx, dy, width);
    this.pointers.set(event.pointerId, {x: event.clientX, y: event.clientY});
    if (this.pointers.size !== 1) return;
    if ((event.buttons & 4) || event.shiftKey)
      this.pan(dx, dy);
    else if (event.buttons & 2)
      this.mover.move(c => moves.look(c, -dx * radiansPerWidth / 2, -dy * radiansPerWidth / 2));
    else
      this.mover.move(c => moves.orbit(c, -dx * radiansPerWidth, dy * radiansPerWidth));
  }

  // Two fingers: together they pan, apart they come nearer.
  pinch(event, before, dx, dy, width) {
    const [other] = [...this.pointers].filter(([id]) => id !== event.pointerId).map(([, at]) => at);
    const distance = p => Math.max(10, Math.hypot(p.x - other.x, p.y - other.y));
    const factor = distance(before) / distance({x: event.clientX, y: event.clientY});
    this.pan(dx / 2, dy / 2);
    this.mover.move(c => moves.approach(c, factor));
  }

  // The point at the target's distance stays under the pointer; `dx`, `dy` are parts of the picture's width.
  pan(dx, dy) {
    this.mover.move(c => {
      const height = 2 * distanceOf(c) * Math.tan(c.vfov * Math.PI / 360);
      const width = height * this.canvas.width / this.canvas.height;
      return moves.shift(c, -dx * width, dy * width, 0);
    });
  }

  wheel(event) {
    event.preventDefault();
    const steps = event.deltaMode === 1 ? event.deltaY / 3 : event.deltaY / 100;
    this.mover.move(c => moves.approach(c, 1.12 ** Math.max(-4, Math.min(4, steps))));
  }

  press(event) {
    if (event.ctrlKey || event.altKey || event.metaKey) return;
    const key = event.key.length === 1 ? event.key.toLowerCase() : event.key;
    if (heldKeys[key]) {
      // A key that is let go before the next frame moves too.
      if (!this.held.has(key))
        this.mover.move(c => moves.shift(c, ...heldKeys[key].map(v => 0.02 * v * distanceOf(c))));
      if (!this.held.size) this.flyFrom(performance.now());
      this.held.add(key);
    } else if (turnKeys[key]) {
      const [x, y] = turnKeys[key], step = Math.PI / 36;
      if (event.shiftKey)
        this.pan(-0.03 * x, 0.03 * y);
      else
        this.mover.move(c => moves.orbit(c, step * x, step * y));
    } else if (key === '+' || key === '=' || key === '-') {
      this.mover.move(c => moves.approach(c, key === '-' ? 1.12 : 1 / 1.12));
    } else if (key === 'Home') {
      this.home();
    } else {
      return;
    }
    event.preventDefault();
  }

  // While keys are held: the distance to the target in about two seconds.
  flyFrom(time) {
    requestAnimationFrame(now => {
      const seconds = Math.min(0.1, Math.max(0.005, (now - time) / 1000));
      const by = [0, 0, 0];
      for (const key of this.held) heldKeys[key].forEach((v, i) => by[i] += v);
      if (by.some(v => v)) {
        this.mover.move(c => {
          const step = 0.5 * distanceOf(c) * seconds;
          return moves.shift(c, ...by.map(v => v * step));
        });
      }
      if (this.held.size) this.flyFrom(now);
    });
  }
}
