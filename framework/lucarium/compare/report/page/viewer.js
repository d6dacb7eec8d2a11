// SPDX-License-Identifier: Apache-2.0
// The pictures of one scene and budget. What is shown is state; draw() paints all of it. Coordinates of the view are
// pixels of the unreduced image.

// Positions of the two pictures that are seen first: the first technique, and on its left the reference of its light.
function openingPair(sources) {
  const technique = sources.findIndex(source => source.variant !== undefined);
  const truth = technique < 0 ?
      -1 :
      sources.findIndex(source => source.variant === undefined && source.reference === sources[technique].reference);
  return truth < 0 ? [0, Math.min(1, sources.length - 1)] : [truth, technique];
}

class Viewer {
  constructor(scene, budget) {
    this.scene = scene;
    this.budget = budget;
    this.stops = scenes[scene].exposure_stops || 0;
    this.range = 0.5;
    this.layer = '';
    this.useMean = false;
    this.mode = 'split';
    this.split = 0.5;
    this.gridAs = 'image';
    this.view = null;
    this.pixel = null;
    this.pinned = false;
    this.painted = new Map();
    this.errors = new Map();
    this.listeners = [];
    const [left, right] = openingPair(this.sources());
    this.left = {source: left, as: 'image'};
    this.right = {source: right, as: 'image'};
    this.canvas = h('canvas', {class: 'viewer-canvas', tabindex: '0', role: 'img'});
    new ResizeObserver(() => this.draw()).observe(this.canvas);
  }

  // Reference(s) and all techniques that have an image here.
  sources() {
    if (this.sourceList) return this.sourceList;
    const references = listOf(scenes[this.scene], 'references');
    const list = [];
    references.forEach((entry, reference) => {
      if (findImage({kind: 'reference', scene: this.scene, reference}) < 0) return;
      list.push({label: references.length > 1 ? `reference ${reference + 1}` : 'reference', reference});
    });
    variants.forEach((entry, variant) => {
      if (findImage({kind: 'image', scene: this.scene, variant, budget: this.budget}) < 0) return;
      list.push({label: entry.label, variant, reference: sceneVariant(this.scene, variant).reference || 0});
    });
    return (this.sourceList = list);
  }

  entryId(source, kind) {
    const {scene, budget, layer} = this, {variant, reference} = source;
    if (variant === undefined)
      return findImage(
          layer ? {kind: 'layer', of: 'reference', scene, reference, layer} : {kind: 'reference', scene, reference});
    if (kind === 'flip') return findImage({kind: 'flip', scene, variant, budget});
    if (layer) return findImage({kind: 'layer', of: 'image', scene, variant, budget, layer});
    const mean = this.useMean ? findImage({kind: 'mean', scene, variant, budget}) : -1;
    return mean >= 0 ? mean : findImage({kind: 'image', scene, variant, budget});
  }

  async image(source, kind) {
    const id = this.entryId(source, kind);
    return id < 0 ? undefined : Object.assign(await loadImage(id), {id});
  }

  // Signed relative luminance error against the technique's reference, in the layer that is shown.
  async error(source) {
    const id = this.entryId(source), truthId = this.entryId({reference: source.reference});
    const key = `${id}:${truthId}`;
    if (id < 0 || truthId < 0) return undefined;
    if (!this.errors.has(key)) {
      const [test, truth] = await Promise.all([loadImage(id), loadImage(truthId)]);
      this.errors.set(key, relativeError(test, truth));
    }
    return this.errors.get(key);
  }

  paintedImage(image) {
    return this.cached(`image ${image.id} ${this.stops}`, `image ${image.id} `, () => paintImage(image, this.stops));
  }

  // Keeps one canvas per prefix: the one for the present exposure or range.
  cached(key, prefix, make) {
    const old = this.painted.get(prefix);
    if (old && old.key === key) return old.canvas;
    const canvas = make();
    this.painted.set(prefix, {key, canvas});
    return canvas;
  }

  // { canvas, divisor } or { note } of what a pane shows.
  async picture(source, as) {
    if (as === 'error' && source.variant !== undefined) {
      const image = await this.image(source), error = await this.error(source);
      if (!error) return {note: this.layer ? 'not in this layer' : 'sizes differ'};
      const prefix = `error ${image.id} `;
      return {
        divisor: image.divisor,
        canvas: this.cached(
            `${prefix}${this.range} ${isDark()}`, prefix,
            () => paintError(error, image.width, image.height, this.range))
      };
    }
    if (as === 'flip' && source.variant !== undefined) {
      const image = await this.image(source, 'flip');
      if (!image) return {note: 'no FLIP map'};
      return {
        divisor: image.divisor,
        canvas: this.cached(`flip ${image.id}`, `flip ${image.id}`, () => paintFlip(image))
      };
    }
    const image = await this.image(source);
    return image ? {divisor: image.divisor, canvas: this.paintedImage(image)} : {note: `no layer "${this.layer}"`};
  }

  size() {
    const entry = imageList.images.find(e => e.scene === this.scene && (e.kind === 'reference' || e.kind === 'image'));
    return entry ? {width: entry.width * entry.divisor, height: entry.height * entry.divisor} : {width: 16, height: 9};
  }

