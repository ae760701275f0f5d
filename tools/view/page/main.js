// The page: what comes by the link goes to the scene, the plots, the images and the panels.
import {Commands} from './commands.js';
import {Images} from './images.js';
import {Link, Recorded} from './link.js';
import {Player} from './player.js';
import {Plots} from './plots.js';
import {View3d} from './scene.js';
import {reasonWords} from './words.js';

const $ = (id) => document.getElementById(id);
const root = document.documentElement;

const kSample_ms = 100;     // of what plots show
const kQuiet_ms = 1000;     // without a state: the pose is old
const kEventsKept = 500;
const kSlow_ms = 30, kFast_ms = 17.5;  // from picture to picture
const kGood = {tracking: 'good', degraded: 'warn', lost: 'bad', initializing: 'wait'};
const kLayers = [['path', 'Path', '--good'], ['points', 'Points', '--point'],
                 ['keyframes', 'Keyframes', '--accent'], ['gnss', 'GNSS', '--s2'],
                 ['earlier', 'Loaded map', '--earlier'], ['grid', 'Grid', '--line']];
const kKeys = [
  ['F', 'follow the body'], ['T', 'from above'], ['H', 'fit all'], ['C', 'clear path and points'],
  ['1 … 6', 'layers'], ['E, N, M, S', 'events, counters, commands, system'], ['D', 'dark or light'],
  ['Space', 'a run: play, pause'], ['← →', 'a run: a frame; with shift, 100'], ['?', 'this list'],
  ['mouse, touch', 'one: turn; two, right: move; wheel, pinch: nearer'],
];

// ---- theme --------------------------------------------------------------------------------------

const dark = matchMedia('(prefers-color-scheme: dark)');
// A part of another page (report.html), which says whether it is dark, and is told the time shown.
const embedded = window.parent !== window;
if (embedded) root.dataset.embedded = '';
let ofParent = null;
function setTheme() {
  const chosen = embedded ? ofParent : localStorage.getItem('theme');
  root.dataset.theme = chosen || (dark.matches ? 'dark' : 'light');
}
setTheme();

const view = new View3d($('canvas'));
const plots = new Plots($('plots'));
const images = new Images($('left'), $('right'), $('legend'));

function recolour() {
  setTheme();
  view.recolour();
  plots.recolour();
  images.recolour();
}
dark.addEventListener('change', recolour);
addEventListener('message', (event) => {
  if (!embedded || event.source !== window.parent || !event.data.pirvsTheme) return;
  ofParent = event.data.pirvsTheme;
  recolour();
});
function switchTheme() {
  localStorage.setItem('theme', root.dataset.theme === 'dark' ? 'light' : 'dark');
  recolour();
}

// ---- what is known ------------------------------------------------------------------------------

let state = null, stateNew = false, stateAt_ms = 0, frame = null, page = {};
let connected = false, source = {state: 'waiting', what: ''}, sampled_ms = 0;
let fused = null, rates = null, system = null;
let mapLoaded = false;  // by the source
let begin_t = null;  // of the source's time: stamps may count from anywhere
const stats = {drawn: 0, lag_ms: [], frame_ms: [], states: 0};

function rows(array, width) {
  const numbers = new Float32Array(array), out = [];
  for (let i = 0; i + width <= numbers.length; i += width) out.push(numbers.subarray(i, i + width));
  return out;
}

const player = new Player($('player'), (shown, index) => {
  state = shown;
  stateNew = true;
  const c = player.columns, at = (name) => c[name][index];
  if (embedded) window.parent.postMessage({pirvsTime: at('t')}, '*');
  plots.setPlace(player.time(index), {
    Confidence: [at('confidence')],
    Sigma: [100 * at('sigma_p'), at('sigma_theta') * 180 / Math.PI],
    Frame: [at('ms'), at('accepted')],
  });
});

function show(id, text) {
  const element = $(id);
  if (element.textContent !== text) element.textContent = text;
}

function setPill(id, text, kind) {
  show(id, text);
  $(id).className = 'pill ' + kind;
}

function showLink() {
  if (!connected) return setPill('link', 'reconnecting', 'bad');
  const kind = {connected: 'good', waiting: 'warn', ended: 'wait'}[source.state] || 'wait';
  setPill('link', source.state === 'connected' ? 'live' : source.state, kind);
  $('link').title = source.what;
}

