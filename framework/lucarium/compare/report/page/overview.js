// SPDX-License-Identifier: Apache-2.0
// What the scenes say together.

// relMSE over the best of the same scene and budget.
function ratioToBest(scene, variant, budget) {
  if (!isRanked(scene, budget)) return undefined;
  const values = variants.map((entry, v) => (relmse(summaryOf(scene, v, budget)) || {}).mean).filter(v => v > 0);
  const own = (relmse(summaryOf(scene, variant, budget)) || {}).mean;
  return own > 0 && values.length ? own / Math.min(...values) : undefined;
}

function geometricMean(values) {
  return values.length ? Math.exp(values.reduce((s, v) => s + Math.log(v), 0) / values.length) : undefined;
}

// Paler is better; the number stands in the cell, so colour is only a help.
function heat(ratio) {
  const strength = Math.min(1, Math.log10(ratio) / 2);
  return ratio > 1.0001 ? `background:color-mix(in srgb, var(--warm) ${Math.round(10 + 60 * strength)}%, transparent)` :
                          'background:color-mix(in srgb, var(--cool) 35%, transparent);font-weight:700';
}

// Who is best on each scene within each budget, and how far the next one is behind.
function winnersTable() {
  const winners = listOf(results, 'winners');
  if (!winners.length) return null;
  const columns = [{name: 'scene'}, ...budgets.map((b, i) => ({name: budgetLabel(i)}))];
  const cellOf = winner => {
    if (!winner) return {show: '–'};
    const seedsShown = winner.ratio.low !== undefined;
    const doubt = (winner.different ? '' :
                       seedsShown   ? ', no difference shown' :
                                      ', one seed') +
        (winner.resolved === false ? ', close to the reference’s own error ⚠' : '');
    return {
      value: winner.ratio.mean,
      show: [
        marker(winner.best), variantLabel(winner.best),
        h('div', {class: 'note'},
          `${variantLabel(winner.next)} has ${number(winner.ratio.mean)} times its ${winner.metric}${doubt}`)
      ]
    };
  };
  const rows = scenes.map(
      (scene, s) => (
          {cells: [scene.name, ...budgets.map((b, i) => cellOf(winners.find(w => w.scene === s && w.budget === i)))]}));
  const wins = variants.map((entry, v) => [entry.label, winners.filter(w => w.best === v).length])
                   .filter(([label, count]) => count > 0)
                   .sort((a, b) => b[1] - a[1])
                   .map(([label, count]) => `${label} ${count}`);
  return sortableTable(`Best on each scene: ${wins.join(', ')} of ${winners.length}`, columns, rows, 'numbers left');
}

function overviewTable(budget, open) {
  const columns = [
    {name: 'technique'}, {name: 'all scenes', title: 'geometric mean; only over the scenes that it ran on'},
    ...scenes.map(scene => ({name: scene.name}))
  ];
  const rows = variants.map((entry, v) => {
    const ratios = scenes.map((scene, s) => ratioToBest(s, v, budget)), known = ratios.filter(r => r !== undefined);
    const mean = geometricMean(known);
    const cells = ratios.map((ratio, s) => {
      if (ratio === undefined)
        return {
          show: scenes[s].failure ? 'scene failed' :
              isRanked(s, budget) ? obstacles(s, v, budget)[0] || '–' :
                                    'unlike machines',
          class: 'obstacle'
        };
      return {
        value: ratio,
        style: heat(ratio),
        title: `relMSE ${number(relmse(summaryOf(s, v, budget)).mean)}`,
        show: h('button', {type: 'button', class: 'plain', onclick: () => open(s)}, `${number(ratio)}×`)
      };
    });
    const partial =
        known.length < scenes.length ? h('span', {class: 'note'}, ` on ${known.length} of ${scenes.length}`) : null;
    return {
      cells: [labelCell(v), {value: mean, show: mean === undefined ? '–' : [`${number(mean)}×`, partial]}, ...cells]
    };
  });
  return sortableTable(
      'relMSE over that of the best technique on the same scene; 1 is the best', columns, rows, 'numbers heat');
}

