// SPDX-License-Identifier: Apache-2.0
// What was run, on what, and how the numbers are defined.

function definitions(pairs) {
  return h(
      'dl', {},
      pairs.filter(([, value]) => value !== undefined && value !== '')
          .flatMap(([key, value]) => [h('dt', {}, key), h('dd', {}, String(value))]));
}

// The values of a parameter that budgets of time lowered, in the order of the pieces.
function plannedValues(v, name) {
  const values = new Set();
  for (const piece of listOf(results, 'pieces').filter(piece => piece.variant === v && piece.planned)) {
    const assignment = (piece.parameters || '').split(',').find(text => text.startsWith(`${name}=`));
    if (assignment) values.add(assignment.slice(name.length + 1));
  }
  values.delete(variants[v].parameters[name]);
  return [...values];
}

// All parameters in effect; those that the comparison sets are bold.
function parameterList(v) {
  const given = new Set(listOf(variants[v], 'given'));
  const rows = Object.entries(variants[v].parameters || {}).map(([name, value]) => {
    const planned = plannedValues(v, name);
    return [
      h('dt', {}, given.has(name) ? h('strong', {}, name) : name),
      h('dd', {}, given.has(name) ? h('strong', {}, value) : value,
        planned.length ? ` (for a budget of time: ${planned.join(', ')})` : '')
    ];
  });
  return h('dl', {class: 'parameters'}, rows);
}

function provenanceSection() {
  const machine = results.machine || {};
  const techniques = variants.map(
      (entry, v) =>
          h('article', {}, h('h3', {}, marker(v), entry.label), h('p', {}, entry.summary || ''),
            definitions([['technique', entry.technique], ['version', entry.version], ['source', entry.citation]]),
            parameterList(v)));
  const formulas =
      metrics.map(m => ({cells: [m.name, {show: h('code', {}, m.formula), class: 'text'}, m.unit || '1', m.better]}));
  return section(
      'provenance', 'How this was made', definitions([
        ['Lucarium', results.version], ['started', results.started], ['device', results.device],
        ['driver', results.driver], ['processor', machine.cpu], ['logical cores', machine.logical_cores],
        ['memory', machine.memory_bytes && bytes(machine.memory_bytes)], ['system', machine.system]
      ]),
      h('details', {}, h('summary', {}, 'Techniques and parameters'),
        h('p', {class: 'note'}, 'Bold: set in the comparison. All others have the technique’s defaults.'),
        h('div', {class: 'cards'}, techniques)),
      h('details', {}, h('summary', {}, 'Metrics'),
        sortableTable(
            'Definitions', ['metric', 'formula', 'unit', 'better'].map(name => ({name})), formulas, 'numbers left')),
      h('details', {}, h('summary', {}, 'The comparison as a file'),
        h('pre', {}, JSON.stringify(results.comparison || {}, null, 2))),
      precisionNote());
}

function precisionNote() {
  const bits = imageList.images.filter(i => i.mantissa_bits > 0).map(i => i.mantissa_bits);
  const worst = bits.length ? 2 ** -(Math.min(...bits) + 1) : 0;
  return h(
      'p', {class: 'note', id: 'precision'},
      bits.length ? `Pictures in this page are within ${percent(worst)} of the values in the files. ` : '',
      imageList.notes.join(' '),
      imageList.notes.length ? ' lucarium report --link-images keeps all of it in files beside the page.' : '');
}
