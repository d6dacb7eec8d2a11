// SPDX-License-Identifier: Apache-2.0
// Where time and memory go.

const shownPasses = 9;  // further ones are summed up

function passConfig(scene, budget, asShare) {
  const rows = variants.map((entry, v) => v).filter(v => summaryOf(scene, v, budget));
  const passes = rows.map(v => meanPasses(scene, v, budget));
  const totals = new Map();
  passes.flat().forEach(pass => totals.set(pass.name, (totals.get(pass.name) || 0) + pass.time));
  const names = [...totals].sort((a, b) => b[1] - a[1]).slice(0, shownPasses).map(([name]) => name);
  const wall = rows.map(v => {
    const s = summaryOf(scene, v, budget);
    return (s.prepare_seconds || 0) + (s.iterate_seconds || 0);
  });
  const sum = list => list.reduce((total, pass) => total + pass.time, 0);
  const sets = names.map((name, i) => ({
                           label: name,
                           values: passes.map(list => (list.find(p => p.name === name) || {time: 0}).time),
                           backgroundColor: palette[i % 7] + (i >= 7 ? '88' : '')
                         }));
  sets.push({
    label: 'other passes',
    values: passes.map(list => sum(list.filter(p => !names.includes(p.name)))),
    backgroundColor: '#7f7f7f'
  });
  sets.push({
    label: 'outside passes (host, waiting)',
    values: passes.map((list, i) => Math.max(0, wall[i] - sum(list))),
    backgroundColor: cssColor('--idle')
  });
  const used = sets.filter(set => set.values.some(v => v > 0));
  const height = rows.map((row, i) => Math.max(1e-30, used.reduce((total, set) => total + set.values[i], 0)));
  return {
    type: 'bar',
    data: {
      labels: rows.map(variantLabel),
      datasets: used.map(({values, ...set}) => ({
                           ...set,
                           borderColor: cssColor('--page'),
                           borderWidth: 1,
                           borderSkipped: false,
                           data: values.map((v, i) => (asShare ? 100 * v / height[i] : v))
                         }))
    },
    options: {
      indexAxis: 'y',
      maintainAspectRatio: false,
      scales: {
        x: {
          stacked: true,
          max: asShare ? 100 : undefined,
          title: {display: true, text: asShare ? '% of the time' : 'seconds, mean over seeds'}
        },
        y: {stacked: true}
      },
      plugins: {
        legend: {position: 'bottom', labels: {boxWidth: 14}},
        tooltip: {callbacks: {label: item => `${item.dataset.label}: ${number(item.raw)}${asShare ? ' %' : ' s'}`}}
      },
    },
  };
}

function passChart(scene, budget) {
  let asShare = false;
  const chart = addChart(
      `Time per pass on ${sceneName(scene)}`, 150 + 42 * variants.length, () => passConfig(scene, budget, asShare));
  const choice = selectBox('Show', [['seconds', 'seconds'], ['share', 'shares']], 'seconds', v => {
    asShare = v === 'share';
    drawCharts();
  });
  return h(
      'figure', {}, choice, chart,
      h('figcaption', {},
        'Where the time goes: device time by pass. A technique whose work leaves the device idle shows it here.'));
}

function memoryConfig(scene, budget) {
  const rows = variants.map((entry, v) => v).filter(v => summaryOf(scene, v, budget));
  const values = key => rows.map(v => (summaryOf(scene, v, budget)[key] || 0) / 1e6);
  return {
    type: 'bar',
    data: {
      labels: rows.map(variantLabel),
      datasets: [
        {label: 'device', data: values('peak_device_bytes'), backgroundColor: palette[0]},
        {label: 'host', data: values('peak_host_bytes'), backgroundColor: palette[4]}
      ]
    },
    options: {
      indexAxis: 'y',
      maintainAspectRatio: false,
      scales: {x: {title: {display: true, text: 'MB at most'}}},
      plugins: {legend: {position: 'bottom', labels: {boxWidth: 14}}}
    },
  };
}

function memoryChart(scene, budget) {
  return h(
      'figure', {},
      addChart(`Memory on ${sceneName(scene)}`, 110 + 42 * variants.length, () => memoryConfig(scene, budget)),
      h('figcaption', {}, 'Most memory at one time, whole process and device.'));
}
