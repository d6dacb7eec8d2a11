// SPDX-License-Identifier: Apache-2.0
// The camera as the page moves it: eye, target, vertical field of view [degrees]; y is up.

const vector = {
  add: (a, b, s = 1) => a.map((v, i) => v + s * b[i]),
  sub: (a, b) => a.map((v, i) => v - b[i]),
  length: a => Math.hypot(...a),
  scale: (a, s) => a.map(v => v * s),
  cross: (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
};

const steepest = 89 * Math.PI / 180;

// Heading and height of a direction [rad], and its length.
function toAngles(d) {
  const length = vector.length(d);
  return {heading: Math.atan2(d[0], d[2]), height: Math.asin(Math.max(-1, Math.min(1, d[1] / length))), length};
}

function fromAngles({heading, height, length}) {
  const flat = Math.cos(height) * length;
  return [Math.sin(heading) * flat, Math.sin(height) * length, Math.cos(heading) * flat];
}

function turned(direction, heading, height) {
  const angles = toAngles(direction);
  angles.heading += heading;
  angles.height = Math.max(-steepest, Math.min(steepest, angles.height + height));
  return fromAngles(angles);
}

// Right, up and forward of unit length.
function axes(camera) {
  const d = vector.sub(camera.target, camera.eye), forward = vector.scale(d, 1 / vector.length(d));
  const side = vector.cross(forward, [0, 1, 0]), length = vector.length(side);
  const right = length > 1e-6 ? vector.scale(side, 1 / length) : [1, 0, 0];
  return {right, up: vector.cross(right, forward), forward};
}

const moves = {
  // About the target.
  orbit: (c, heading, height) =>
      ({...c, eye: vector.add(c.target, turned(vector.sub(c.eye, c.target), heading, height))}),
  // About the eye.
  look: (c, heading, height) =>
      ({...c, target: vector.add(c.eye, turned(vector.sub(c.target, c.eye), heading, height))}),
  // Along the axes [m].
  shift: (c, right, up, forward) => {
    const a = axes(c);
    const by = vector.add(vector.add(vector.scale(a.right, right), a.up, up), a.forward, forward);
    return {...c, eye: vector.add(c.eye, by), target: vector.add(c.target, by)};
  },
  // To a multiple of the distance.
  approach: (c, factor) => ({...c, eye: vector.add(c.target, vector.sub(c.eye, c.target), factor)})
};

const distanceOf = camera => vector.length(vector.sub(camera.target, camera.eye));

// Sends the camera while it moves: the latest one, once a frame of the screen.
class CameraMover {
  constructor(send) {
    this.send = send;
    this.camera = undefined;
    this.moved = -Infinity;
    this.enabled = false;
  }

  // What the viewer says; the page's own moves win for a moment.
  adopt(camera) {
    if (performance.now() - this.moved > 700) this.camera = {eye: camera.eye, target: camera.target, vfov: camera.vfov};
  }

  move(change) {
    if (!this.camera || !this.enabled) return;
    this.set(change(this.camera));
  }

  set(camera) {
    if (!this.enabled) return;
    this.camera = camera;
    this.moved = performance.now();
    if (this.waiting) return;
    this.waiting = true;
    requestAnimationFrame(() => {
      this.waiting = false;
      const round = v => v.map(x => Number(x.toPrecision(7)));
      this.send({do: 'camera', eye: round(this.camera.eye), target: round(this.camera.target),
        vfov: Number(this.camera.vfov.toPrecision(5))});
    });
  }
}