function notice() {
  let text = '';
  if (!connected) text = 'The viewer does not answer. Trying again …';
  else if (source.state === 'waiting') text = source.what || 'Waiting for the source …';
  else if (!state && source.state !== 'ended') text = 'No pose yet.';
  $('notice').hidden = text === '';
  show('notice', text);
}

// ---- messages -----------------------------------------------------------------------------------

const handlers = {
  hello(message) {
    state = frame = begin_t = fused = rates = system = deviceCpu = cpuBefore = null;
    mapLoaded = false;
    const {kind, name, cameras = [], commands: known = []} = message.source;
    show('source', `${kind || ''} ${name || ''}`.trim());
    $('source').title = name || '';
    document.title = `${(name || '').split('/').filter(Boolean).pop() || ''} · PIRVS view`;
    view.reset();
    view.setCameras(cameras);
    plots.clear();
    plots.showAll();
    images.setCameras(cameras.length || 1);
    $('cameras').hidden = kind === 'run';
    $('player').hidden = true;
    $('events').replaceChildren();
    commands.setKnown(known);
    notice();
  },
  source(message) {
    source = message;
    showLink();
    notice();
  },
  state(message) {
    const first = state === null;
    state = message;
    stateNew = true;
    stateAt_ms = performance.now();
    stats.states++;
    if (begin_t === null) begin_t = message.t;
    if (first) notice();
  },
  frame(message) { frame = message; },
  path(message, array) { view.addPath(rows(array, 5), message.all); },
  keyframes(message, array) { view.addKeyframes(rows(array, 7), message.all); },
  points(message, array) {
    const numbers = rows(array, 6), whole = new Uint32Array(array), ids = [], olds = [];
    numbers.forEach((_, i) => { ids.push(whole[6 * i]); olds.push(whole[6 * i + 5]); });
    view.addPoints(ids, numbers.map((row) => row.subarray(1, 4)), olds);
  },
  earlier_map(message, array) {
    view.setEarlier(rows(array, 3));
    mapLoaded = message.loaded && message.count > 0;
    showMap();
  },
  fused(message, array) {
    view.addFused(rows(array, 4), message.all, message.T_WE);
    fused = message;
  },
  fixes(message, array) { view.addFixes(rows(array, 4), message.all); },
  jump() {
    view.jump();
    plots.mark(clock());
  },
  forget() { view.forget(); },
  image(message, array) { images.show(message, array); },
  event(message) { addEvent(message); },
  counters(message) {
    noteCpu(message.values['system.cpu_ms']);
    showCounters(message.values);
  },
  rates(message) {
    const told = (values) => (values ? values.median : null);
    plots.add('Rates', clock(), [message.poses_hz, message.frames_hz]);
    plots.add('Latency', clock(), [told(message.imu_to_pose_ms), told(message.frame_to_pose_ms),
                                   median(stats.lag_ms.slice(-60))]);
    rates = message;
  },
  page(message) { page = message; showSystem(); },
  system(message) {
    system = message;
    showLoad();
  },
  run(message, array) {
    plots.clear();
    player.setRun(message, array);
    const c = player.columns, times = Array.from(c.t, (t) => t - c.t[0]);
    const scaled = (name, by = 1) => Array.from(c[name], (v) => (Number.isNaN(v) ? null : v * by));
    const data = {
      Confidence: [times, scaled('confidence')],
      Sigma: [times, scaled('sigma_p', 100), scaled('sigma_theta', 180 / Math.PI)],
      Frame: [times, scaled('ms'), scaled('accepted')],
    };
    plots.setRun(data);
    begin_t = c.t[0];
    player.index = -1;
    player.go();
    const path = [];
    for (let i = 0; i < player.count; ++i) {
      const confidence = Number.isNaN(c.confidence[i]) ? 1 : c.confidence[i];
      path.push([c.px[i], c.py[i], c.pz[i], confidence, c.resets[i] || 0]);
    }
    view.addPath(path, true);
    view.fit();
    notice();
  },
};

function onLink(on) {
  connected = on;
  showLink();
  notice();
}
const link = window.pirvsRecorded ? new Recorded(handlers, onLink, window.pirvsRecorded)
  : new Link(handlers, onLink);
const commands = new Commands($('commands'), link);

// Seconds on this page, for what has no stamp of the source.
function clock() { return performance.now() / 1000; }
function mean(list) { return list.length ? list.reduce((a, b) => a + b, 0) / list.length : null; }
function median(list) { return list.length ? [...list].sort((a, b) => a - b)[list.length >> 1] : null; }

