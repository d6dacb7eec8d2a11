// SPDX-License-Identifier: Apache-2.0
// Lights, materials and environment: edits in the words of the command line.

const linearOf = code => (code <= 0.04045 ? code / 12.92 : ((code + 0.055) / 1.055) ** 2.4);

// A colour field and its strength for linear RGB: the strength is the largest component.
function colorControl(label, rgb, change, withStrength = true) {
  const strength = Math.max(...rgb), shown = rgb.map(v => (strength > 0 ? v / (withStrength ? strength : 1) : 1));
  const hex = shown.map(v => srgb(v).toString(16).padStart(2, '0')).join('');
  const color = h('input', {type: 'color', value: `#${hex}`, 'aria-label': `${label}: colour`});
  const field = h('input', {type: 'number', min: '0', step: 'any', value: String(Number(strength.toPrecision(5))),
    'aria-label': `${label}: strength`});
  const report = () => {
    // An untouched colour keeps its digits.
    const linear = color.value === `#${hex}` ? shown :
        [1, 3, 5].map(i => linearOf(parseInt(color.value.slice(i, i + 2), 16) / 255));
    change(linear.map(v => Number((v * (withStrength ? Number(field.value) : 1)).toPrecision(6))));
  };
  color.addEventListener('change', report);
  field.addEventListener('change', report);
  return h('span', {class: 'color-control'}, color, withStrength ? field : undefined);
}

function pointControl(label, point, change) {
  const fields = point.map((v, i) => h('input', {type: 'number', step: 'any', value: String(Number(v.toPrecision(6))),
    'aria-label': `${label}: ${'xyz'[i]}`}));
  fields.forEach(field => field.addEventListener('change', () => change(fields.map(f => Number(f.value)))));
  return h('span', {class: 'point-control'}, fields);
}

// Parts of a light's text that are vectors, by kind.
const lightParts = {
  point: [['position', 1], ['intensity', 2]],
  directional: [['direction', 1], ['intensity', 2]],
  spot: [['position', 1], ['direction', 2], ['intensity', 3]]
};

const materialFields = [
  ['base_color', 'base colour', 'color'], ['roughness', 'roughness', [0, 1]], ['metallic', 'metallic', [0, 1]],
  ['emissive_factor', 'emission', 'light'], ['emissive_strength', 'times', [0, undefined]],
  ['transmission', 'transmission', [0, 1]], ['ior', 'refractive index', [1, 5]]
];

class ScenePanel {
  constructor(connection) {
    this.connection = connection;
    this.materials = new Map();  // name → Map of key → text
    this.lights = null;
    this.environment = '';
    this.refusal = h('div', {role: 'alert', id: 'scene-refusal'});
    this.lightBox = h('div', {id: 'lights'});
    this.material = h('select', {id: 'material', onchange: () => this.showMaterial()});
    this.materialBox = h('div', {});
    this.sky = h('div', {class: 'row', id: 'environment'});
    this.node = h('details', {class: 'panel', id: 'scene'}, h('summary', {}, 'Scene'), this.refusal,
      h('h3', {}, 'Lights'), this.lightBox,
      h('h3', {}, 'Material'), h('div', {class: 'row'}, this.material), this.materialBox,
      h('h3', {}, 'Environment'), this.sky,
      h('div', {class: 'row'}, h('button', {type: 'button', id: 'scene-reset', onclick: () => this.reset()},
        'As it was'), h('span', {class: 'note'}, 'To keep the changes: “beside the scene” under “Repeat this”.')));
  }

  reset() {
    this.materials.clear();
    this.lights = null;
    this.environment = '';
    this.send();
  }

  // What is refused goes: the controls show what the scene has.
  async send() {
    const texts = [...this.materials].map(([name, values]) =>
      `${name}:${[...values].map(([key, text]) => `${key}=${text}`).join(',')}`);
    this.key = undefined;
    this.why = '';
    const why = await this.connection.ask({do: 'scene', lights: this.lights, materials: texts,
      environment: this.environment});
    if (!why) return;
    this.why = why;
    this.showRefusal(why);
    this.setScene(this.scene);
  }

  showRefusal(why) {
    this.refusal.replaceChildren(...(why ? [h('p', {class: 'alert'}, why)] : []));
  }

  setScene(scene) {
    this.scene = scene;
    // A slider of time must not take a field from under the hands.
    const key = JSON.stringify({...scene, time: 0});
    if (key === this.key) return;
    this.key = key;
    this.takeEdits(scene.edits);
    this.showLights();
    const chosen = this.material.value;
    this.material.replaceChildren(...scene.materials.map((m, i) => h('option', {value: String(i)}, m.name || `${i}`)));
    if (chosen) this.material.value = chosen;
    this.showMaterial();
    this.showEnvironment();
  }

