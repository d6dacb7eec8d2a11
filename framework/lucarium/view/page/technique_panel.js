// SPDX-License-Identifier: Apache-2.0
// Which technique runs on a side, with which parameters; what is wanted beside what runs.

class TechniquePanel {
  // `beside`: what chooses the side, in front.
  constructor(view, ask, beside) {
    Object.assign(this, {view, ask, side: 0});
    this.name = '';
    this.given = new Map();
    this.controls = new Map();
    this.refusal = h('div', {role: 'alert', class: 'refusal'});
    this.facts = h('div', {class: 'facts'});
    this.body = h('div', {});
    const options = view.techniques.map(t => h('option', {value: t.name}, t.name));
    this.box = h('select', {id: 'technique', onchange: () => this.choose(this.box.value, [])}, options);
    const named = view.named.length > 1 ? h('div', {class: 'row', role: 'group', 'aria-label': 'named at the start'},
      view.named.map((t, i) => h('button', {type: 'button', title: parameterText(t.parameters),
        onclick: () => this.choose(t.name, t.parameters)}, `${i + 1} ${t.name}`))) : undefined;
    this.node = h('details', {class: 'panel', open: true}, h('summary', {}, 'Technique'), beside,
      h('div', {class: 'row'}, h('label', {class: 'control'}, h('span', {}, 'Technique'), this.box)), named,
      this.refusal, this.facts, this.body);
  }

  choose(name, parameters) {
    this.given = new Map(parameters);
    this.build(name);
    this.send();
  }

  build(name) {
    this.name = name;
    this.box.value = name;
    this.controls.clear();
    const technique = this.view.techniques.find(t => t.name === name);
    if (!technique) return;
    const make = parameter => {
      const control = parameterControl(parameter, text => this.change(parameter, text));
      this.controls.set(parameter.name, control);
      control.set(this.given.get(parameter.name) ?? parameter.default, this.given.has(parameter.name));
      return control.node;
    };
    const basic = technique.parameters.filter(p => !p.advanced),
          advanced = technique.parameters.filter(p => p.advanced);
    this.body.replaceChildren(h('p', {class: 'note'}, technique.summary),
      ...basic.map(make),
      ...(advanced.length ? [h('details', {}, h('summary', {}, 'Advanced'), advanced.map(make))] : []),
      ...(technique.parameters.length ?
        [h('button', {type: 'button', onclick: () => this.choose(name, [])}, 'Defaults')] : []));
  }

  change(parameter, text) {
    if (parameter.preset) this.given.clear();
    this.given.set(parameter.name, text);
    this.controls.get(parameter.name)?.set(text, true);
    this.asked = performance.now();  // a state that was on its way does not undo it
    clearTimeout(this.timer);
    this.timer = setTimeout(() => this.send(), 120);
  }

  async send() {
    this.asked = performance.now();
    const parameters = [...this.given];
    const why = await this.ask({do: 'technique', name: this.name, parameters, side: this.side});
    if (why) this.showRefusal(why);
  }

  // The other side, as it is.
  setSide(side) {
    clearTimeout(this.timer);
    this.side = side;
    this.asked = undefined;
  }

  // Back to what runs.
  goBack(running) {
    this.choose(running.name, running.parameters);
  }

  showRefusal(why, running) {
    this.refusal.replaceChildren(...(why ? [h('p', {class: 'alert'}, why,
      running ? [' ', h('button', {type: 'button', onclick: () => this.goBack(running)},
        `Back to ${running.name}`)] : [])] : []));
  }

  update(status) {
    const wanted = status.wanted, running = status.running;
    const settled = !this.asked || performance.now() - this.asked > 600;
    const same = wanted.name === this.name && parameterText(wanted.parameters) === parameterText([...this.given]);
    if (!same && settled) {
      this.given = new Map(wanted.parameters);
      this.build(wanted.name);
    }
    this.showRefusal(status.refusal, running);
    if (!running) return;
    if (running.name === this.name && !status.refusal && (same || settled)) {
      for (const [name, control] of this.controls) control.set(running.values[name], this.given.has(name));
    }
    this.facts.replaceChildren(h('div', {id: 'light-paths'}, `Light paths: ${pathText(running)}`),
      ...running.limitations.map(text => h('div', {}, `Limitation: ${text}`)));
  }
}

// What differs from all light paths, readable.
function pathText({light, paths}) {
  if (!light) return 'none, it shows something else';
  return paths ? `all, with ${paths.replaceAll(',', ', ')}` : 'all';
}

const parameterText = parameters => parameters.map(([key, value]) => `${key}=${value}`).join(',');

const nameOf = ({name, parameters}) => [name, parameterText(parameters)].filter(Boolean).join(' ');
