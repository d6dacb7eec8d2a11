// SPDX-License-Identifier: Apache-2.0
// Runs in a report: presses its controls and writes what it found into <pre id="selftest">, one line per check.
(() => {
  const problems = [];
  addEventListener('error', event => problems.push(`error: ${event.message}`));
  addEventListener('unhandledrejection', event => problems.push(`rejected: ${event.reason}`));
  console.error = (...words) => problems.push(`console.error: ${words.join(' ')}`);
  console.warn = (...words) => problems.push(`console.warn: ${words.join(' ')}`);

  const lines = [];
  const check = (name, passed) => lines.push(`${passed ? 'ok' : 'FAILED'} ${name}`);
  const pause = time => new Promise(done => setTimeout(done, time));
  const canvas = () => document.querySelector('.viewer-canvas');
  const pixels = () => {
    const c = canvas(), data = c.getContext('2d').getImageData(0, 0, c.width, c.height).data;
    let sum = 0;
    for (let i = 0; i < data.length; ++i) sum = (sum * 31 + data[i]) % 4294967291;
    return sum;
  };
  // Waits for what is waited for: a busy machine is slow, not wrong. report_browser.py ends what waits in vain.
  const until = async holds => {
    while (!holds()) await pause(20);
    return true;
  };
  const drawn = async () => {
    await until(() => canvas().dataset.asked && canvas().dataset.drawn === canvas().dataset.asked);
    return pixels();
  };
  const press = (key, more = {}) =>
      canvas().dispatchEvent(new KeyboardEvent('keydown', {key, bubbles: true, cancelable: true, ...more}));
  const select = label => [...document.querySelectorAll('#scene .control')]
                              .find(c => c.firstChild.textContent === label)
                              ?.querySelector('select');
  const choose = (label, value) => {
    const s = select(label);
    s.value = value;
    s.dispatchEvent(new Event('change'));
  };
  const changes = async (name, act) => {
    const before = await drawn();
    await act();
    check(name, await drawn() !== before);
  };

  async function pictures() {
    await drawn();
    check('the viewer has been drawn', Boolean(canvas().dataset.drawn));
    const start = await drawn();
    await changes('key 2 flips the left picture', () => press('2'));
    press('1');
    check('key 1 brings it back', await drawn() === start);
    await changes('x swaps', () => press('x'));
    press('x');
    await changes('exposure changes the pictures', () => press(']'));
    press('[');
    check('and comes back', await drawn() === start);
    await changes('e shows the error', () => press('e'));
    check('with its scale', document.querySelectorAll('.legend .scale').length === 1);
    await changes('e shows FLIP', () => press('e'));
    check('FLIP maps are there', [...select('as').options].some(o => o.value === 'flip'));
    press('e');
    await changes('a layer is shown', () => choose('Layer', 'indirect'));
    choose('Layer', '');
    await changes('the mean is shown', () => press('m'));
    press('m');
    await changes('+ zooms', () => press('+'));
    canvas().focus();
    await changes('arrows pan', () => press('ArrowRight'));
    press('0');
    check('0 fits again', await drawn() === start);
    await changes('g shows all', () => press('g'));
    press('g');
    await changes('the split moves', async () => {
      const box = canvas().getBoundingClientRect(), y = box.top + box.height / 2;
      canvas().setPointerCapture = () => {};
      const send = (type, x) => canvas().dispatchEvent(
          new PointerEvent(type, {clientX: box.left + x * box.width, clientY: y, pointerId: 1, bubbles: true}));
      send('pointerdown', 0.5);
      send('pointermove', 0.3);
      send('pointermove', 0.25);
      send('pointerup', 0.25);
    });
    press('ArrowLeft', {shiftKey: true});
    check(
        'the inspector has a row per picture',
        await until(() => document.querySelectorAll('.inspector tbody tr').length === select('Left').options.length));
    check('and numbers', !/NaN|undefined/.test(document.querySelector('.inspector').textContent));
    press('Escape');
    check('windows are chosen', await until(() => document.querySelectorAll('.crops .crop').length >= 3));
    await changes('a window is gone to', () => document.querySelector('.crop').click());
    press('0');
  }

  async function page() {
    check(
        'nothing broke out of its text',
        !document.querySelector('img') && !/undefined|\[object/.test(document.getElementById('main').innerText));
    check('plots have been drawn', [...document.querySelectorAll('.chart canvas')].every(c => c.width > 0));
    check(
        'refused and failed are named',
        /refused/.test(document.getElementById('overview').innerText) &&
            /killed by signal/.test(document.getElementById('overview').innerText));
    const tables = [...document.querySelectorAll('#overview table')].map(table => table.innerText);
    check(
        'the best of each scene is named, and by how much',
        /^Best on each scene: .* 2 of 2/.test(tables[0]) &&
            /technique_1 has 3 times its relMSE, no difference/.test(tables[0]));
    const own = document.getElementById('reproduction');
    check('what is of no paper has no column for it', !/paper/i.test(own.innerText) && /Claim: /.test(own.innerText));
    check(
        'a plot has its numbers beside it',
        own.querySelectorAll('.plot canvas[aria-label="Growth: time [s] over triangles"]').length === 1 &&
            own.querySelectorAll('.plot tbody tr').length === 3 &&
            /0\.1\s+1\s+10\s+1\s/.test(own.querySelector('.plot table').innerText + '\n'));
    const parameters = document.querySelector('#provenance dl.parameters');
    check(
        'parameters that were given are bold',
        parameters.querySelectorAll('strong').length === 2 &&
            parameters.querySelector('dt strong').textContent === 'name');
    check('what a budget lowered is said', /64 \(for a budget of time: 16\)/.test(parameters.textContent));
    check('a refused technique has a row', Boolean(document.querySelector('#scene td.obstacle')));
    const sections = () => document.getElementById('scene').innerText;
    const curves = () => [...document.querySelectorAll('#scene .chart canvas')]
                             .map(c => c.getAttribute('aria-label'))
                             .filter(label => label.startsWith('relMSE over '));
    check('curves are drawn over both times', /over seconds .*over processor seconds/.test(curves().join()));
    check(
        'there are tables of both',
        /Seconds to reach a relMSE/.test(sections()) && /Processor seconds to reach a relMSE/.test(sections()));
    check('the best is bold', Boolean(document.querySelector('#scene tr.best')));
    document.querySelector('#scene thead button').click();
    check('tables sort', Boolean(document.querySelector('#scene th[aria-sort]')));
    document.querySelector('.toggle').click();
    check('techniques can be hidden', document.querySelector('.toggle').getAttribute('aria-pressed') === 'false');
    document.querySelector('.toggle').click();
    await changes('the theme changes', async () => {
      press('e');
      await drawn();
      document.getElementById('theme').click();
    });
    check('the address says so', /theme=/.test(location.hash));
    const tabs = [...document.querySelectorAll('nav button')];
    tabs[1].click();
    await drawn();
    check('another scene is shown', document.querySelector('#scene h2').textContent === tabs[1].textContent);
    check('unlike machines are said', /machines of several kinds/.test(sections()));
    check('their wall time is not drawn', curves().length === 1 && curves()[0].startsWith('relMSE over processor'));
    check(
        'nor in a table', !/(^|\n)Seconds to reach/.test(sections()) && /Processor seconds to reach/.test(sections()));
    check(
        'and nothing is ranked',
        !document.querySelector('#scene .best, #scene .leading, #scene .better') &&
            /unlike machines/.test(document.getElementById('overview').innerText));
    const shown = name => select(name).selectedOptions[0].textContent;
    check(
        'a technique stands beside its own reference',
        shown('Left').endsWith('reference 2') && shown('Right').endsWith('technique_1'));
    [...document.querySelectorAll('nav button')].pop().click();
    check('a scene that failed says why', /no such file/.test(document.getElementById('scene').innerText));
    document.querySelectorAll('nav button')[0].click();
    await drawn();
  }

  (async () => {
    try {
      await pictures();
      await page();
    } catch (error) {
      problems.push(`exception: ${error.stack}`);
    }
    check(`no errors ${problems.join('; ')}`, problems.length === 0);
    document.body.append(
        Object.assign(document.createElement('pre'), {id: 'selftest', textContent: `${lines.join('\n')}\nend`}));
  })();
})();
