// SPDX-License-Identifier: Apache-2.0
// An experiment of a paper, or of the project itself: its numbers beside ours, whether its trends hold, and its plots.

const variantIndex = line => variants.findIndex(entry => entry.label === line.label);

// The colours and points of a line are those of its technique in all other plots.
function plotConfig(plot) {
  const sets = listOf(plot, 'lines').filter(line => line.points.length).map(line => {
    const style = variantStyle(variantIndex(line));
    return {
      label: line.label,
      data: line.points,
      borderColor: style.color,
      backgroundColor: style.color,
      borderDash: style.dash,
      borderWidth: 2,
      pointStyle: style.point,
      pointRadius: 4
    };
  });
  const points = sets.flatMap(set => set.data);
  return {
    type: 'line',
    data: {datasets: sets},
    options: {
      maintainAspectRatio: false,
      parsing: false,
      scales: {
        x: logAxis(plot.x_label, logRange(points.map(p => p.x))),
        y: logAxis(plot.y_label, logRange(points.map(p => p.y)))
      },
      plugins: {
        legend: {position: 'bottom', labels: {usePointStyle: true}},
        tooltip: {
          callbacks:
              {title: () => '', label: item => `${item.dataset.label}: ${number(item.raw.y)} at ${number(item.raw.x)}`}
        }
      }
    }
  };
}

// The plot, and its numbers as a table: a column for each place on the horizontal axis.
function scalingPlot(plot) {
  const lines = listOf(plot, 'lines');
  const places = [...new Set(lines.flatMap(line => line.points.map(p => p.x)))].sort((a, b) => a - b);
  const rows = lines.map(line => {
    const at = x => (line.points.find(p => p.x === x) || {}).y;
    return {
      cells: [
        labelCell(variantIndex(line)), ...places.map(x => ({value: at(x), show: number(at(x))})),
        {value: line.slope, show: number(line.slope, 2)}
      ]
    };
  });
  const columns = [
    {name: 'technique'}, ...places.map(x => ({name: number(x), title: `${plot.x_label}: ${x}`})),
    {name: 'slope', title: 'of log over log, least squares: 1 is proportional, 0 does not grow'}
  ];
  return h(
      'div', {class: 'plot'}, h('h3', {}, plot.title),
      places.length ? h('figure', {},
                        addChart(`${plot.title}: ${plot.y_label} over ${plot.x_label}`, 320, () => plotConfig(plot))) :
                      h('p', {class: 'hint'}, 'Nothing of it was measured.'),
      places.length ? sortableTable(`${plot.y_label} over ${plot.x_label}`, columns, rows) : null);
}

// What would push the summary out of sight is closed at first.
const shownAtFirst = 20;
function folded(count, title, content) {
  return count > shownAtFirst ? h('details', {}, h('summary', {}, title), content) : content;
}

function verdictCounts(trends) {
  const count = verdict => trends.filter(trend => trend.verdict === verdict).length;
  return `${trends.length} trends: ${count('holds')} hold, ${count('fails')} fail, ${count('unknown')} unknown`;
}

function trendItem(trend) {
  const marks = {holds: '✓', fails: '✗', unknown: '?'};
  const said = trend.unlike_machines ? 'unknown, since the machines differ' :
      trend.verdict === 'unknown'    ? 'not measured' :
                                       trend.verdict;
  return h('li', {class: trend.verdict, title: trend.expression}, `${marks[trend.verdict]} ${trend.claim}: ${said}`);
}

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
                   ...(reproduction.own ?
                           [] :
                           [{show: value.paper === undefined ? '–' : number(value.paper), value: value.paper}]),
                   value.unit
                 ]
               }));
  const trends = listOf(reproduction, 'trends');
  return section(
      'reproduction', `${reproduction.title} (${reproduction.place})`,
      h('p', {class: 'hint'}, `${reproduction.id}, ${setting}`),
      h('p', {}, h('b', {}, reproduction.own ? 'Claim: ' : 'The paper: '), reproduction.claim),
      reproduction.differences ? h('p', {}, h('b', {}, 'Here: '), reproduction.differences) : null,
      folded(trends.length, verdictCounts(trends), h('ul', {class: 'trends'}, trends.map(trend => trendItem(trend)))),
      rows.length ?
          folded(
              rows.length, `${rows.length} values`,
              sortableTable(
                  reproduction.own ? 'measured' : 'measured beside the paper',
                  ['', 'measured', ...(reproduction.own ? [] : ['paper']), 'unit'].map(name => ({name})), rows)) :
          null,
      h('div', {class: 'beside'}, listOf(reproduction, 'plots').map(scalingPlot)));
}
