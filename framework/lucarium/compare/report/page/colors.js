// SPDX-License-Identifier: Apache-2.0
// The palette of Okabe and Ito (2008), which colour-blind readers can distinguish; every technique also has a shape and
// a dash pattern of its own.

const palette = ['#0072b2', '#d55e00', '#009e73', '#cc79a7', '#e69f00', '#56b4e9', '#8c6bb1', '#7f7f7f'];
const shapes = [
  ['circle', '●'], ['triangle', '▲'], ['rect', '■'], ['rectRot', '◆'], ['star', '✱'], ['crossRot', '✖'], ['cross', '✚'],
  ['rectRounded', '▮']
];
const dashes = [[], [8, 4], [2, 3], [10, 3, 2, 3], [5, 5], [12, 4], [4, 2], [2, 6]];

function variantStyle(index) {
  return {
    color: palette[index % palette.length],
    point: shapes[index % shapes.length][0],
    glyph: shapes[(index + Math.floor(index / 8)) % shapes.length][1],
    dash: dashes[index % dashes.length]
  };
}

function marker(index) {
  const style = variantStyle(index);
  return h('span', {class: 'marker', style: `color:${style.color}`, 'aria-hidden': 'true'}, style.glyph);
}

function cssColor(name) {
  return getComputedStyle(document.documentElement).getPropertyValue(name).trim();
}

function isDark() {
  const chosen = document.documentElement.dataset.theme;
  return chosen ? chosen === 'dark' : matchMedia('(prefers-color-scheme: dark)').matches;
}
