// SPDX-License-Identifier: Apache-2.0
// Elements are built from values; text from the data only ever becomes text nodes and attributes, never markup.

function h(tag, properties, ...children) {
  const node = document.createElement(tag);
  for (const [key, value] of Object.entries(properties || {})) {
    if (value === undefined || value === null || value === false) continue;
    if (key.startsWith('on'))
      node.addEventListener(key.slice(2), value);
    else if (key === 'style')
      node.style.cssText = value;  // an attribute would need a policy that allows it
    else if (key in node && typeof value !== 'string')
      node[key] = value;
    else
      node.setAttribute(key, value);
  }
  node.append(...children.flat(Infinity).filter(child => child !== null && child !== undefined && child !== false));
  return node;
}

// A labelled <select>; options are [value, text].
function selectBox(label, options, value, change) {
  const box =
      h('select', {onchange: event => change(event.target.value)},
        options.map(([key, text]) => h('option', {value: String(key), selected: String(key) === String(value)}, text)));
  return h('label', {class: 'control'}, h('span', {}, label), box);
}

// A labelled slider with a readout; `show` turns its value into text. A double click sets it back.
function slider(label, range, value, show, change, title) {
  const readout = h('output', {}, show(value));
  const input =
      h('input', {type: 'range', min: String(range[0]), max: String(range[1]), step: String(range[2]), title});
  const initial = value;
  const set = next => {
    const clamped = Math.min(range[1], Math.max(range[0], next));
    input.value = String(clamped);
    readout.textContent = show(clamped);
    change(clamped);
  };
  input.value = String(value);
  input.addEventListener('input', () => set(Number(input.value)));
  input.addEventListener('dblclick', () => set(initial));
  const node = h('label', {class: 'control'}, h('span', {}, label), input, readout);
  node.setValue = set;
  return node;
}

function section(id, title, ...children) {
  return h('section', {id, 'aria-label': title}, h('h2', {}, title), ...children);
}
