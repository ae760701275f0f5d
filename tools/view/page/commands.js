// Buttons for the commands that the source takes (docs/device.md, "Commands").

const kSure_ms = 3000, kAnswersKept = 30;

function element(name, attributes = {}, ...children) {
  const out = document.createElement(name);
  for (const [key, value] of Object.entries(attributes)) {
    if (key in out) out[key] = value;
    else out.setAttribute(key, value);
  }
  out.append(...children);
  return out;
}

export class Commands {
  constructor(parent, link) {
    this.parent = parent;
    this.link = link;
    this.answers = element('div', {className: 'answers'});
  }

  // `known`: names as hello lists them.
  setKnown(known) {
    this.parent.replaceChildren();
    if (known.length === 0) {
      this.parent.append(element('p', {className: 'quiet'},
                                 'This source takes no commands. A device does by --serial.'));
      return;
    }
    const has = (name) => known.includes(name);
    const row = element('div', {className: 'row'});
    if (has('reset')) row.append(this.sure('reset', 'Reset', 'forget the map and start anew'));
    if (has('record start')) row.append(this.button('record start', 'Record'));
    if (has('record stop')) row.append(this.button('record stop', 'Stop recording'));
    if (has('stop')) row.append(this.sure('stop', 'Stop', 'end the program in order'));
    this.parent.append(row);
    if (has('pose')) {
      this.parent.append(this.form('pose', 'Set pose', [
        ['x', 'x m', '0'], ['y', 'y m', '0'], ['z', 'z m', '0'], ['yaw', 'yaw °', '0'],
        ['sigma', '± m: a hint', '', 'optional']]));
    }
    if (has('map save')) {
      const form = this.form('map save', 'Save map', [['name', 'map.bin', 'map.bin', 'wide']]);
      if (has('map load')) {
        form.append(this.sureOf('Load map', 'gives up what runs for that map',
                                () => 'map load ' + form.elements.name.value, 'map load'));
      }
      this.parent.append(form);
    }
    if (has('node set')) {
      const form = this.form('node set', 'Name this place', [['name', 'dock', 'dock', 'wide']]);
      for (const [line, label] of [['node get', 'Where is it?'], ['node remove', 'Forget it']]) {
        if (!has(line)) continue;
        form.append(element('button', {type: 'button', id: id(line), onclick: () => this.ask(
            `${line} ${form.elements.name.value}`)}, label));
      }
      this.parent.append(form);
    }
    if (has('parameter')) {
      this.parent.append(this.form('parameter', 'Set', [
        ['parameter', 'health.lost_s', '', 'wide'], ['value', 'value', '']]));
    }
    this.parent.append(this.answers);
  }

  async ask(line) {
    const shown = element('div', {className: 'answer'}, `${line} …`);
    this.answers.prepend(shown);
    while (this.answers.children.length > kAnswersKept) this.answers.lastChild.remove();
    const answer = await this.link.command(line);
    shown.textContent = `${line} → ${answer}`;
    shown.classList.add(answer.startsWith('ok') ? 'ok' : 'error');
  }

  button(line, label) {
    return element('button', {type: 'button', id: id(line), onclick: () => this.ask(line)}, label);
  }

  sure(line, label, why) { return this.sureOf(label, why, () => line, line); }

  // Asks once more.
  sureOf(label, why, line, name) {
    const button = element('button', {type: 'button', id: id(name), title: why}, label);
    let timer = 0;
    const calm = () => {
      clearTimeout(timer);
      button.classList.remove('sure');
      button.textContent = label;
    };
    button.onclick = () => {
      if (button.classList.contains('sure')) {
        calm();
        this.ask(line());
        return;
      }
      button.classList.add('sure');
      button.textContent = label + ': sure?';
      timer = setTimeout(calm, kSure_ms);
    };
    return button;
  }

  form(line, label, fields) {
    const form = element('form', {autocomplete: 'off'});
    for (const [name, placeholder, value, size] of fields) {
      form.append(element('input', {name, placeholder, value, className: size || '',
                                    'aria-label': placeholder,
                                    required: size !== 'optional'}));
    }
    form.append(element('button', {type: 'submit', id: id(line)}, label));
    form.onsubmit = (event) => {
      event.preventDefault();
      const words = fields.map(([name]) => form.elements[name].value.trim());
      this.ask([line, ...words].filter(Boolean).join(' '));
    };
    return form;
  }
}

function id(line) { return 'command-' + line.replace(/ /g, '-'); }
