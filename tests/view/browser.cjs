// Looks at `pirvs view` with a browser, clicks, and writes what came of it as JSON on its last line:
//   node browser.cjs PROGRAM replay|device|run|pictures SOURCE FOLDER
// FOLDER: of maps. pictures: SOURCE starts in FOLDER/monday.map, FOLDER/run is a finished run of it,
// and PNGs are left in FOLDER. NODE_PATH: playwright-core.
const {spawn} = require('child_process');
const dgram = require('dgram');
const fs = require('fs');
const http = require('http');
const path = require('path');
const {chromium} = require('playwright-core');
const {Device} = require('./device.cjs');

const [program, what, source, folder] = process.argv.slice(2);
const kBrowser = process.env.PIRVS_CHROMIUM || '/usr/bin/chromium';
const kPatience_ms = 30000;  // others use this machine, too
const sleep = (ms) => new Promise((done) => setTimeout(done, ms));
const out = {errors: []};

// ---- the program --------------------------------------------------------------------------------

// Serves when it says where.
function start(args) {
  const child = spawn(program, ['view', ...args], {stdio: ['ignore', 'ignore', 'pipe']});
  child.said = '';
  const ready = new Promise((done, failed) => {
    child.stderr.on('data', (text) => {
      child.said += text;
      const found = child.said.match(/pirvs: view: (http:\S+)/);
      if (found) done(found[1]);
    });
    child.on('exit', (code) => failed(new Error(`ended with ${code}: ${child.said}`)));
  });
  children.push(child);
  return ready.then((address) => ({child, address}));
}
const children = [];

function ended(child) {
  return child.exitCode !== null || child.signalCode !== null ? Promise.resolve()
    : new Promise((done) => child.on('exit', done));
}

// ---- the page -----------------------------------------------------------------------------------

async function until(page, what, condition, argument, timeout = kPatience_ms) {
  try {
    await page.waitForFunction(condition, argument, {timeout, polling: 50});
  } catch (error) {
    throw new Error(`${what}: ${error.message.split('\n')[0]}`);
  }
}

const statistics = (list) => {
  const sorted = [...list].sort((a, b) => a - b);
  const at = (q) => sorted[Math.floor(q * (sorted.length - 1))];
  return {median: at(0.5), p99: at(0.99), max: at(1), count: sorted.length};
};

// The answer that the page shows for a line of a command.
async function answer(page, line) {
  await until(page, `answer to ${line}`, (begin) => {
    const newest = document.querySelector('.answer');
    return newest && newest.textContent.startsWith(begin + ' → ');
  }, line);
  return page.evaluate(() => document.querySelector('.answer').textContent.split(' → ')[1]);
}

async function measure(page, seconds) {
  await page.evaluate(() => { pirvsView.stats.lag_ms.length = 0; });
  const begin = await page.evaluate(() => [pirvsView.stats.drawn, performance.now(),
                                           pirvsView.images.shown, pirvsView.stats.states]);
  await sleep(1000 * seconds);
  const end = await page.evaluate(() => [pirvsView.stats.drawn, performance.now(),
                                         pirvsView.images.shown, pirvsView.stats.states]);
  const passed_s = (end[1] - begin[1]) / 1000;
  return {
    drawn_hz: (end[0] - begin[0]) / passed_s, images_hz: (end[2] - begin[2]) / passed_s,
    states_hz: (end[3] - begin[3]) / passed_s,
    lag_ms: statistics(await page.evaluate(() => pirvsView.stats.lag_ms)),
    ratio: await page.evaluate(() => pirvsView.view.ratio),
  };
}

// What the browser draws at best on this machine now: a page that only turns from black to white.
function emptyPage(page) {
  return page.evaluate(() => new Promise((done) => {
    const begin = performance.now();
    let drawn = 0;
    const draw = (now) => {
      document.body.style.background = ++drawn % 2 ? '#000' : '#fff';
      if (now < begin + 1500) requestAnimationFrame(draw);
      else done(drawn * 1000 / (now - begin));
    };
    requestAnimationFrame(draw);
  }));
}

// ---- a replay -----------------------------------------------------------------------------------

