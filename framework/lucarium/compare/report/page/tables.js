// SPDX-License-Identifier: Apache-2.0
// Tables that sort when a header is pressed. A cell is a node, text, or { show, value, title }; rows of one cell with
// `span` fill the width.

function sortableTable(caption, columns, rows, className = 'numbers') {
  const body = h('tbody');
  let order = null, direction = 1;
  const fill = () => {
    const value = row => {
      const v = row.cells[order];
      return v && typeof v === 'object' && 'value' in v ? v.value : undefined;
    };
    const sorted = order === null ? rows : [...rows].sort((a, b) => {
      const x = value(a), y = value(b);
      if (x === undefined || y === undefined) return (x === undefined) - (y === undefined);
      return direction * (typeof x === 'string' ? x.localeCompare(y) : x - y);
    });
    body.replaceChildren(...sorted.map(row => tableRow(row, columns.length)));
  };
  const heads = columns.map((column, i) => {
    const button = h('button', {type: 'button', title: column.title}, column.name);
    const head = h('th', {scope: 'col'}, button);
    button.addEventListener('click', () => {
      direction = order === i ? -direction : 1;
      order = i;
      heads.forEach(
          (other, k) =>
              (k === i ? other.setAttribute('aria-sort', direction > 0 ? 'ascending' : 'descending') :
                         other.removeAttribute('aria-sort')));
      fill();
    });
    return head;
  });
  fill();
  return h(
      'div', {class: 'scroll', tabindex: '0', role: 'region', 'aria-label': caption},
      h('table', {class: className}, h('caption', {}, caption), h('thead', {}, h('tr', {}, heads)), body));
}

function tableRow(row, width) {
  const cells = row.cells.map((cell, i) => {
    const plain =
        cell === null || cell === undefined || typeof cell !== 'object' || cell instanceof Node || Array.isArray(cell);
    const content = plain ? cell : cell.show;
    const attributes = plain ? {} : {title: cell.title, class: cell.class, style: cell.style};
    return i === 0 ? h('th', {scope: 'row', ...attributes}, content) : h('td', attributes, content);
  });
  if (row.span) cells.push(h('td', {colspan: String(width - cells.length), class: 'obstacle'}, row.span));
  return h('tr', {class: row.class}, cells);
}