// ---- panels -------------------------------------------------------------------------------------

function addEvent(message) {
  const list = $('events');
  const line = document.createElement('div');
  const time = document.createElement('time');
  if (begin_t === null) begin_t = message.t;
  time.textContent = (message.t - begin_t).toFixed(2);
  time.title = `${message.t} s`;
  const health = document.createElement('b');
  health.textContent = message.health;
  health.className = kGood[message.health] || '';
  line.append(time, health, message.what);
  list.prepend(line);
  while (list.children.length > kEventsKept) list.lastChild.remove();
}

let countersBefore = {}, cpuBefore = null, deviceCpu = null;
// Of the last seconds; counters come once in each.
function noteCpu(used_ms) {
  if (used_ms === undefined) return;
  const now = performance.now();
  if (cpuBefore && used_ms < cpuBefore[1]) cpuBefore = null;
  if (cpuBefore && now - cpuBefore[0] > 900) {
    deviceCpu = (used_ms - cpuBefore[1]) / (now - cpuBefore[0]);
    cpuBefore = null;
  }
  cpuBefore = cpuBefore || [now, used_ms];
}

function showCounters(values) {
  countersBefore = values;
  if ($('counters').hidden) return;
  const wanted = $('filter').value, zeros = $('zeros').checked;
  const body = Object.entries(values).filter(
      ([name, value]) => (zeros || value !== 0) && name.includes(wanted));
  table($('counter-table'), body);
}

function table(element, body) {
  element.replaceChildren(...body.map((cells) => {
    const row = document.createElement('tr');
    for (const cell of cells) {
      const td = document.createElement('td');
      td.textContent = cell;
      row.append(td);
    }
    return row;
  }));
}

const percent = (v) => (v === null || v === undefined ? '–' : (100 * v).toFixed(0) + ' %');

// Of the device, if it tells; else of this program and computer.
function showLoad() {
  const milli = countersBefore['system.temperature_mC'];
  const cpu = deviceCpu === null ? system && system.cpu : deviceCpu;
  const degrees = milli !== undefined ? milli / 1000 : system && system.temperature;
  const parts = [];
  if (typeof cpu === 'number') parts.push(`CPU ${percent(cpu)}`);
  if (typeof degrees === 'number') parts.push(`${degrees.toFixed(0)} °C`);
  $('load').hidden = parts.length === 0;
  $('load').title = deviceCpu === null ? 'of this program; 100 %: a core' : 'of the device; 100 %: a core';
  show('load', parts.join(' · '));
}

function showMap() {
  const inMap = Boolean(state && state.in_map);
  $('map').hidden = !inMap && !mapLoaded;
  setPill('map', inMap ? 'localised in map' : 'not localised yet', inMap ? 'good' : 'warn');
  $('map').title = inMap ? 'the pose stands in the frame of the loaded map'
    : 'the pose stands in a frame of its own until a place of the loaded map is seen';
  view.setEarlierCertain(inMap || !mapLoaded);
}

function showSystem() {
  if ($('system').hidden) return;
  const s = system || {};
  const ms = (v) => (v ? `${v.median.toFixed(2)} / ${v.p99.toFixed(2)} / ${v.max.toFixed(1)} ms`
    : '–');
  const lags = [...stats.lag_ms].sort((a, b) => a - b);
  const at = (q) => lags[Math.floor(q * (lags.length - 1))];
  const milli = countersBefore['system.temperature_mC'];
  table($('system-table'), [
    ['CPU of this program, 100 %: a core', percent(s.cpu)],
    [`CPU of this computer, ${s.cores || '–'} cores`, percent(s.machine)],
    ['CPU of the device, 100 %: a core', percent(deviceCpu)],
    ['temperature of this computer', s.temperature == null ? 'not told'
      : s.temperature.toFixed(0) + ' °C'],
    ['temperature of the device', milli === undefined ? 'not told'
      : (milli / 1000).toFixed(0) + ' °C'],
    ['memory of this program', s.memory_mb == null ? '–' : s.memory_mb.toFixed(0) + ' MB'],
    ['IMU to pose: median / p99 / max', ms(rates && rates.imu_to_pose_ms)],
    ['exposure to pose', ms(rates && rates.frame_to_pose_ms)],
    ['sample to this page: median / p99', lags.length
      ? `${at(0.5).toFixed(0)} / ${at(0.99).toFixed(0)} ms` : '–'],
    ['pages that look', page.pages === undefined ? '–' : page.pages],
    ['messages this page was too slow for', page.dropped === undefined ? '–' : page.dropped],
    ['latitude, longitude, height', fused
      ? `${fused.latitude.toFixed(7)} ${fused.longitude.toFixed(7)} ${fused.height.toFixed(2)} m`
      : '–'],
    ['on the Earth', fused ? `${fused.health}, ± ${fused.sigma.toFixed(2)} m` : '–'],
  ]);
}