async function layersAndViews(page) {
  for (const layer of ['path', 'points', 'keyframes', 'gnss', 'earlier', 'grid']) {
    const shown = () => page.evaluate((name) => pirvsView.view.layers[name][0].parent.visible,
                                      layer);
    const before = await shown();
    await page.click('#layer-' + layer);
    const hidden = before && !await shown();
    await page.click('#layer-' + layer);
    out.layers = (out.layers || 0) + (hidden && await shown() ? 1 : 0);
  }
  await page.click('#top');
  out.top = await page.evaluate(() => {
    const d = pirvsView.view.camera.position.clone().sub(pirvsView.view.controls.target);
    return d.z / d.length();
  });
  await page.click('#fit');
  out.follows_after_fit = await page.evaluate(() => pirvsView.view.follow);
  await page.click('#follow');
  await page.keyboard.press('f');
  await page.keyboard.press('f');
  out.follows = await page.evaluate(() => pirvsView.view.follow);
  const theme = () => page.evaluate(() => document.documentElement.dataset.theme);
  const before = await theme();
  await page.click('#theme');
  out.theme_changes = before !== await theme();
  await page.keyboard.press('d');
  await page.keyboard.press('?');
  out.help_opens = await page.isVisible('#help table');
  await page.keyboard.press('Escape');
  out.help_closes = !await page.isVisible('#help table');
}

// The second click has to come within 3 s, which a machine under load may miss.
async function sure(page, button) {
  for (let attempt = 0; ; ++attempt) {
    await page.click(button);
    try {
      return await page.click(button + '.sure', {timeout: 3000});
    } catch (error) {
      if (attempt === 3) throw error;
    }
  }
}

async function commands(page) {
  await page.keyboard.press('m');
  out.answers = {};
  const fill = async (name, value) => page.locator(`#commands [name=${name}]`).first().fill(value);
  await fill('x', '10');
  await fill('y', '-5');
  await fill('z', '2');
  await fill('yaw', '90');
  await page.click('#command-pose');
  out.answers.pose = await answer(page, 'pose 10 -5 2 90');
  await until(page, 'the pose that was set',
              () => Math.hypot(pirvsView.state.p[0] - 10, pirvsView.state.p[1] + 5) < 3);
  await fill('parameter', 'health.lost_s');
  await fill('value', '2');
  await page.click('#command-parameter');
  out.answers.parameter = await answer(page, 'parameter health.lost_s 2');
  await fill('parameter', 'no.such');
  await page.click('#command-parameter');
  out.answers.wrong = await answer(page, 'parameter no.such 2');
  await fill('name', 'seen.bin');
  await page.click('#command-map-save');
  out.answers.save = await answer(page, 'map save seen.bin');
  for (const word of ['set', 'get', 'remove']) {
    await page.click('#command-node-' + word);
    out.answers['node ' + word] = await answer(page, `node ${word} dock`);
  }
  await sure(page, '#command-map-load');
  out.answers.load = await answer(page, 'map load seen.bin');
  await until(page, 'points of the loaded map', () => pirvsView.view.earlierData.count > 50);
  await until(page, 'a place of the loaded map', () => pirvsView.state.in_map
      && document.getElementById('map').textContent === 'localised in map');
  await sure(page, '#command-reset');
  out.answers.reset = await answer(page, 'reset');
  await page.keyboard.press('e');
  await until(page, 'the event of the reset',
              () => document.getElementById('events').textContent.includes('reset by command'));
  await until(page, 'the map that was forgotten', () => document.getElementById('map').hidden);
  await page.keyboard.press('n');
  await until(page, 'counters', () => document.querySelectorAll('#counter-table tr').length > 5);
  await page.fill('#filter', 'keyframes');
  await until(page, 'filtered counters',
              () => [...document.querySelectorAll('#counter-table tr')].every(
                  (row) => row.textContent.includes('keyframes')));
  await page.click('[data-tab=system]');
  await until(page, 'load', () => /\d+ %/.test(document.getElementById('system').textContent));
}

// What a page of another site would get from this machine.
function foreign(address, origin, host) {
  return new Promise((done) => {
    const url = new URL(address);
    const request = http.request({
      host: url.hostname, port: url.port, headers: {
        Host: host || url.host, Origin: origin, Connection: 'Upgrade', Upgrade: 'websocket',
        'Sec-WebSocket-Key': 'dGhlIHNhbXBsZSBub25jZQ==', 'Sec-WebSocket-Version': '13',
        'Sec-WebSocket-Protocol': 'pirvs-view'},
    });
    request.on('upgrade', (_, socket) => { socket.destroy(); done('taken'); });
    request.on('response', (response) => done(String(response.statusCode)));
    request.on('error', () => done('refused'));
    request.end();
  });
}

