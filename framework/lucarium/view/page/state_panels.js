// SPDX-License-Identifier: Apache-2.0
// What the viewer is doing, what it costs, and the commands that repeat it.

// Another technique's picture is called so until the first one of its own, in whatever stage that comes.
function stageText(status) {
  const meanwhile = status.meanwhile ? `; meanwhile a picture by ${status.meanwhile}` : '';
  if (status.stage === 'preparing') {
    const {text, fraction} = status.preparing;
    return `preparing: ${text}${fraction >= 0 ? `, ${percent(fraction)}` : ''}${meanwhile}`;
  }
  return status.stage + meanwhile;
}

class StateLine {
  constructor() {
    this.lamp = h('strong', {class: 'lamp', role: 'status'}, 'connecting');
    this.numbers = h('span', {});
    this.node = h('div', {class: 'state'}, this.lamp, this.numbers);
  }

  update(status) {
    this.lamp.textContent = stageText(status);
    this.node.dataset.stage = status.stage;
    const p = status.progress;
    if (!p) {  // those before stay while the scene moves on, unless they are of another technique's picture
      if (status.stage !== 'rendering' || status.meanwhile) this.numbers.textContent = '';
      return;
    }
    const rate = p.seconds > 0 ? `${number(p.iterations / p.seconds)} iterations/s` : '';
    const coarse = status.divisor > 1 ? `coarse, 1/${status.divisor}` : '';
    const progress = p.progress > 0 && p.progress < 1 ? percent(p.progress) : '';
    this.numbers.textContent =
        [`${p.samples} samples`, `${p.iterations} iterations`, seconds(p.seconds), rate, p.phase, progress, coarse]
            .filter(Boolean).join(' · ');
  }

  closed() {
    this.lamp.textContent = 'not connected; trying again';
    this.node.dataset.stage = 'closed';
  }
}

class MachinePanel {
  constructor() {
    this.body = h('div', {});
    this.node = h('details', {class: 'panel'}, h('summary', {}, 'Inside the machine'), this.body);
    this.first = {};  // counters of the session, as they were seen first
  }

  // Those that have grown count something that goes on: only of them a rate says anything.
  grows(status, name, count) {
    const key = JSON.stringify([status.running, status.divisor]);
    if (key !== this.key) this.first = {};
    this.key = key;
    if (!(this.first[name] <= count)) this.first[name] = count;  // they may begin again
    return count > this.first[name];
  }

  update(status) {
    if (!status.machine || !this.node.open) return;
    const {passes, memory, counters} = status.machine, time = status.progress.seconds || 1;
    const table = rows => h('table', {class: 'passes'},
      rows.map(row => h('tr', {}, row.map(cell => h('td', {}, cell)))));
    const total = passes.reduce((sum, pass) => sum + pass.seconds, 0) || 1;
    this.body.replaceChildren(
      h('h3', {}, 'Time per pass'),
      table(passes.map(p => [p.name, seconds(p.seconds / p.count), percent(p.seconds / total)])),
      h('h3', {}, 'Device memory'), table(Object.entries(memory).map(([owner, size]) => [owner, bytes(size)])),
      h('h3', {}, 'Counters'), table(Object.entries(counters).map(
        ([name, count]) => [name, number(count), this.grows(status, name, count) ? `${number(count / time)}/s` : ''])));
  }
}

class RepeatPanel {
  constructor() {
    this.body = h('div', {});
    this.node = h('details', {class: 'panel'}, h('summary', {}, 'Repeat this'), this.body);
  }

  update(status) {
    if (!status.repeat) return;
    const lines = status.repeat.commands;
    const key = JSON.stringify(status.repeat);
    if (key === this.key) return;
    this.key = key;
    this.body.replaceChildren(
      status.repeat.exact ? h('p', {class: 'note'}, 'These pixels again:') :
                            h('p', {class: 'note'}, 'Light was kept from earlier cameras: press Restart for a ' +
                              'picture that a command repeats bit for bit.'),
      ...lines.flatMap(({name, line, file}) => [
        h('div', {class: 'note'}, file ? `${name}: ${file}` : name),
        h('code', {class: 'line', 'data-command': name}, line),
        copyButton('Copy', () => line),
        ...(file ? [' ', h('button', {type: 'button', class: 'save-text', 'data-file': file,
          onclick: () => keepFile({header: {file}, rest: line})}, `Save ${file}`)] : [])]));
  }
}
