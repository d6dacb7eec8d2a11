// SPDX-License-Identifier: Apache-2.0
// An experiment of a paper: its numbers beside ours, and whether its trends hold.

function reproductionSection() {
  const reproduction = results.reproduction;
  if (!reproduction) return null;
  const setting = reproduction.quick ? 'quick setting' : 'full setting';
  const rows =
      listOf(reproduction, 'values')
          .map(value => ({
                 cells: [
                   value.label, {
                     show: value.ours === undefined ? '–' : number(value.ours),
                     value: value.ours,
                     title: value.ours === undefined ? 'not measured' : String(value.ours)
                   },
                   {show: value.paper === undefined ? '–' : number(value.paper), value: value.paper}, value.unit
                 ]
               }));
  const marks = {holds: '✓', fails: '✗', unknown: '?'};
  return section(
      'reproduction', `${reproduction.title} (${reproduction.place})`,
      h('p', {class: 'hint'}, `${reproduction.id}, ${setting}`),
      h('p', {}, h('b', {}, 'The paper: '), reproduction.claim),
      reproduction.differences ? h('p', {}, h('b', {}, 'Here: '), reproduction.differences) : null,
      h('ul', {class: 'trends'},
        listOf(reproduction, 'trends')
            .map(
                trend =>
                    h('li', {class: trend.verdict, title: trend.expression},
                      `${marks[trend.verdict]} ${trend.claim}: ${
                          trend.unlike_machines           ? 'unknown, since the machines differ' :
                              trend.verdict === 'unknown' ? 'not measured' :
                                                            trend.verdict}`))),
      rows.length ?
          sortableTable(
              'measured beside the paper', [{name: ''}, {name: 'measured'}, {name: 'paper'}, {name: 'unit'}], rows) :
          null);
}