  // Those that another page has made, or this one before it was loaded again.
  takeEdits(edits) {
    this.lights = edits.lights;
    this.environment = edits.environment;
    this.materials.clear();
    for (const text of edits.materials) {
      const at = text.lastIndexOf(':', text.indexOf('=')), values = new Map();
      for (const piece of text.slice(at + 1).split(/,(?=[a-z_]+=)/)) values.set(...piece.split('='));
      this.materials.set(text.slice(0, at), values);
    }
  }

  changeLight(index, text) {
    const texts = this.scene.lights.map(light => light.text);
    if (text === undefined)
      texts.splice(index, 1);
    else
      texts[index] = text;
    this.lights = texts;
    this.send();
  }

  showLights() {
    const row = ({name, text}, index) => {
      const pieces = text.split(':'), kind = pieces[0];
      const put = (at, values) => {
        pieces[at] = values.join(',');
        this.changeLight(index, pieces.join(':'));
      };
      const parts = lightParts[kind].map(([part, at]) => {
        const values = pieces[at].split(',').map(Number), make = part === 'intensity' ? colorControl : pointControl;
        return h('label', {class: 'control'}, h('span', {}, part), make(`light ${index} ${part}`, values,
          v => put(at, v)));
      });
      const isOn = pieces.at(lightParts[kind].at(-1)[1]).split(',').some(v => Number(v) > 0);
      const flip = h('input', {type: 'checkbox', checked: isOn, 'aria-label': `light ${index} on`,
        onchange: event => this.switchLight(index, pieces, event.target.checked)});
      return h('div', {class: 'light', 'data-light': String(index)},
        h('label', {class: 'control'}, flip, h('span', {}, name || `${kind} ${index}`)), parts,
        h('button', {type: 'button', onclick: () => this.changeLight(index)}, 'Remove'));
    };
    this.lightBox.replaceChildren(...this.scene.lights.map(row),
      this.scene.lights.length ? '' : h('p', {class: 'note'}, 'No point, spot or directional light; what else shines ' +
        'is a material or the environment.'),
      h('button', {type: 'button', id: 'add-light', onclick: () => this.addLight()}, 'Add a light at the eye'));
  }

  switchLight(index, pieces, on) {
    const at = lightParts[pieces[0]].at(-1)[1];
    this.before ??= new Map();
    if (!on) this.before.set(index, pieces[at]);
    pieces[at] = on ? this.before.get(index) || '1,1,1' : '0,0,0';
    this.changeLight(index, pieces.join(':'));
  }

  addLight() {
    if (!this.eye) return;
    const position = this.eye.map(v => Number(v.toPrecision(5))).join(',');
    this.changeLight(this.scene.lights.length, `point:${position}:1,1,1`);
  }

  showMaterial() {
    const material = this.scene.materials[Number(this.material.value)];
    if (!material) return;
    const change = (key, text) => {
      if (!this.materials.has(material.name)) this.materials.set(material.name, new Map());
      this.materials.get(material.name).set(key, text);
      this.send();
    };
    const control = ([key, label, kind]) => {
      const value = material[key], id = `material-${key}`;
      if (kind === 'color' || kind === 'light')
        return h('label', {class: 'control'}, h('span', {}, label),
          colorControl(label, value, v => change(key, v.join(',')), kind === 'light'));
      const field = h('input', {type: 'number', id, step: 'any', min: String(kind[0]), max: kind[1] && String(kind[1]),
        value: String(Number(value.toPrecision(5)))});
      field.addEventListener('change', () => field.value !== '' && change(key, field.value));
      return h('label', {class: 'control', for: id}, h('span', {}, label), field);
    };
    this.materialBox.replaceChildren(material.name ? h('div', {class: 'row'}, materialFields.map(control)) :
      h('p', {class: 'note'}, 'A material without a name cannot be changed here.'));
  }

  showEnvironment() {
    const text = this.scene.environment, constant = text !== '' && text !== 'none';
    const choose = value => {
      this.environment = value === 'constant' ? '0.5,0.5,0.5' : value;
      this.send();
    };
    this.sky.replaceChildren(selectBox('Light from outside', [['', 'of the scene'], ['none', 'none'],
      ['constant', 'one colour']], constant ? 'constant' : text, choose),
      constant ? colorControl('environment', text.split(',').map(Number), v => {
        this.environment = v.join(',');
        this.send();
      }) : '');
  }

  update(status) {
    this.eye = status.camera.eye;
    this.showRefusal(this.why || status.scene_refusal);
  }
}
