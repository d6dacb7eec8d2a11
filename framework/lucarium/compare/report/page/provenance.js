// SPDX-License-Identifier: Apache-2.0
// What was run, on what, and how the numbers are defined.

function definitions(pairs) {
  return h(
      'dl', {},
      pairs.filter(([, value]) => value !== undefined && value !== '')
          .flatMap(([key, value]) => [h('dt', {}, key), h('dd', {}, String(value))]));
}

function provenanceSection() {
  const machine = results.machine || {};
  const techniques = variants.map(
      (entry, v) => h('article', {}, h('h3', {}, marker(v), entry.label), h('p', {}, entry.summary || ''), definitions([
                        ['technique', entry.technique], ['version', entry.version], ['source', entry.citation],
                        ...Object.entries(entry.parameters || {})
                      ])));
  const formulas =
      metrics.map(m => ({cells: [m.name, {show: h('code', {}, m.formula), class: 'text'}, m.unit || '1', m.better]}));
  return section(
      'provenance', 'How this was made', definitions([
        ['Lucarium', results.version], ['started', results.started], ['device', results.device],
        ['driver', results.driver], ['processor', machine.cpu], ['logical cores', machine.logical_cores],
        ['memory', machine.memory_bytes && bytes(machine.memory_bytes)], ['system', machine.system]
      ]),
      h('details', {}, h('summary', {}, 'Techniques and parameters'), h('div', {class: 'cards'}, techniques)),
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
