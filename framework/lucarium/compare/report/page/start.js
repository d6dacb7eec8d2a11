// SPDX-License-Identifier: Apache-2.0
// Puts the page together. Scene, budget and theme stand in the address, so that a link shows the same again.

const state = {
  scene: 0,
  budget: 0,
  theme: ''
};

function readAddress() {
  const wanted = new URLSearchParams(location.hash.slice(1));
  const index = (name, count) => Math.min(Math.max(0, Number(wanted.get(name) || 1) - 1 || 0), Math.max(0, count - 1));
  state.scene = index('scene', scenes.length);
  state.budget = index('budget', budgets.length);
  state.theme = ['light', 'dark'].includes(wanted.get('theme')) ? wanted.get('theme') : state.theme;
}

function writeAddress() {
  const parts = [`scene=${state.scene + 1}`];
  if (budgets.length > 1) parts.push(`budget=${state.budget + 1}`);
  if (state.theme) parts.push(`theme=${state.theme}`);
  history.replaceState(null, '', `#${parts.join('&')}`);
}

function applyTheme() {
  if (state.theme) document.documentElement.dataset.theme = state.theme;
  drawCharts();
  if (viewer) {
    viewer.changed();
    if (viewer.controls) viewer.controls.showLegend();
  }
}

function subtitle() {
  const c = results.comparison || {};
  const size = listOf(c, 'scenes').some(scene => scene.size) ? 'several sizes' :
      Array.isArray(c.size)                                  ? c.size.join('×') :
                                                               '';
  const seedCount = c.seeds ? `${c.seeds} seed${c.seeds > 1 ? 's' : ''} each` : '';
  return [
    `${scenes.length} scene${scenes.length === 1 ? '' : 's'}, ${variants.length} techniques`, size, seedCount,
    results.device
  ].filter(Boolean)
      .join(' · ');
}

function header() {
  const go = change => {
    Object.assign(state, change);
    writeAddress();
    show();
  };
  const theme =
      h('button', {
        type: 'button',
        id: 'theme',
        onclick: () => {
          state.theme = isDark() ? 'light' : 'dark';
          writeAddress();
          applyTheme();
        }
      },
        'Light / dark');
  return [
    h('a', {
      class: 'skip',
      href: '#main',
      onclick: event => {
        event.preventDefault();
        document.getElementById('main').focus();
      }
    },
      'To the content'),
    h('div', {class: 'title'}, h('h1', {}, 'Lucarium comparison'), h('p', {}, subtitle())),
    h('nav', {'aria-label': 'scenes'},
      scenes.map(
          (scene, i) =>
              h('button', {
                type: 'button',
                'aria-current': i === state.scene ? 'true' : undefined,
                class: scene.failure ? 'failed' : '',
                onclick: () => go({scene: i})
              },
                scene.name))),
    h('div', {class: 'controls'},
      budgets.length > 1 ?
          selectBox('Budget', budgets.map((b, i) => [i, budgetLabel(i)]), state.budget, v => go({budget: Number(v)})) :
          h('span', {class: 'hint'}, budgetLabel(0)),
      theme)
  ];
}

function show() {
  const open = scene => {
    state.scene = scene;
    writeAddress();
    show();
    document.getElementById('scene').scrollIntoView();
  };
  document.getElementById('top').replaceChildren(...header());
  const parts = [reproductionSection(), overviewSection(state.budget, open)].filter(Boolean);
  if (scenes.length) parts.push(sceneSection(state.scene, state.budget));
  document.getElementById('main').replaceChildren(...parts, provenanceSection());
  drawCharts();
  if (viewer) viewer.draw();
}

function start() {
  readAddress();
  if (state.theme) document.documentElement.dataset.theme = state.theme;
  document.addEventListener('keydown', event => {
    if (viewer && viewer.controls) handleKey(viewer, event);
  });
  matchMedia('(prefers-color-scheme: dark)').addEventListener('change', applyTheme);
  addEventListener('hashchange', () => {
    readAddress();
    show();
    applyTheme();
  });
  // Paper is white.
  let before = '';
  addEventListener('beforeprint', () => {
    before = state.theme;
    state.theme = 'light';
    applyTheme();
  });
  addEventListener('afterprint', () => {
    state.theme = before;
    if (!before) delete document.documentElement.dataset.theme;
    applyTheme();
  });
  show();
  // The images stand behind this script; what asked for them before they were read is answered then.
  pageLoaded.then(() => {
    if (viewer) viewer.changed();
  });
}