// Begun twice, since a recording ends: a program that is killed after its commands, and the one that
// comes in its place, which is looked at. Each click waits for the next pictures.
async function replay(page) {
  const first = await start([source, '--port', '0', '--files', folder]);
  out.empty_hz = await emptyPage(page);
  await page.goto(first.address);
  await until(page, 'a pose', () => pirvsView.state !== null);
  await commands(page);
  const address = new URL(first.address);
  const second = await reconnect(page, first.child, address.port);
  await sleep(3000);  // until the page has found its size
  out.measured = await measure(page, 4);
  await lookAtAll(page);
  out.foreign = await foreign(first.address, 'http://evil.example');
  out.rebound = await foreign(first.address, 'http://evil.example', 'evil.example');
  out.own = await foreign(first.address, address.origin);
  await page.keyboard.press('m');
  await sure(page, '#command-stop');
  await until(page, 'the end', () => pirvsView.source.state === 'ended');
  second.kill('SIGTERM');
  await ended(second);
  out.exit_status = second.exitCode;
}

async function lookAtAll(page) {
  out.map = await page.evaluate(() => ({
    points: pirvsView.view.pointAt.size, path: pirvsView.view.pathRows.length,
    keyframes: pirvsView.view.keyframeData.count / 16, health: pirvsView.state.health,
    source: document.getElementById('source').textContent}));
  await layersAndViews(page);
  await page.click('#follow');
  await page.click('#forget');
  await until(page, 'a cleared path', () => pirvsView.view.pathRows.length < 50);
}

// The program is killed, and comes back.
async function reconnect(page, child, port) {
  child.kill('SIGKILL');
  await ended(child);
  await until(page, 'a lost connection', () => !pirvsView.connected
      && document.getElementById('link').textContent === 'reconnecting');
  const before = await page.evaluate(() => [pirvsView.stats.states, pirvsView.images.shown]);
  const begin = Date.now();
  const again = await start([source, '--port', port, '--files', folder]);
  await until(page, 'new poses and images', ([states, images]) => pirvsView.connected
      && pirvsView.stats.states > states && pirvsView.images.shown > images, before);
  out.reconnect_ms = Date.now() - begin;
  return again.child;
}

// ---- a device -----------------------------------------------------------------------------------

function freePort() {
  return new Promise((done) => {
    const socket = dgram.createSocket('udp4');
    socket.bind(0, '127.0.0.1', () => {
      const {port} = socket.address();
      socket.close(() => done(port));
    });
  });
}

function startSerial() {
  const child = spawn('/usr/bin/python3', [path.join(__dirname, 'serial_device.py')],
                      {stdio: ['pipe', 'pipe', 'inherit']});
  children.push(child);
  return new Promise((done) => {
    child.stdout.once('data', (text) => done({child, tty: String(text).trim()}));
  });
}

async function device(page) {
  const port = await freePort();
  let far = new Device(port);
  const serial = await startSerial();
  const {address} = await start(
      [`udp:127.0.0.1:${port}`, '--serial', serial.tty, '--port', '0']);
  out.empty_hz = await emptyPage(page);
  await page.goto(address);
  await until(page, 'a pose', () => pirvsView.state !== null);
  await until(page, 'points', () => pirvsView.view.pointAt.size === 3);
  await sleep(1500);
  out.measured = await measure(page, 2);
  out.radius = await page.evaluate(() => Math.hypot(pirvsView.state.p[0], pirvsView.state.p[1]));
  out.confidence = await page.evaluate(() => pirvsView.state.confidence);
  out.in_map = await page.textContent('#map');
  out.load = await page.textContent('#load');
  await until(page, 'a jump', () => document.getElementById('events').textContent.includes(
      'the pose jumped by 0.250 m: reset 1'));
  await page.keyboard.press('m');
  await page.click('#command-record-start');
  out.answers = {record: await answer(page, 'record start')};
  await sure(page, '#command-reset');
  out.answers.reset = await answer(page, 'reset');
  serial.child.stdin.end();
  await ended(serial.child);
  await page.click('#command-record-stop');
  out.answers.gone = await answer(page, 'record stop');
  far.close();
  await until(page, 'a device that went', () => pirvsView.source.state === 'waiting');
  far = new Device(port);
  await until(page, 'a device that came', () => pirvsView.source.state === 'connected');
  const states = await page.evaluate(() => pirvsView.stats.states);
  await until(page, 'new poses', (before) => pirvsView.stats.states > before + 20, states);
  out.came_back = true;
  far.close();
}

// ---- a finished run -----------------------------------------------------------------------------

async function run(page) {
  const {address} = await start([source, '--port', '0', '--earlier-map', source + '/map.ply']);
  await page.goto(address);
  await lookAtRun(page, out);
  const saved = source + '/saved.html';
  const saver = spawn(program, ['view', source, '--save', saved], {stdio: 'inherit'});
  await ended(saver);
  out.saver_status = saver.exitCode;
  for (const name of ['saved', 'report']) {
    await page.goto('file://' + path.resolve(`${source}/${name}.html`));
    const element = name === 'report' && await page.$('#viewer');
    const shown = element ? await element.contentFrame() : page;
    out[name] = {};
    await lookAtRun(shown, out[name]);
  }
  out.cursors = await page.$$eval('line.cursor', (lines) => lines.filter(
      (line) => line.style.display !== 'none' && line.hasAttribute('x1')).length);
}

