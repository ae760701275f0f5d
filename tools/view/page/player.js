// A finished run: its rows as states, by a slider.

export class Player {
  // show: of a row {name: number}, its index
  constructor(footer, show) {
    this.footer = footer;
    this.show = show;
    const part = (id) => footer.querySelector('#' + id);
    this.playButton = part('play');
    this.slider = part('slider');
    this.position = part('position');
    this.speed = part('speed');
    this.playButton.onclick = () => this.toggle();
    this.slider.oninput = () => { this.clock = this.time(+this.slider.value); this.go(); };
    this.playing = false;
    this.rows = null;
  }

  setRun(message, array) {
    const width = message.columns.length, numbers = new Float64Array(array);
    this.columns = Object.fromEntries(message.columns.map((name, k) => {
      const column = new Float64Array(message.count);
      for (let i = 0; i < message.count; ++i) column[i] = numbers[width * i + k];
      return [name, column];
    }));
    this.names = {health: message.health_names, reasons: message.reasons_names};
    this.count = message.count;
    this.slider.max = this.count - 1;
    this.footer.hidden = false;
    this.clock = this.time(this.count - 1);
    this.index = -1;
    this.go();
  }

  time(i) { return this.columns.t[i] - this.columns.t[0]; }

  // The last row that is not later.
  find(t) {
    let low = 0, high = this.count - 1;
    while (low < high) {
      const middle = (low + high + 1) >> 1;
      if (this.time(middle) <= t + 1e-6) low = middle;
      else high = middle - 1;
    }
    return low;
  }

  toggle() {
    if (this.footer.hidden) return;
    this.playing = !this.playing;
    if (this.playing && this.index === this.count - 1) this.clock = 0;
    this.playButton.textContent = this.playing ? '❚❚' : '▶';
    this.before = performance.now();
  }

  step(rows) {
    if (this.footer.hidden) return;
    const to = Math.min(this.count - 1, Math.max(0, this.index + rows));
    this.clock = this.time(to);
    this.go();
  }

  // Each picture.
  tick(now) {
    if (!this.playing) return;
    this.clock += (now - this.before) / 1000 * +this.speed.value;
    this.before = now;
    if (this.clock >= this.time(this.count - 1)) this.toggle();
    this.go();
  }

  go() {
    const index = this.find(this.clock);
    if (index === this.index) return;
    this.index = index;
    this.slider.value = index;
    this.position.textContent =
        `${this.time(index).toFixed(2)} / ${this.time(this.count - 1).toFixed(1)} s`;
    this.show(this.state(index), index);
  }

  state(i) {
    const c = (name) => this.columns[name][i];
    const known = (value) => (Number.isNaN(value) ? null : value);
    const sigma = known(c('sigma_p')), turn = known(c('sigma_theta'));
    const third = (value) => (value === null ? null : Array(3).fill(value / Math.sqrt(3)));
    return {
      t: c('t'), p: [c('px'), c('py'), c('pz')], q: [c('qx'), c('qy'), c('qz'), c('qw')],
      v: [c('vx'), c('vy'), c('vz')].map(known), w: null,
      sigma_p: third(sigma), sigma_theta: third(turn), sigma_v: null,
      health: this.names.health[c('health')] || null, confidence: known(c('confidence')),
      reasons: (this.names.reasons[c('reasons')] || '').split('+').filter(Boolean),
      resets: known(c('resets')) || 0,
    };
  }
}