// Roll, pitch and yaw of x y z w, degrees.
function euler([x, y, z, w]) {
  const d = 180 / Math.PI;
  return [Math.atan2(2 * (w * x + y * z), 1 - 2 * (x * x + y * y)) * d,
          Math.asin(Math.max(-1, Math.min(1, 2 * (w * y - z * x)))) * d,
          Math.atan2(2 * (w * z + x * y), 1 - 2 * (y * y + z * z)) * d];
}

const readoutCells = [];
function makeReadout() {
  const labels = [['', 'x', 'y', 'z'], ['place m'], ['± mm'], ['speed m/s'], ['roll pitch yaw °'],
                  ['± °'], ['rate °/s'], ['resets, epoch']];
  for (const label of labels) {
    const row = $('readout').insertRow(), cells = [];
    for (let i = 0; i < 4; ++i) {
      const cell = row.insertCell();
      cell.textContent = label[i] || (i === 0 ? '' : '–');
      if (i > 0) cells.push(cell);
    }
    readoutCells.push(cells);
  }
}

function fill(row, values, digits) {
  readoutCells[row].forEach((cell, i) => {
    const v = values && values[i];
    const text = values && i >= values.length ? '' : v === null || v === undefined ? '–'
      : v.toFixed(digits);
    if (cell.textContent !== text) cell.textContent = text;
  });
}

function showState() {
  const d = 180 / Math.PI, scaled = (list, by) => list && list.map((v) => v * by);
  fill(1, state.p, 3);
  fill(2, scaled(state.sigma_p, 1000), 1);
  fill(3, state.v, 3);
  fill(4, euler(state.q), 2);
  fill(5, scaled(state.sigma_theta, d), 3);
  fill(6, scaled(state.w, d), 1);
  fill(7, [state.resets, state.epoch], 0);
  showMap();
  show('time', (state.t - (begin_t === null ? state.t : begin_t)).toFixed(2));
  const confidence = state.confidence;
  show('confidence', confidence === null ? '–' : confidence.toFixed(2));
  const bar = $('confidence-bar');
  bar.style.width = `${100 * (confidence || 0)}%`;
  bar.style.background = confidence >= 0.6 ? 'var(--good)'
    : confidence >= 0.3 ? 'var(--warn)' : 'var(--bad)';
  const reasons = [...state.reasons, ...(state.dead_reckoning ? ['dead reckoning'] : [])];
  if ($('reasons').dataset.text !== reasons.join()) {
    $('reasons').dataset.text = reasons.join();
    $('reasons').replaceChildren(...reasons.map((reason) => {
      const span = document.createElement('span');
      span.className = 'pill warn';
      [span.textContent, span.title] = reasonWords(reason);
      return span;
    }));
  }
}

function showHealth(now) {
  const live = connected && source.state === 'connected' && $('player').hidden;
  const health = state ? state.health : frame ? frame.health : null;
  if (!health) return setPill('health', 'no pose', 'wait');
  const old = live && state && now - stateAt_ms > kQuiet_ms;
  setPill('health', old ? 'no new pose' : health, old ? 'bad' : kGood[health] || 'wait');
}

function sample(now) {
  if (now < sampled_ms + kSample_ms || !state || !$('player').hidden) return;
  sampled_ms = now;
  const norm = (v) => (v ? Math.hypot(...v) : null);
  plots.add('Confidence', clock(), [state.confidence]);
  plots.add('Sigma', clock(), [100 * norm(state.sigma_p), norm(state.sigma_theta) * 180 / Math.PI]);
  if (frame) plots.add('Frame', clock(), [frame.ms.total, frame.accepted]);
}

// ---- pictures -----------------------------------------------------------------------------------

let before_ms = 0, counted_ms = 0, countedDrawn = 0, calm = 0;

