// SPDX-License-Identifier: Apache-2.0
// The tables of one scene and budget.

function labelCell(variant, notes = []) {
  return {
    value: variantLabel(variant),
    show: [marker(variant), variantLabel(variant), notes.map(note => h('div', {class: 'note'}, note))]
  };
}

function notesOf(scene, variant, budget, summary) {
  const notes = [...listOf(sceneVariant(scene, variant), 'limitations')];
  if (summary && summary.resolved === false)
    notes.push('close to what this reference can resolve: it needs more samples');
  if (summary) notes.push(...obstacles(scene, variant, budget));
  if (piecesOf(scene, variant, budget).some(piece => piece.converged))
    notes.push('ended by itself: nothing more to do');
  return notes;
}

// Biased beyond doubt above two standard errors; about one is what no bias gives.
function biasCell(summary) {
  const bias = summary.bias;
  if (!bias || bias.standard_errors === undefined) return {show: '–'};
  const doubtful = Math.abs(bias.standard_errors) > 2;
  const share = bias.mse > 0 && bias.variance_mse > 0 ? bias.mse / (bias.mse + bias.variance_mse) : 0;
  return {
    value: bias.standard_errors,
    class: doubtful ? 'flagged' : '',
    show: [
      number(bias.standard_errors, 2),
      doubtful ? h('span', {class: 'note'}, ` biased, ${percent(share)} of the error`) : null
    ],
    title: `squared bias ${number(bias.mse)}, variance ${number(bias.variance_mse)}`
  };
}

function resultTable(scene, budget) {
  const best = Math.min(...variants.map((entry, v) => (relmse(summaryOf(scene, v, budget)) || {mean: Infinity}).mean));
  const columns = [
    {name: 'technique'}, {name: 'relMSE', title: 'mean over seeds, 95 % interval'},
    {name: 'slope', title: 'of log relMSE over log time'},
    {name: 'bias [SE]', title: 'error of the mean over seeds in standard errors; about 1 without bias'},
    {name: 'prepare'}, {name: 'iterate'}, {name: 'on device'},
    {name: 'processor', title: 'processor time of preparing and iterating, all threads'},
    {name: 'compile', title: 'not counted'}, {name: 'samples'}, {name: 'seeds'}, {name: 'memory device'}, {name: 'host'}
  ];
  const time = value => ({value, show: seconds(value)});
  const rows = variants.map((entry, v) => {
    const s = summaryOf(scene, v, budget);
    if (!s)
      return {
        cells: [labelCell(v, listOf(sceneVariant(scene, v), 'limitations'))],
        span: obstacles(scene, v, budget).join('; '),
        class: 'failed'
      };
    const error = relmse(s);
    return {
      class: isRanked(scene, budget) && error && error.mean === best ? 'best' : '',
      cells: [
        labelCell(v, notesOf(scene, v, budget, s)),
        {value: error && error.mean, show: [interval(error), s.resolved === false ? ' ⚠' : '']},
        {value: s.slope && s.slope.value, show: s.slope ? interval({...s.slope, mean: s.slope.value}) : '–'},
        biasCell(s), time(s.prepare_seconds), time(s.iterate_seconds), time(s.device_seconds),
        time(s.processor_seconds), time(s.compile_seconds), {value: s.samples, show: number(s.samples)},
        {value: s.seeds, show: String(s.seeds)}, {value: s.peak_device_bytes, show: bytes(s.peak_device_bytes)},
        {value: s.peak_host_bytes, show: bytes(s.peak_host_bytes)}
      ]
    };
  });
  const rank = isRanked(scene, budget) ? 'the lowest relMSE is bold' : 'not ranked, since the machines are unlike';
  return sortableTable(`Results, ${budgetLabel(budget)}; ${rank}`, columns, rows);
}

function metricTable(scene, budget) {
  const columns = [
    {name: 'technique'},
    ...metrics.map(
        m =>
            ({name: `${m.name}${m.unit ? ` [${m.unit}]` : ''} ${m.better === 'higher' ? '↑' : '↓'}`, title: m.formula}))
  ];
  const bests = metrics.map(m => {
    const values = variants.map((entry, v) => (metricValue(summaryOf(scene, v, budget), m.name) || {}).mean)
                       .filter(v => v !== undefined);
    return m.better === 'higher' ? Math.max(...values) : Math.min(...values);
  });
  const rows = variants.map((entry, v) => {
    const s = summaryOf(scene, v, budget);
    if (!s) return {cells: [labelCell(v)], span: obstacles(scene, v, budget).join('; '), class: 'failed'};
    return {
      cells: [
        labelCell(v), ...metrics.map((m, i) => {
          const value = metricValue(s, m.name);
          return {
            value: value && value.mean,
            show: interval(value),
            class: isRanked(scene, budget) && value && value.mean === bests[i] ? 'leading' : ''
          };
        })
      ]
    };
  });
  return sortableTable('All metrics; ↓ lower is better, ↑ higher', columns, rows);
}