  // Rectangles of the panes, in pixels of the canvas, and what they show.
  panes() {
    const all = this.sources(), width = this.canvas.width, height = this.canvas.height;
    if (this.mode === 'split') {
      return [
        {...this.left, x: 0, y: 0, width, height, clip: [0, this.split * width]},
        {...this.right, x: 0, y: 0, width, height, clip: [this.split * width, width]}
      ];
    }
    const columns = gridColumns(all.length), rows = Math.ceil(all.length / columns);
    const w = width / columns, hgt = height / rows;
    return all.map((source, i) => ({ source: i, as: this.gridAs, x: (i % columns) * w, y: Math.floor(i / columns) * hgt,
      width: w, height: hgt, clip: [(i % columns) * w, (i % columns + 1) * w] }));
  }

  fitScale(pane) {
    const {width, height} = this.size();
    return Math.min(pane.width / width, pane.height / height);
  }

  // Position of the image in a pane: canvas = origin + scale · image.
  placement(pane) {
    const {width, height} = this.size(), fit = this.fitScale(pane);
    const view = this.view || {zoom: 1, x: width / 2, y: height / 2};
    const scale = fit * view.zoom;
    return {scale, x: pane.x + pane.width / 2 - scale * view.x, y: pane.y + pane.height / 2 - scale * view.y};
  }

  changed() {
    this.draw();
    this.listeners.forEach(listener => listener());
  }

  // Paints when the pictures are there; of several calls only the last one paints. The canvas says which was asked for
  // last and which was drawn: all is drawn when they are equal.
  async draw() {
    const turn = (this.turn = (this.turn || 0) + 1);
    this.canvas.dataset.asked = String(turn);
    await new Promise(done => setTimeout(done));
    if (turn !== this.turn || !this.canvas.isConnected) return;
    this.resize();
    const panes = this.panes(), all = this.sources();
    const pictures =
        await Promise.all(panes.map(p => this.picture(all[p.source], p.as).catch(error => ({note: error.message}))));
    if (turn !== this.turn) return;
    const context = this.canvas.getContext('2d');
    context.fillStyle = cssColor('--well');
    context.fillRect(0, 0, this.canvas.width, this.canvas.height);
    panes.forEach((pane, i) => drawPane(context, this, pane, pictures[i], all[pane.source]));
    this.canvas.setAttribute('aria-label', `${panes.map(p => `${all[p.source].label} (${p.as})`).join(' beside ')}`);
    this.canvas.dataset.drawn = String(turn);
  }

  resize() {
    const box = this.canvas.getBoundingClientRect(), ratio = window.devicePixelRatio || 1;
    const {width, height} = this.size(), panes = this.mode === 'grid' ? this.sources().length : 1;
    const columns = this.mode === 'grid' ? gridColumns(panes) : 1;
    const wanted =
        Math.min(box.width / columns * height / width * Math.ceil(panes / columns), Math.max(240, innerHeight * 0.8));
    this.canvas.style.height = `${Math.round(wanted)}px`;
    const w = Math.max(1, Math.round(box.width * ratio)), hgt = Math.max(1, Math.round(wanted * ratio));
    if (this.canvas.width !== w || this.canvas.height !== hgt) Object.assign(this.canvas, {width: w, height: hgt});
  }

  showWindow(crop, divisor) {
    const {width} = this.size();
    this.view = {
      zoom: Math.max(1, width / (crop.width * divisor) * 0.6),
      x: (crop.x + crop.width / 2) * divisor,
      y: (crop.y + crop.height / 2) * divisor
    };
    this.changed();
    this.canvas.focus();
  }
}

const gridColumns = count => (count <= 3 ? count : count <= 4 ? 2 : count <= 9 ? 3 : 4);

function drawPane(context, viewer, pane, picture, source) {
  const ratio = window.devicePixelRatio || 1;
  context.save();
  context.beginPath();
  context.rect(pane.clip[0], pane.y, pane.clip[1] - pane.clip[0], pane.height);
  context.clip();
  if (picture.canvas) {
    const at = viewer.placement(pane), scale = at.scale * picture.divisor;
    context.imageSmoothingEnabled = scale < 1;
    context.imageSmoothingQuality = 'high';
    context.drawImage(picture.canvas, at.x, at.y, picture.canvas.width * scale, picture.canvas.height * scale);
    if (viewer.pixel && at.scale > 3) {
      context.strokeStyle = '#fff';
      context.strokeRect(at.x + viewer.pixel.x * at.scale, at.y + viewer.pixel.y * at.scale, at.scale, at.scale);
    }
  }
  const right = viewer.mode === 'split' && pane.clip[0] > 0;
  const kind = source.variant === undefined || pane.as === 'image' ? '' :
      pane.as === 'error'                                          ? ': relative error' :
                                                                     ': FLIP';
  const text = `${source.label}${kind}${picture.note ? ` (${picture.note})` : ''}`;
  context.font = `${13 * ratio}px system-ui, sans-serif`;
  const width = context.measureText(text).width + 14 * ratio;
  const x = right ? pane.clip[1] - width : pane.clip[0];
  context.fillStyle = 'rgba(0,0,0,0.65)';
  context.fillRect(x, pane.y, width, 23 * ratio);
  context.fillStyle = '#fff';
  context.fillText(text, x + 7 * ratio, pane.y + 16 * ratio);
  context.restore();
  context.fillStyle = cssColor('--page');
  if (right) context.fillRect(pane.clip[0] - ratio, 0, 2 * ratio, pane.height);
  if (viewer.mode === 'grid') {
    context.strokeStyle = cssColor('--page');
    context.lineWidth = 3 * ratio;
    context.strokeRect(pane.x, pane.y, pane.width, pane.height);
  }
}
