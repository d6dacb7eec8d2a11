// SPDX-License-Identifier: Apache-2.0
// Mouse, touch and keys of the viewer.

// The pane and image pixel under a pointer event.
function pointed(viewer, event) {
  const box = viewer.canvas.getBoundingClientRect();
  const x = (event.clientX - box.left) / box.width * viewer.canvas.width,
        y = (event.clientY - box.top) / box.height * viewer.canvas.height;
  const panes = viewer.panes();
  const pane = panes.find(p => x >= p.clip[0] && x < p.clip[1] && y >= p.y && y < p.y + p.height) || panes[0];
  const at = viewer.placement(pane);
  return {pane, canvasX: x, canvasY: y, x: (x - at.x) / at.scale, y: (y - at.y) / at.scale};
}

function setPixel(viewer, x, y) {
  const {width, height} = viewer.size();
  const inside = x >= 0 && y >= 0 && x < width && y < height;
  viewer.pixel = inside ? {x: Math.floor(x), y: Math.floor(y)} : null;
  viewer.changed();
}

// Keeps the image point (x, y) where it is on the screen.
function zoomAt(viewer, factor, x, y) {
  const {width, height} = viewer.size(), old = viewer.view || {zoom: 1, x: width / 2, y: height / 2};
  const zoom = Math.min(200, Math.max(1, old.zoom * factor)), keep = old.zoom / zoom;
  viewer.view = zoom === 1 ? null : {zoom, x: x + (old.x - x) * keep, y: y + (old.y - y) * keep};
  viewer.changed();
}

function panBy(viewer, dx, dy) {
  const {width, height} = viewer.size(), old = viewer.view || {zoom: 1, x: width / 2, y: height / 2};
  viewer.view = {
    zoom: old.zoom,
    x: Math.min(width, Math.max(0, old.x + dx)),
    y: Math.min(height, Math.max(0, old.y + dy))
  };
  viewer.changed();
}

function addPointerInput(viewer) {
  const canvas = viewer.canvas;
  let drag = null;
  const nearSplit = at => viewer.mode === 'split' &&
      Math.abs(at.canvasX - viewer.split * canvas.width) < 12 * (window.devicePixelRatio || 1);
  canvas.addEventListener('pointerdown', event => {
    const at = pointed(viewer, event);
    drag = {split: nearSplit(at), x: event.clientX, y: event.clientY, moved: false};
    canvas.setPointerCapture(event.pointerId);
  });
  canvas.addEventListener('pointermove', event => {
    const at = pointed(viewer, event);
    canvas.style.cursor = nearSplit(at) ? 'ew-resize' : 'crosshair';
    if (!drag) {
      if (!viewer.pinned) setPixel(viewer, at.x, at.y);
      return;
    }
    const dx = event.clientX - drag.x, dy = event.clientY - drag.y;
    if (Math.abs(dx) + Math.abs(dy) > 3) drag.moved = true;
    if (!drag.moved) return;
    drag.x = event.clientX;
    drag.y = event.clientY;
    if (drag.split) {
      viewer.split = Math.min(1, Math.max(0, at.canvasX / canvas.width));
      viewer.changed();
    } else {
      const scale = viewer.placement(at.pane).scale / (window.devicePixelRatio || 1);
      panBy(viewer, -dx / scale, -dy / scale);
    }
  });
  canvas.addEventListener('pointerup', event => {
    if (drag && !drag.moved && !drag.split) {
      const at = pointed(viewer, event);
      viewer.pinned = !viewer.pinned;
      setPixel(viewer, at.x, at.y);
    }
    drag = null;
  });
  canvas.addEventListener('pointerleave', () => {
    if (!viewer.pinned) setPixel(viewer, -1, -1);
  });
  canvas.addEventListener('wheel', event => {
    // The wheel scrolls the page until the viewer has been clicked.
    if (!event.ctrlKey && document.activeElement !== canvas) return;
    event.preventDefault();
    const at = pointed(viewer, event);
    zoomAt(viewer, 1.0015 ** -event.deltaY, at.x, at.y);
  }, {passive: false});
}

function moveKey(viewer, key, shift) {
  const step = {ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1]}[key];
  if (!step) return false;
  const {width, height} = viewer.size();
  if (shift) {
    const pixel = viewer.pixel || {x: width >> 1, y: height >> 1};
    viewer.pinned = true;
    setPixel(viewer, pixel.x + step[0], pixel.y + step[1]);
  } else {
    const zoom = viewer.view ? viewer.view.zoom : 1;
    panBy(viewer, step[0] * width / zoom / 10, step[1] * height / zoom / 10);
  }
  return true;
}

// Keys work wherever the focus is, except in fields.
function handleKey(viewer, event) {
  if (event.ctrlKey || event.metaKey || event.altKey || /^(INPUT|SELECT|TEXTAREA)$/.test(event.target.tagName)) return;
  const onCanvas = document.activeElement === viewer.canvas, all = viewer.sources();
  const centre = viewer.view || {x: viewer.size().width / 2, y: viewer.size().height / 2};
  const actions = {
    r: () => viewer.controls.choose('left', 0),
    x: () => viewer.controls.swap(),
    e: () => viewer.controls.cycleDisplay(),
    g: () => viewer.controls.setMode(viewer.mode === 'grid' ? 'split' : 'grid'),
    m: () => viewer.controls.toggleMean(),
    l: () => viewer.controls.nextLayer(),
    '[': () => viewer.controls.exposure.setValue(viewer.stops - 0.5),
    ']': () => viewer.controls.exposure.setValue(viewer.stops + 0.5),
    '+': () => zoomAt(viewer, 1.5, centre.x, centre.y),
    '=': () => zoomAt(viewer, 1.5, centre.x, centre.y),
    '-': () => zoomAt(viewer, 1 / 1.5, centre.x, centre.y),
    0: () => {
      viewer.view = null;
      viewer.changed();
    },
    Escape: () => {
      viewer.pinned = false;
      setPixel(viewer, -1, -1);
    },
  };
  if (/^[1-9]$/.test(event.key)) {
    if (Number(event.key) < all.length + 1) viewer.controls.choose('left', Number(event.key) - 1);
  } else if (actions[event.key]) {
    actions[event.key]();
  } else if (!onCanvas || !moveKey(viewer, event.key, event.shiftKey)) {
    return;
  }
  event.preventDefault();
}
