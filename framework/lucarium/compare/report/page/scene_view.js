// SPDX-License-Identifier: Apache-2.0
// Everything about one scene.

let viewer = null;  // of the scene that is shown

function describePaths(pathSet) {
  return String(pathSet || '').split(',').join(', ');
}

function referenceNotes(scene) {
  const references = listOf(scenes[scene], 'references');
  return h('ul', {class: 'facts'}, references.map((r, i) => {
    const who = references.length > 1 ? `Reference ${i + 1}` : 'Reference';
    if (r.failure) return h('li', {class: 'flagged'}, `${who}: ${r.failure}`);
    const own = r.own_relmse > 0 ? `own relMSE ${number(r.own_relmse)}` : 'own error unknown';
    const facts = [
      r.source, r.samples ? `${r.samples} samples` : '',
      r.from_cache  ? 'from the cache' :
          r.seconds ? seconds(r.seconds) :
                      '',
      own
    ].filter(Boolean).join(', ');
    return h(
        'li', {}, `${who}: ${facts}`,
        r.path_set ? h('details', {}, h('summary', {}, 'light paths'), describePaths(r.path_set)) : null);
  }));
}

function pictureSection(scene, budget) {
  viewer = new Viewer(scene, budget);
  if (!viewer.sources().length) return h('p', {class: 'hint'}, 'There are no pictures for this budget.');
  const controls = new ViewerControls(viewer);
  addPointerInput(viewer);
  controls.recrop();
  return [
    controls.bar, viewer.canvas, controls.legend,
    h('p', {class: 'hint'},
      'Drag to pan, wheel to zoom (after a click, or with Ctrl). ' +
          'Keys: 1–9 picture on the left, r reference, x swap, ' +
          'e display, g all, m mean, l layer, [ ] exposure, + − 0 zoom, ' +
          'arrows pan, Shift+arrows pixel. Magenta: not a number.'),
    inspector(viewer), h('h3', {}, 'Where they differ most'), controls.crops
  ];
}

function sceneSection(index, budget) {
  const scene = scenes[index];
  forgetOtherScenes(index);
  if (scene.failure) {
    viewer = null;
    return section('scene', scene.name, h('p', {class: 'alert'}, scene.failure));
  }
  return section(
      'scene', scene.name,
      h('p', {class: 'facts'}, `${number(scene.triangles, 6)} triangles${scene.hash ? `, content ${scene.hash}` : ''}`),
      referenceNotes(index), listOf(scene, 'warnings').map(text => h('p', {class: 'alert'}, text)),
      pictureSection(index, budget), h('h3', {}, 'Numbers'), resultTable(index, budget), timeSection(index, budget),
      walkTable(index, budget),
      variants.length > 1 ?
          [
            h('h3', {}, 'Differences'),
            pairTable(index, budget) || h('p', {class: 'hint'}, 'No pairs with common seeds.')
          ] :
          null,
      h('h3', {}, 'Cost'), h('div', {class: 'beside'}, passChart(index, budget), memoryChart(index, budget)),
      h('details', {}, h('summary', {}, 'All metrics'), metricTable(index, budget)));
}
