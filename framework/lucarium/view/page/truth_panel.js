// SPDX-License-Identifier: Apache-2.0
// The reference that grows, and the errors of everything that was tried at this view.

const errorKinds = {relmse: 'relMSE', flip: 'FLIP'};

class TruthPanel {
  constructor(connection) {
    this.kind = 'relmse';
    this.truth = {curves: [], references: []};  // the plot may be drawn before there is a state
    this.on = h('input', {type: 'checkbox', id: 'grow-reference',
      onchange: event => connection.send({do: 'reference', on: event.target.checked})});
    this.facts = h('div', {class: 'facts', id: 'reference-state'});
    this.rows = h('div', {class: 'scroll', id: 'errors'});
    this.chart = addChart('error over time of the techniques at this view', 240, () => this.config());
    this.figure = h('figure', {hidden: true}, this.chart);
    this.node = h('details', {class: 'panel', open: true}, h('summary', {}, 'Errors'),
      h('div', {class: 'row'},
        h('label', {class: 'control', for: 'grow-reference'}, this.on, h('span', {}, 'Grow a reference')),
        selectBox('Plot', Object.entries(errorKinds), 'relmse', kind => {
          this.kind = kind;
          drawCharts();
        })),
      this.facts, this.figure, this.rows);
    this.node.addEventListener('toggle', () => this.node.open && drawCharts());
  }

  label(curve) {
    return curve.parameters.length ? `${curve.technique} ${parameterText(curve.parameters)}` : curve.technique;
  }

  update(status) {
    const truth = status.truth, key = JSON.stringify(truth);
    if (key === this.key) return;
    this.key = key;
    this.truth = truth;
    if (document.activeElement !== this.on) this.on.checked = truth.on;
    this.facts.replaceChildren(...[
      truth.obstacle && h('p', {class: 'alert'}, truth.obstacle),
      ...truth.references.map(r => h('div', {title: r.paths}, `Reference: ${r.samples} samples per pixel${
        r.relmse === null ? '' : `, its own relMSE ${number(r.relmse, 2)}`}`))].filter(Boolean));
    this.showRows(truth);
    const drawn = JSON.stringify(truth.curves);
    this.figure.hidden = !truth.curves.some(curve => curve.points.length);
    if (drawn !== this.drawn && this.node.open) drawCharts();
    this.drawn = drawn;
  }

  // The last error of each: relMSE is noise, which more samples remove, and the rest: bias.
  showRows(truth) {
    const measured = truth.curves.map((curve, i) => ({curve, i, point: curve.points.at(-1)})).filter(e => e.point);
    this.rows.replaceChildren(...(measured.length ? [h('table', {class: 'passes errors'},
      h('thead', {}, h('tr', {}, ['technique', 'time', 'relMSE', 'noise', 'bias²', 'FLIP'].map(
        text => h('th', {scope: 'col'}, text)))),
      h('tbody', {}, measured.map(({curve, i, point}) => {
        // The reference's own error is that of the image which the picture was measured against.
        const bias = point.noise === null ? undefined : point.relmse - point.noise - (point.own ?? 0);
        return h('tr', {'data-technique': curve.technique},
          h('th', {scope: 'row'}, marker(i), this.label(curve)),
          [seconds(point.seconds), number(point.relmse), point.noise === null ? '–' : number(point.noise, 2),
            bias === undefined ? '–' : number(bias, 2), number(point.flip)].map(text => h('td', {}, text)));
      })))] : []));
    if (measured.some(e => e.point.noise === null))
      this.rows.append(h('p', {class: 'note'},
        'Noise is known where a technique gives the variance of its pixels: path_tracing with replicates of two or ' +
        'more.'));
  }

  config() {
    const {curves, references} = this.truth, kind = this.kind;
    const sets = curves.map((curve, i) => {
      const style = variantStyle(i);
      return {label: this.label(curve), showLine: true, borderWidth: 2, borderColor: style.color,
        backgroundColor: style.color, borderDash: style.dash, pointStyle: style.point, pointRadius: 3,
        data: curve.points.filter(p => p[kind] > 0).map(p => ({x: p.seconds, y: p[kind], samples: p.samples}))};
    });
    const points = sets.flatMap(set => set.data), own = kind === 'relmse' ?
        references.map(r => r.relmse).filter(v => v > 0) : [];
    const xs = logRange(points.map(p => p.x)), ys = logRange([...points.map(p => p.y), ...own]);
    if (xs) {
      own.forEach(level => sets.push({label: 'the reference\'s own error', data: [{x: xs[0], y: level},
        {x: xs[1], y: level}], borderColor: cssColor('--text'), borderWidth: 1, borderDash: [6, 6], pointRadius: 0}));
    }
    const line = item => `${item.dataset.label}: ${number(item.raw.y)} at ${seconds(item.raw.x)}`;
    return {type: 'line', data: {datasets: sets}, options: {maintainAspectRatio: false, parsing: false,
      interaction: {mode: 'nearest', intersect: false},
      scales: {x: logAxis('seconds', xs), y: logAxis(errorKinds[kind], ys)},
      plugins: {legend: {display: false}, tooltip: {callbacks: {title: () => '', label: line}}}}};
  }
}
