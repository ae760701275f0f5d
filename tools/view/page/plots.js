// Plots over time: the last minute of what runs, or all of a run with the slider's place.
import uPlot from 'uplot';

const kWindow_s = 60, kHeight = 56, kAxis = 16, kDraw_ms = 200;

export const kPlots = [
  {title: 'Confidence', range: [0, 1], lines: [['confidence', '', '--s1']]},
  {title: 'Sigma', lines: [['position', 'cm', '--s1'], ['attitude', '°', '--s2']]},
  {title: 'Rates', lines: [['poses', 'Hz', '--s1'], ['frames', 'Hz', '--s2']]},
  {title: 'Latency', lines: [['IMU to pose', 'ms', '--s1'], ['image to pose', 'ms', '--s2'],
                             ['to page', 'ms', '--s3']]},
  {title: 'Frame', lines: [['CPU', 'ms', '--s1'], ['matches', '', '--s2', 'right']]},
];
export const kRunPlots = ['Confidence', 'Sigma', 'Frame'];

function css(name) {
  return getComputedStyle(document.documentElement).getPropertyValue(name).trim();
}

class Plot {
  constructor(parent, spec) {
    this.spec = spec;
    this.data = [[], ...spec.lines.map(() => [])];
    this.marks = [];  // where the pose jumped
    this.element = document.createElement('div');
    this.element.className = 'plot';
    const head = document.createElement('h3');
    head.innerHTML = `<b>${spec.title}</b>`;
    this.values = spec.lines.map(([label, unit, colour]) => {
      const span = document.createElement('span');
      span.style.setProperty('--c', `var(${colour})`);
      span.append(label + ' ');
      const value = document.createElement('output');
      span.append(value, unit ? ' ' + unit : '');
      head.append(span);
      return value;
    });
    this.element.append(head);
    this.holder = document.createElement('div');
    this.element.append(this.holder);
    parent.append(this.element);
    this.make();
  }

  make() {
    if (this.plot) this.plot.destroy();
    const axis = {stroke: css('--soft'), grid: {stroke: css('--grid'), width: 1},
                  ticks: {show: false}, font: '10px system-ui', gap: 2};
    const span = (min, max) => (max > min ? [Math.min(0, min), max * 1.08] : [0, (max || 0) + 1]);
    const right = this.spec.lines.some((line) => line[3] === 'right');
    const last = this.spec === kPlots[kPlots.length - 1];  // has the time of all
    this.height = kHeight + (last ? kAxis : 0);
    const axes = [{...axis, size: last ? kAxis : 0, values: last ? undefined : () => []},
                  {...axis, size: 34, space: 18}];
    if (right) axes.push({...axis, size: 34, space: 18, side: 1, scale: 'right', grid: {show: false}});
    const options = {
      width: Math.max(200, this.holder.clientWidth || 420), height: this.height, axes, padding: [5, right ? 0 : 34, last ? 2 : 6, 0],
      legend: {show: false}, cursor: {y: false, drag: {x: false, y: false}},
      scales: {
        x: {time: false},
        y: {range: this.spec.range ? () => this.spec.range : (u, min, max) => span(min, max)},
        right: {range: (u, min, max) => span(min, max)},
      },
      series: [{}, ...this.spec.lines.map(([label, unit, colour, scale]) => ({
        label, stroke: css(colour), width: 1.3, points: {show: false}, scale: scale || 'y',
        spanGaps: true,
      }))],
      hooks: {draw: [(u) => this.drawPlace(u)]},
    };
    this.plot = new uPlot(options, this.data, this.holder);
  }

  drawPlace(u) {
    u.ctx.fillStyle = css('--bad');
    for (const t of this.marks) {
      const x = u.valToPos(t, 'x', true);
      if (x >= u.bbox.left) u.ctx.fillRect(x, u.bbox.top, 1, u.bbox.height);
    }
    if (this.place === undefined) return;
    const x = u.valToPos(this.place, 'x', true);
    u.ctx.fillStyle = css('--text');
    u.ctx.fillRect(x, u.bbox.top, 1, u.bbox.height);
  }

  add(t, values) {
    const [times, ...lines] = this.data;
    if (times.length > 0 && t <= times[times.length - 1]) return;
    times.push(t);
    lines.forEach((line, i) => line.push(values[i] === undefined ? null : values[i]));
    while (times.length > 0 && times[0] < t - kWindow_s) {
      for (const list of this.data) list.shift();
      while (this.marks[0] < times[0]) this.marks.shift();
    }
    this.say(values);
    this.changed = true;
  }

  say(values) {
    this.values.forEach((output, i) => {
      const v = values[i];
      output.textContent = v === null || v === undefined || Number.isNaN(v) ? '–'
          : Math.abs(v) >= 100 ? v.toFixed(0) : v.toPrecision(3);
    });
  }

  clear() {
    for (const list of this.data) list.length = 0;
    this.place = undefined;
    this.marks = [];
    this.changed = true;
  }

  draw() {
    if (!this.changed) return;
    this.changed = false;
    this.plot.setData(this.data);
  }
}

export class Plots {
  constructor(parent) {
    this.parent = parent;
    this.plots = Object.fromEntries(kPlots.map((spec) => [spec.title, new Plot(parent, spec)]));
    setInterval(() => this.draw(), kDraw_ms);
    new ResizeObserver(() => this.resize()).observe(parent);
  }
  each(f) { Object.values(this.plots).forEach(f); }
  add(title, t, values) { this.plots[title].add(t, values); }
  mark(t) { this.each((plot) => plot.marks.push(t)); }
  clear() { this.each((plot) => plot.clear()); }
  draw() { if (!document.hidden) this.each((plot) => plot.draw()); }
  recolour() { this.each((plot) => plot.make()); }
  resize() {
    this.each((plot) => {
      const width = plot.holder.clientWidth;
      if (width > 0 && width !== plot.plot.width) plot.plot.setSize({width, height: plot.height});
    });
  }
  // All of a run at once; only its plots are shown.
  setRun(data) {
    this.each((plot) => { plot.element.hidden = !(plot.spec.title in data); });
    for (const [title, columns] of Object.entries(data)) {
      this.plots[title].data = columns;
      this.plots[title].changed = true;
    }
  }
  showAll() { this.each((plot) => { plot.element.hidden = false; }); }
  setPlace(t, values) {
    for (const [title, shown] of Object.entries(values)) {
      const plot = this.plots[title];
      plot.place = t;
      plot.say(shown);
      plot.plot.redraw(false);
    }
  }
}
