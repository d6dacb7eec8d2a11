// SPDX-License-Identifier: Apache-2.0
// results.json (docs/results.md) and the list of images, with the questions that the page asks of them.

const results = JSON.parse(document.getElementById('results').textContent);
const imageList = JSON.parse(document.getElementById('image-list').textContent);
const listOf = (owner, key) => (owner && Array.isArray(owner[key]) ? owner[key] : []);
const variants = listOf(results, 'variants');
const scenes = listOf(results, 'scenes');
const budgets = listOf(results, 'budgets');
const metrics = listOf(results, 'metrics');

const variantLabel = index => (variants[index] ? variants[index].label : `technique ${index + 1}`);
const sceneName = index =>
    (typeof index === 'number' ? (scenes[index] ? scenes[index].name : `scene ${index + 1}`) : String(index));

function budgetLabel(index) {
  const budget = budgets[index];
  if (!budget) return '';
  if (budget.label) return budget.label;
  if (budget.seconds) return `equal time: ${seconds(budget.seconds)}`;
  if (budget.iterations) return `${budget.iterations} iterations`;
  if (budget.samples) return `${budget.samples} samples per pixel`;
  return `time to relMSE ${number(budget.relmse)}`;
}

const summaryOf = (scene, variant, budget) =>
    listOf(results, 'summaries').find(s => s.scene === scene && s.variant === variant && s.budget === budget);
const piecesOf = (scene, variant, budget) =>
    listOf(results, 'pieces').filter(p => p.scene === scene && p.variant === variant && p.budget === budget);
const sceneVariant = (scene, variant) => listOf(scenes[scene], 'variants')[variant] || {};

// Where pieces of a scene ran on machines of several kinds, wall time says which machine is faster, too: it ranks
// nothing, nor do errors of a budget of time.
const unlikeMachines = scene => Boolean((scenes[scene] || {}).unlike_machines);
const isRanked = (scene, budget) => !(unlikeMachines(scene) && (budgets[budget] || {}).seconds);

// The metric that decides: relMSE where it is there. Names are looked up whatever their case.
function metricValue(summary, name) {
  const entry =
      Object.entries((summary && summary.metrics) || {}).find(([key]) => key.toLowerCase() === name.toLowerCase());
  return entry && entry[1] && typeof entry[1].mean === 'number' ? entry[1] : undefined;
}
const relmse = summary => metricValue(summary, 'relmse');

// What stands in the way of a number: refused, failed, not run yet.
function obstacles(scene, variant, budget) {
  const refused = sceneVariant(scene, variant).refused;
  if (refused) return [`refused: ${refused}`];
  const reference = listOf(scenes[scene], 'references')[sceneVariant(scene, variant).reference || 0];
  const texts = [];
  if (reference && reference.failure) texts.push(`no reference: ${reference.failure}`);
  for (const piece of piecesOf(scene, variant, budget)) {
    if (piece.failure) texts.push(`seed ${piece.seed} failed: ${piece.failure}`);
  }
  if (!texts.length && !summaryOf(scene, variant, budget)) texts.push('not run');
  return texts;
}

// Everything that went wrong, over all scenes.
function allFailures() {
  const lines = [];
  scenes.forEach((scene, s) => {
    if (scene.failure) lines.push(`${scene.name}: ${scene.failure}`);
    for (const reference of listOf(scene, 'references')) {
      if (reference.failure) lines.push(`${scene.name}, reference: ${reference.failure}`);
    }
    listOf(scene, 'variants').forEach((entry, v) => {
      if (entry.refused) lines.push(`${scene.name}, ${variantLabel(v)} refused: ${entry.refused}`);
    });
  });
  for (const piece of listOf(results, 'pieces')) {
    if (piece.failure)
      lines.push(`${sceneName(piece.scene)}, ${variantLabel(piece.variant)}, seed ${piece.seed}: ${piece.failure}`);
  }
  return lines;
}

// Seconds over the pieces of one summary by pass, longest first.
function meanPasses(scene, variant, budget) {
  const done = piecesOf(scene, variant, budget).filter(piece => !piece.failure);
  const sums = new Map();
  for (const piece of done) {
    for (const pass of listOf(piece, 'passes'))
      sums.set(pass.name, (sums.get(pass.name) || 0) + pass.device_seconds / done.length);
  }
  return [...sums].map(([name, time]) => ({name, time})).sort((a, b) => b.time - a.time);
}
