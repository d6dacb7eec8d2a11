// SPDX-License-Identifier: Apache-2.0
// Numbers for people.

function number(value, digits = 3) {
  if (value === null || value === undefined || Number.isNaN(value)) return '–';
  if (!Number.isFinite(value)) return value > 0 ? '∞' : '−∞';
  if (value === 0) return '0';
  const magnitude = Math.abs(value);
  const text = magnitude >= 1e5 || magnitude < 1e-3 ?
      Number(value.toPrecision(digits)).toExponential().replace('e+', 'e') :
      String(Number(value.toPrecision(digits)));
  return text.replace(/-/g, '−');
}

// mean with its 95 % interval, as nodes: the interval stands smaller beside it.
function interval(mean, digits = 3) {
  if (!mean || typeof mean !== 'object') return number(mean, digits);
  if (mean.low === undefined || mean.low === null) return number(mean.mean, digits);
  return [
    number(mean.mean, digits), ' ', h('span', {class: 'range'}, `${number(mean.low, 2)} … ${number(mean.high, 2)}`)
  ];
}

function seconds(value) {
  if (value === null || value === undefined) return '–';
  if (value >= 120) return `${number(value / 60)} min`;
  return value >= 1 ? `${number(value)} s` : `${number(value * 1e3)} ms`;
}

function bytes(value) {
  if (!value) return '–';
  return value >= 1e9 ? `${number(value / 1e9)} GB` :
      value >= 1e6 ? `${number(value / 1e6)} MB` :
                     `${number(value / 1e3)} kB`;
}

function percent(value) {
  return `${number(100 * value, 2)} %`;
}
