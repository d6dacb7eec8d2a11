// SPDX-License-Identifier: Apache-2.0
// What all plots share: theme, axes, and their redrawing when the theme changes.

const charts = new Set();

function addChart(label, height, makeConfig) {
  const canvas = h('canvas', {role: 'img', 'aria-label': label});
  const holder = h('div', {class: 'chart', style: `height:${height}px`}, canvas);
  const entry = {
    canvas,
    // Charts measure their holder, so they are made once it is in the page, and again for another theme.
    draw() {
      if (!canvas.isConnected) return;
      if (entry.chart) entry.chart.destroy();
      Chart.defaults.color = cssColor('--text');
      Chart.defaults.borderColor = cssColor('--line');
      Chart.defaults.font.family = 'system-ui, sans-serif';
      Chart.defaults.animation = false;
      entry.chart = new Chart(canvas, makeConfig());
    },
  };
  charts.add(entry);
  return holder;
}

function drawCharts() {
  for (const entry of charts) {
    if (entry.canvas.isConnected)
      entry.draw();
    else {
      if (entry.chart) entry.chart.destroy();
      charts.delete(entry);
    }
  }
}

// Whether the value is one of `digits` times a power of ten.
function isStep(value, digits) {
  const mantissa = Number(value / 10 ** Math.floor(Math.log10(value) + 1e-9)).toPrecision(6);
  return digits.some(digit => Number(mantissa) === digit);
}

// Logarithmic axis with a label at 1, 2 and 5 of every decade, or at decades alone when there are many.
function logAxis(title, range) {
  const few = range && range[1] / range[0] < 1e3;
  return {
    type: 'logarithmic',
    min: range && range[0],
    max: range && range[1],
    title: {display: true, text: title},
    ticks: {callback: value => (isStep(value, few ? [1, 2, 5] : [1]) ? number(value) : '')},
  };
}

// Range over values, with a little room.
function logRange(values) {
  const positive = values.filter(v => v > 0 && Number.isFinite(v));
  if (!positive.length) return undefined;
  return [Math.min(...positive) / 1.25, Math.max(...positive) * 1.25];
}

// Buttons that show and hide techniques in all plots of a scene.
const hiddenVariants = new Set();
function variantToggles(changed) {
  return h(
      'div', {class: 'toggles', role: 'group', 'aria-label': 'techniques in the plots'},
      variants.map(
          (entry, v) =>
              h('button', {
                type: 'button',
                class: 'toggle',
                'aria-pressed': String(!hiddenVariants.has(v)),
                onclick: event => {
                  if (!hiddenVariants.delete(v)) hiddenVariants.add(v);
                  event.currentTarget.setAttribute('aria-pressed', String(!hiddenVariants.has(v)));
                  changed();
                },
              },
                marker(v), entry.label)));
}
