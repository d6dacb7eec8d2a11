// SPDX-License-Identifier: Apache-2.0
// A control for each type of parameter, as the technique declares it.

// [low, high] of a number's range; nothing where it is not of that form.
function rangeOf(parameter) {
  const ends = parameter.range.split(' … ').map(Number);
  return ends.length === 2 && ends.every(Number.isFinite) ? ends : undefined;
}

// Where a thousand positions would leave out nearly all that is of use, there is a field alone.
const widestSlider = 1e9;

// Positions 0 … 1000 of a slider: in proportion, or where the range spans more, by the logarithm.
function sliderScale([low, high]) {
  if (low > 0 && high / low > 100) {
    const span = Math.log(high / low);
    return {toValue: t => low * Math.exp(span * t / 1000), toPosition: v => 1000 * Math.log(v / low) / span};
  }
  if (low >= 0 && high > 1000) {  // from 0: the cube
    return {toValue: t => low + (high - low) * (t / 1000) ** 3,
      toPosition: v => 1000 * Math.cbrt((v - low) / (high - low))};
  }
  return {toValue: t => low + (high - low) * t / 1000, toPosition: v => 1000 * (v - low) / (high - low)};
}

function numberControls(parameter, id, change) {
  const whole = parameter.type === 'int', range = rangeOf(parameter);
  const field = h('input', {type: 'number', id, step: whole ? '1' : 'any', min: range && String(range[0]),
    max: range && String(range[1])});
  field.addEventListener('change', () => field.value !== '' && change(field.value));
  const nodes = [field];
  let slide;
  if (range && range[1] > range[0] && range[1] - range[0] <= widestSlider) {
    const scale = sliderScale(range);
    slide = h('input', {type: 'range', min: '0', max: '1000', step: '1', 'aria-label': `${parameter.name}, slider`});
    slide.addEventListener('input', () => {
      const value = scale.toValue(Number(slide.value));
      field.value = String(whole ? Math.round(value) : Number(value.toPrecision(3)));
    });
    slide.addEventListener('change', () => change(field.value));
    nodes.push(slide);
    slide.place = value => slide.value = String(Math.round(scale.toPosition(value)));
  }
  return {nodes, set: text => {
    field.value = text;
    if (slide) slide.place(Number(text));
  }};
}

function choiceControl(parameter, id, change) {
  const box = h('select', {id, onchange: event => change(event.target.value)},
    parameter.choices.map(choice => h('option', {value: choice}, choice)));
  return {nodes: [box], set: text => box.value = text};
}

function flagControl(parameter, id, change) {
  const box = h('input', {type: 'checkbox', id, onchange: event => change(event.target.checked ? 'on' : 'off')});
  return {nodes: [box], set: text => box.checked = text === 'on'};
}

// { node, set(text, given) }: `change` gets the new text.
function parameterControl(parameter, change) {
  const id = `parameter-${parameter.name}`;
  const make = parameter.type === 'bool' ? flagControl :
      parameter.choices.length           ? choiceControl :
                                           numberControls;
  const control = make(parameter, id, change);
  const [first, ...others] = control.nodes;
  const unit = parameter.unit ? ` [${parameter.unit}]` : '';
  const words = parameter.choices.length ? '' : `${parameter.range}; `;
  const node = h('div', {class: 'parameter', 'data-name': parameter.name}, h('label', {for: id}, parameter.name + unit),
    first, others, h('span', {class: 'note'}, `${parameter.meaning} (${words}default ${parameter.default})`));
  return {node, set: (text, given) => {
    // Not under the hands of whoever is changing it.
    if (!control.nodes.includes(document.activeElement) || document.activeElement.type !== 'number') control.set(text);
    node.classList.toggle('given', given);
  }};
}