function overviewConfig(budget) {
  const sets = variants.map((entry, v) => {
    const style = variantStyle(v);
    return {
      label: entry.label,
      data: scenes.map((scene, s) => (relmse(summaryOf(s, v, budget)) || {mean: null}).mean),
      borderColor: style.color,
      backgroundColor: style.color,
      pointStyle: style.point,
      pointRadius: 6,
      showLine: false
    };
  });
  return {
    type: 'line',
    data: {labels: scenes.map(scene => scene.name), datasets: sets},
    options: {
      maintainAspectRatio: false,
      scales: {y: logAxis('relMSE', logRange(sets.flatMap(s => s.data))), x: {offset: true}},
      plugins: {
        legend: {position: 'bottom', labels: {usePointStyle: true}},
        tooltip: {callbacks: {label: item => `${item.dataset.label}: ${number(item.raw)}`}}
      }
    }
  };
}

function gateTable() {
  const gates = listOf(results, 'gates');
  if (!gates.length) return null;
  const verdict = gate => gate.passed ? '✔ passed' : gate.unlike_machines ? '? unknown: machines differ' : '✘ missed';
  const rows =
      gates.map(gate => ({
                  class: gate.passed ? '' : 'failed',
                  cells: [
                    gate.gate, sceneName(gate.scene), variantLabel(gate.variant), budgetLabel(gate.budget),
                    {value: gate.value, show: number(gate.value)}, {value: gate.passed ? 1 : 0, show: verdict(gate)}
                  ]
                }));
  const missed = gates.filter(gate => !gate.passed && !gate.unlike_machines).length;
  const unknown = gates.filter(gate => gate.unlike_machines).length;
  return h(
      'details', {open: gates.length <= 8},
      h('summary', {}, `${missed} of ${gates.length} gates missed${unknown ? `, ${unknown} unknown` : ''}`),
      sortableTable('Gates', ['gate', 'scene', 'technique', 'budget', 'value', 'verdict'].map(name => ({name})), rows));
}

function baselineTable() {
  const baseline = results.baseline;
  if (!baseline) return null;
  const signs = {better: '▼ better', worse: '▲ worse', same: '= same'};
  const rows =
      listOf(baseline, 'changes').map(c => ({
                                        class: c.verdict === 'worse' ? 'failed' : '',
                                        cells: [
                                          sceneName(c.scene),
                                          typeof c.variant === 'number' ? variantLabel(c.variant) : c.variant,
                                          typeof c.budget === 'number' ? budgetLabel(c.budget) : c.budget, c.metric,
                                          {value: c.ratio, show: interval({mean: c.ratio, low: c.low, high: c.high})},
                                          {value: c.verdict, show: signs[c.verdict] || c.verdict}
                                        ]
                                      }));
  return [
    sortableTable(
        `Now over then: ${baseline.folder}, version ${baseline.version}`,
        ['scene', 'technique', 'budget', 'metric', 'ratio', 'verdict'].map(name => ({name})), rows),
    listOf(baseline, 'missing')
        .map(text => h('p', {class: 'note'}, `Not in both: ${typeof text === 'string' ? text : JSON.stringify(text)}`))
  ];
}

function overviewSection(budget, open) {
  const failures = allFailures();
  return section(
      'overview', 'Summary',
      results.interrupted ?
          h('p', {class: 'alert'}, 'Interrupted: what is here was finished before. Continue with --resume.') :
          null,
      failures.length ? h('details', {class: 'alert', open: failures.length < 6},
                          h('summary', {}, `${failures.length} refused or failed`),
                          h('ul', {}, failures.map(text => h('li', {}, text)))) :
                        null,
      winnersTable(), overviewTable(budget, open),
      scenes.length > 1 ? h('figure', {}, addChart('relMSE by scene', 320, () => overviewConfig(budget))) : null,
      gateTable(), baselineTable());
}