function keepFast(now) {
  stats.frame_ms.push(now - before_ms);
  before_ms = now;
  if (stats.frame_ms.length > 120) stats.frame_ms.shift();
  if (++calm < 40) return;
  calm = 0;
  const usual = mean(stats.frame_ms.slice(-40));
  if (usual > kSlow_ms) view.setRatio(view.ratio * 0.8);
  else if (usual < kFast_ms && view.ratio < view.ratioMax) view.setRatio(view.ratio * 1.1);
}

function picture(now) {
  requestAnimationFrame(picture);
  player.tick(now);
  const isNew = stateNew && state;
  if (isNew) {
    stateNew = false;
    view.setPose(state);
    showState();
    sample(now);
  }
  showHealth(now);
  if (view.draw()) {
    stats.drawn++;
    keepFast(now);
  } else {
    before_ms = now;
  }
  const host = link.hostNow();
  if (isNew && state.host_t && host !== null) {
    stats.lag_ms.push(host - 1000 * state.host_t);
    if (stats.lag_ms.length > 600) stats.lag_ms.shift();
  }
  if (now < counted_ms + 500) return;
  show('fps', String(Math.round((stats.drawn - countedDrawn) * 1000 / (now - counted_ms))));
  counted_ms = now;
  countedDrawn = stats.drawn;
  const live = $('player').hidden && connected && source.state === 'connected';
  const lag = live ? median(stats.lag_ms.slice(-20)) : null;
  show('lag', lag === null ? '–' : `${lag.toFixed(0)} ms`);
}

// ---- hands --------------------------------------------------------------------------------------

function setFollow(on) {
  view.setFollow(on);
  $('follow').classList.toggle('on', on);
}

function toggleLayer(index) {
  const button = $('layers').children[index];
  if (button) button.click();
}

function makeLayers() {
  for (const [layer, label, colour] of kLayers) {
    const button = document.createElement('button');
    button.id = 'layer-' + layer;
    button.className = 'on';
    button.textContent = label;
    button.style.setProperty('--c', `var(${colour})`);
    button.onclick = () => view.show(layer, button.classList.toggle('on'));
    $('layers').append(button);
  }
}

function openTab(name) {
  for (const button of document.querySelectorAll('.tabs button')) {
    const on = button.dataset.tab === name;
    button.classList.toggle('on', on);
    $(button.dataset.tab).hidden = !on;
  }
  showCounters(countersBefore);
  showSystem();
}

function toggleHelp() {
  const help = $('help');
  if (help.open) help.close();
  else help.showModal();
}

const keys = {
  f: () => setFollow(!view.follow), t: () => view.lookFromAbove(), h: () => $('fit').click(),
  c: () => link.send({type: 'forget'}), d: switchTheme, '?': toggleHelp,
  e: () => openTab('events'), n: () => openTab('counters'), m: () => openTab('commands'),
  s: () => openTab('system'), ' ': () => player.toggle(),
};

function onKey(event) {
  if (event.target.matches('input:not([type=range]), select, textarea')) return;
  if (event.ctrlKey || event.metaKey || event.altKey) return;
  const arrow = {ArrowLeft: -1, ArrowRight: 1}[event.key];
  if (arrow) player.step(arrow * (event.shiftKey ? 100 : 1));
  else if (event.key >= '1' && event.key <= '6') toggleLayer(+event.key - 1);
  else if (keys[event.key.toLowerCase()]) keys[event.key.toLowerCase()]();
  else return;
  event.preventDefault();
}

function setUp() {
  makeReadout();
  makeLayers();
  $('help').innerHTML = '<h2>Keys</h2><table>' + kKeys.map(
      ([key, what]) => `<tr><td><kbd>${key}</kbd></td><td>${what}</td></tr>`).join('') + '</table>';
  $('help').onclick = toggleHelp;
  $('help-button').onclick = toggleHelp;
  $('theme').onclick = switchTheme;
  $('follow').onclick = () => setFollow(!view.follow);
  $('top').onclick = () => view.lookFromAbove();
  $('fit').onclick = () => {
    setFollow(false);
    view.fit();
  };
  $('forget').onclick = () => link.send({type: 'forget'});
  $('filter').oninput = $('zeros').onchange = () => showCounters(countersBefore);
  for (const button of document.querySelectorAll('.tabs button')) {
    button.onclick = () => openTab(button.dataset.tab);
  }
  document.addEventListener('keydown', onKey);
  requestAnimationFrame(picture);
}
setUp();

// For tests.
window.pirvsView = {
  stats, view, link, images, player,
  get state() { return state; },
  get source() { return source; },
  get connected() { return connected; },
};
