// SPDX-License-Identifier: Apache-2.0
// relMSE over time, both logarithmic: the mean over seeds, its 95 % interval as a band, the fitted slope as a thin
// line.

// Keys of results.json (docs/results.md) for either time.
const wallTime = {
  title: 'Seconds',
  curve: 'curve',
  seconds: 'seconds',
  times: 'time_to_error',
  reached: 'reached_seconds',
  total: 'iterate_seconds',
  end: s => s.iterate_seconds + (s.prepare_seconds || 0)
};
const processorTime = {
  title: 'Processor seconds',
  curve: 'processor_curve',
  seconds: 'processor_seconds',
  times: 'processor_time_to_error',
  reached: 'reached_processor_seconds',
  total: 'processor_seconds',
  end: s => s.processor_seconds
};

function curvePoints(summary, of) {
  return listOf(summary, of.curve)
      .map(p => ({seconds: p[of.seconds], samples: p.samples, relmse: p.relmse}))
      .filter(p => p.seconds > 0 && p.relmse && p.relmse.mean > 0);
}

// The fitted line goes through the mean of the logarithms.
function slopeLine(summary, points, of) {
  if (of !== wallTime || !summary.slope || !Number.isFinite(summary.slope.value) || points.length < 2) return [];
  const mean = f => points.reduce((sum, p) => sum + Math.log(f(p)), 0) / points.length;
  const x = mean(p => p.seconds), y = mean(p => p.relmse.mean);
  return [points[0], points[points.length - 1]].map(
      p => ({x: p.seconds, y: Math.exp(y + summary.slope.value * (Math.log(p.seconds) - x))}));
}

function curveSets(scene, budget, variant, of) {
  const summary = summaryOf(scene, variant, budget), style = variantStyle(variant);
  if (!summary || hiddenVariants.has(variant)) return [];
  const points = curvePoints(summary, of), final = relmse(summary);
  const line = points.length ?
      points.map(p => ({x: p.seconds, y: p.relmse.mean, low: p.relmse.low, high: p.relmse.high, samples: p.samples})) :
      final && of.end(summary) > 0 ?
      [{x: of.end(summary), y: final.mean, low: final.low, high: final.high, samples: summary.samples}] :
      [];
  const banded = line.filter(p => p.low > 0);
  const bare = {pointRadius: 0, borderWidth: 0, tooltipOff: true};
  return [
    {data: banded.map(p => ({x: p.x, y: p.low})), ...bare, fill: '+1', backgroundColor: `${style.color}33`},
    {data: banded.map(p => ({x: p.x, y: p.high})), ...bare},
    {data: slopeLine(summary, points, of), ...bare, borderWidth: 1, borderColor: style.color, borderDash: [2, 2]},
    {
      label: variantLabel(variant),
      data: line,
      borderColor: style.color,
      backgroundColor: style.color,
      borderDash: style.dash,
      borderWidth: 2,
      pointStyle: style.point,
      pointRadius: 4,
      pointHoverRadius: 6,
      showLine: true
    },
  ];
}

function curveConfig(scene, budget, of) {
  const sets = variants.flatMap((entry, v) => curveSets(scene, budget, v, of));
  const points = sets.flatMap(s => s.data);
  const own = listOf(scenes[scene], 'references').map(r => r.own_relmse).filter(v => v > 0);
  const xs = logRange(points.map(p => p.x)), ys = logRange([...points.map(p => p.y), ...own]);
  if (xs)
    own.forEach((level, i) => sets.push({
      label: own.length > 1 ? `reference ${i + 1}'s own error` : 'reference\'s own error',
      data: [{x: xs[0], y: level}, {x: xs[1], y: level}],
      borderColor: cssColor('--text'),
      borderWidth: 1,
      borderDash: [6, 6],
      pointRadius: 0
    }));
  return {
    type: 'line',
    data: {datasets: sets},
    options: {
      maintainAspectRatio: false,
      parsing: false,
      interaction: {mode: 'nearest', intersect: false},
      scales: {x: {...logAxis(of.title.toLowerCase(), xs)}, y: logAxis('relMSE', ys)},
      plugins: {
        legend: {display: false},
        tooltip: {
          filter: item => !item.dataset.tooltipOff,
          callbacks: {
            title: () => '',
            label: item => {
              const p = item.raw, range = p.low ? ` (${number(p.low, 2)} … ${number(p.high, 2)})` : '';
              return `${item.dataset.label}: ${number(p.y)}${range}${
                  p.samples ? ` at ${seconds(p.x)}, ${number(p.samples)} samples` : ''}`;
            },
          },
        },
      },
    },
  };
}

function curveChart(scene, budget, of, caption) {
  const label = `relMSE over ${of.title.toLowerCase()} on ${sceneName(scene)}`;
  return h('figure', {}, addChart(label, 380, () => curveConfig(scene, budget, of)), h('figcaption', {}, caption));
}

// Over wall time where all pieces ran on one kind of machine; over processor time wherever it is known.
function timeSection(scene, budget) {
  const known = variants.some((entry, v) => (summaryOf(scene, v, budget) || {}).processor_seconds > 0);
  const unlike = unlikeMachines(scene);
  return [
    h('h3', {}, 'Error over time'),
    unlike ? h('p', {class: 'alert'},
               'Pieces of this scene ran on machines of several kinds. Nothing here is ranked by wall time: ' +
                   (known ? 'error over processor time remains, which neither the number of cores nor load change, ' +
                            'though the speed of a core does. ' :
                            'processor times are not known. ') +
                   'Errors at the same iterations or samples compare anywhere.') :
             null,
    variantToggles(drawCharts),
    h('div', {class: 'beside'},
      unlike ? null :
               curveChart(
                   scene, budget, wallTime,
                   'Error over time: mean over seeds with its 95 % interval, fitted slope dotted. −1 is what ' +
                       'Monte Carlo does. The horizontal line is the reference’s own error: errors close to ' +
                       'it cannot be distinguished.'),
      known ? curveChart(
                  scene, budget, processorTime,
                  'Error over processor time of preparing and iterating, all threads together: what the ' +
                      'picture cost, whatever ran beside it.') :
              null),
    unlike ? null : timeTable(scene, budget, wallTime), timeTable(scene, budget, processorTime)
  ];
}
