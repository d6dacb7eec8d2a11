// SPDX-License-Identifier: Apache-2.0
// The bar above the viewer: which pictures, as what, how bright.

const displays = [['image', 'image'], ['error', 'relative error'], ['flip', 'FLIP']];

class ViewerControls {
  constructor(viewer) {
    this.viewer = viewer;
    viewer.controls = this;
    const range = value => 10 ** value;
    this.exposure =
        slider('Exposure', [-12, 12, 0.25], viewer.stops, v => `${v > 0 ? '+' : ''}${number(v)} stops`, v => {
          viewer.stops = v;
          viewer.changed();
          this.recrop();
        }, 'keys [ and ]; double click: back');
    this.scale =
        slider('Error scale', [-2.5, 1, 0.05], Math.log10(viewer.range), v => `±${number(100 * range(v), 2)} %`, v => {
          viewer.range = range(v);
          viewer.changed();
          this.showLegend();
        }, 'the same for all techniques');
    this.bar = h('div', {class: 'controls', role: 'toolbar', 'aria-label': 'pictures'});
    this.legend = h('div', {class: 'legend'});
    this.crops = h('div', {class: 'crop-rows'});
    this.build();
    this.showLegend();
  }

  available() {
    const {scene, budget} = this.viewer;
    return displays.filter(([key]) => key !== 'flip' || findImage({kind: 'flip', scene, budget}) >= 0);
  }

  build() {
    const viewer = this.viewer, all = viewer.sources().map((s, i) => [i, `${i < 9 ? `${i + 1} ` : ''}${s.label}`]);
    const side = name =>
        [selectBox(name === 'left' ? 'Left' : 'Right', all, viewer[name].source, v => this.choose(name, Number(v))),
         selectBox(
             'as', this.available(), viewer[name].as,
             v => {
               viewer[name].as = v;
               this.refresh();
             }),
    ];
    const layers = layerNames(viewer.scene, viewer.budget);
    const means = findImage({kind: 'mean', scene: viewer.scene, budget: viewer.budget}) >= 0;
    const focused = document.activeElement && this.bar.contains(document.activeElement) ?
        [...this.bar.querySelectorAll('select,input,button')].indexOf(document.activeElement) :
        -1;
    this.bar.replaceChildren(
        selectBox('View', [['split', 'split'], ['grid', 'all side by side']], viewer.mode, v => this.setMode(v)),
        ...(viewer.mode === 'split' ? [...side('left'), ...side('right')] : [selectBox(
                                                                                'as', this.available(), viewer.gridAs,
                                                                                v => {
                                                                                  viewer.gridAs = v;
                                                                                  this.refresh();
                                                                                })]),
        ...(layers.length ? [selectBox(
                                'Layer', [['', 'the image'], ...layers.map(n => [n, n])], viewer.layer,
                                v => {
                                  viewer.layer = v;
                                  this.refresh();
                                })] :
                            []),
        ...(means ? [selectBox(
                        'Seeds', [['one', 'first'], ['mean', 'mean of all']], viewer.useMean ? 'mean' : 'one',
                        v => {
                          viewer.useMean = v === 'mean';
                          this.refresh();
                        })] :
                    []),
        this.exposure, this.scale,
        h('button', {
          type: 'button',
          onclick: () => {
            viewer.view = null;
            viewer.changed();
          }
        },
          'Fit'));
    if (focused >= 0) [...this.bar.querySelectorAll('select,input,button')][focused]?.focus();
  }

  refresh() {
    this.build();
    this.viewer.changed();
    this.showLegend();
    this.recrop();
  }
  choose(side, source) {
    if (source < this.viewer.sources().length) {
      this.viewer[side].source = source;
      this.refresh();
    }
  }
  setMode(mode) {
    this.viewer.mode = mode;
    this.refresh();
  }
  toggleMean() {
    this.viewer.useMean = !this.viewer.useMean;
    this.refresh();
  }
  swap() {
    [this.viewer.left, this.viewer.right] = [this.viewer.right, this.viewer.left];
    this.refresh();
  }

  nextLayer() {
    const names = ['', ...layerNames(this.viewer.scene, this.viewer.budget)];
    this.viewer.layer = names[(names.indexOf(this.viewer.layer) + 1) % names.length];
    this.refresh();
  }

  cycleDisplay() {
    const keys = this.available().map(([key]) => key),
          owner = this.viewer.mode === 'grid' ? this.viewer : this.viewer.right;
    const field = this.viewer.mode === 'grid' ? 'gridAs' : 'as';
    owner[field] = keys[(keys.indexOf(owner[field]) + 1) % keys.length];
    this.refresh();
  }

  showLegend() {
    const viewer = this.viewer, shown = viewer.mode === 'grid' ? [viewer.gridAs] : [viewer.left.as, viewer.right.as];
    const strip = (low, table, high) =>
        h('div', {class: 'scale'}, h('span', {}, low),
          h('span', {class: 'gradient', style: `background:${cssGradient(table)}`}), h('span', {}, high));
    this.legend.replaceChildren(
        ...(shown.includes('error') ? [strip(
                                          `too dark −${number(100 * viewer.range, 2)} %`, divergingTable(),
                                          `+${number(100 * viewer.range, 2)} % too bright`)] :
                                      []),
        ...(shown.includes('flip') ? [strip('FLIP 0', magmaTable, '1')] : []));
  }

  // Crops follow exposure and layer, but not on every step of a slider.
  recrop() {
    clearTimeout(this.timer);
    this.timer = setTimeout(async () => {
      try {
        this.crops.replaceChildren(...await cropStrips(this.viewer));
      } catch (error) {
        this.crops.replaceChildren(h('p', {class: 'alert'}, error.message));
      }
    }, 150);
  }
}