// `of` is wallTime or processorTime (curve_chart.js).
function timeTable(scene, budget, of) {
  const levels = [
    ...new Set(variants.flatMap((entry, v) => listOf(summaryOf(scene, v, budget), of.times).map(t => t.relmse)))
  ].sort((a, b) => b - a);
  const reached = variants.some((entry, v) => (summaryOf(scene, v, budget) || {})[of.reached]);
  if (!levels.length && !reached) return null;
  const goal = (budgets[budget] || {}).relmse;
  const columns = [
    {name: 'technique'}, ...(goal ? [{name: `to the asked ${number(goal)}`}] : []),
    ...levels.map(level => ({name: `to ${number(level)}`}))
  ];
  const rows = variants.map((entry, v) => {
    const s = summaryOf(scene, v, budget);
    if (!s) return {cells: [labelCell(v)], span: obstacles(scene, v, budget).join('; '), class: 'failed'};
    const cells = levels.map(level => {
      const time = listOf(s, of.times).find(t => t.relmse === level);
      if (!time) return {show: '–'};
      if (!time[of.seconds]) return {show: h('span', {class: 'range'}, 'not reached')};
      return {value: time[of.seconds].mean, show: [time.at_most ? '≤ ' : '', interval(time[of.seconds]), ' s']};
    });
    if (goal)
      cells.unshift(
          s[of.reached] ? {value: s[of.reached].mean, show: [interval(s[of.reached]), ' s']} :
                          {show: s[of.total] === undefined ? '–' : 'not within the limit'});
    return {cells: [labelCell(v), ...cells]};
  });
  return sortableTable(`${of.title} to reach a relMSE, from the curves`, columns, rows);
}

// Frames of a walk along the camera path, with the light of the budget.
function walkTable(scene, budget) {
  if (!variants.some((entry, v) => (summaryOf(scene, v, budget) || {}).walk)) return null;
  const columns = [
    {name: 'technique'}, {name: 'median frame'}, {name: 'fastest'}, {name: 'slowest'}, {name: 'slowest over median'},
    {name: 'relMSE', title: 'mean over the frames with a reference'}
  ];
  const time = value => ({value, show: seconds(value)});
  const rows = variants.map((entry, v) => {
    const s = summaryOf(scene, v, budget);
    if (!s || !s.walk) return {cells: [labelCell(v)], span: obstacles(scene, v, budget).join('; '), class: 'failed'};
    const t = s.walk.frame_seconds;
    return {
      cells: [
        labelCell(v), time(t.median), time(t.min), time(t.max),
        {value: t.max / t.median, show: number(t.max / t.median, 3)},
        s.walk.relmse === undefined ? {show: '–'} : {value: s.walk.relmse, show: number(s.walk.relmse)}
      ]
    };
  });
  return sortableTable('Walk along the camera path: wall time per frame', columns, rows);
}

// Ratio of errors of every pair, paired by seeds.
function pairTable(scene, budget) {
  if (!isRanked(scene, budget)) return h('p', {class: 'hint'}, 'Not ranked, since the machines are unlike.');
  const pairs =
      listOf(results, 'pairs')
          .filter(p => p.scene === scene && p.budget === budget && String(p.metric).toLowerCase() === 'relmse');
  if (!pairs.length) return null;
  const ratio = (a, b) => {
    const direct = pairs.find(p => p.a === a && p.b === b), inverse = pairs.find(p => p.a === b && p.b === a);
    if (direct) return {...direct.ratio, different: direct.different};
    if (!inverse) return null;
    const flip = v => (v > 0 ? 1 / v : undefined);
    return {
      mean: flip(inverse.ratio.mean),
      low: flip(inverse.ratio.high),
      high: flip(inverse.ratio.low),
      different: inverse.different
    };
  };
  const shown = variants.map((entry, v) => v).filter(v => pairs.some(p => p.a === v || p.b === v));
  const rows =
      shown.map(a => ({
                  cells: [
                    labelCell(a), ...shown.map(b => {
                      const r = a === b ? null : ratio(a, b);
                      if (!r) return {show: a === b ? '1' : '–', class: 'range'};
                      return {
                        value: r.mean,
                        show: [interval(r), r.different ? '' : h('span', {class: 'note'}, ' no difference shown')],
                        class: r.different ? (r.mean < 1 ? 'better' : 'worse') : ''
                      };
                    })
                  ]
                }));
  return sortableTable(
      'relMSE of the row over relMSE of the column, paired by seeds, 95 % interval',
      [{name: 'technique'}, ...shown.map(v => ({name: variantLabel(v)}))], rows);
}