// A page or a frame of one.
async function lookAtRun(page, out) {
  await until(page, 'the run', () => pirvsView.player.count > 0 && pirvsView.state !== null);
  await until(page, 'the map', () => pirvsView.view.pointAt.size > 0);
  out.earlier = await page.evaluate(() => pirvsView.view.earlierData.count);
  out.rows = await page.evaluate(() => pirvsView.player.count);
  const p = () => page.evaluate(() => pirvsView.state.p.join());
  const last = await p();
  await page.focus('#slider');
  await page.evaluate(() => {
    const slider = document.getElementById('slider');
    slider.value = Math.floor(slider.max / 2);
    slider.dispatchEvent(new Event('input'));
  });
  await sleep(300);
  const middle = await p();
  out.slider_moves = last !== middle;
  await page.press('#slider', 'ArrowRight');
  out.key_moves = middle !== await p();
  await page.click('#play');
  await until(page, 'a run that plays', (rows) => pirvsView.player.index > rows / 2 + 5, out.rows);
  await page.click('#play');
  out.plays = true;
}

// ---- pictures of the docs -----------------------------------------------------------------------

// As a screen of many pixels draws it; WebP, for a small file.
async function take(page, name) {
  await page.evaluate(() => {
    pirvsView.view.ratioMax = 2;
    pirvsView.view.setRatio(2);
  });
  await page.evaluate(() => new Promise(requestAnimationFrame));
  const png = await page.screenshot();
  const webp = await page.evaluate(async (base64) => {
    const bytes = Uint8Array.from(atob(base64), (letter) => letter.charCodeAt(0));
    const bitmap = await createImageBitmap(new Blob([bytes], {type: 'image/png'}));
    const canvas = new OffscreenCanvas(bitmap.width, bitmap.height);
    canvas.getContext('2d').drawImage(bitmap, 0, 0);
    const blob = await canvas.convertToBlob({type: 'image/webp', quality: 0.8});
    const url = await new Promise((done) => {
      const reader = new FileReader();
      reader.onload = () => done(reader.result);
      reader.readAsDataURL(blob);
    });
    return url.split(',')[1];
  }, png.toString('base64'));
  fs.writeFileSync(`${folder}/${name}.webp`, Buffer.from(webp, 'base64'));
}

async function pictures(page) {
  const live = await start([source, '--load-map', `${folder}/monday.map`, '--port', '0']);
  await page.goto(live.address);
  await until(page, 'a pose in the map', () => pirvsView.state && pirvsView.state.in_map);
  await until(page, 'some path', () => pirvsView.view.pathRows.length > 600);
  await page.click('#fit');
  await take(page, 'view-dark');
  await page.click('#theme');
  await page.keyboard.press('m');
  await page.click('#follow');
  await take(page, 'view-light');
  live.child.kill('SIGKILL');
  await ended(live.child);
  const finished = await start([`${folder}/run`, '--port', '0']);
  await page.goto(finished.address);
  await until(page, 'the run', () => pirvsView.player.count > 0 && pirvsView.state !== null);
  await page.click('#theme');
  await page.focus('#slider');
  for (let i = 0; i < 3; ++i) await page.keyboard.press('Shift+ArrowLeft');
  await sleep(500);
  await take(page, 'view-run');
}

async function main() {
  const browser = await chromium.launch({
    executablePath: kBrowser,
    // WebGL by the processor, and by it alone: the page itself drawn by way of GL is 8 times slower.
    args: ['--no-sandbox', '--enable-unsafe-swiftshader']});
  try {
    const page = await browser.newPage({viewport: {width: 1280, height: 760}, colorScheme: 'dark'});
    page.setDefaultTimeout(kPatience_ms);
    page.on('pageerror', (error) => out.errors.push(String(error)));
    page.on('console', (message) => {
      if (message.type() === 'error' && !/WebSocket connection/.test(message.text())) {
        out.errors.push(message.text());
      }
    });
    await {replay, device, run, pictures}[what](page);
  } finally {
    await browser.close();
    for (const child of children) child.kill('SIGKILL');
  }
}

main().catch((error) => out.errors.push(String(error.message || error))).then(() => {
  console.log(JSON.stringify(out));
  process.exit(0);
});
