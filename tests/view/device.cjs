// A device's stream as docs/device.md describes it, written after that page and not after the code:
// poses on a circle, 200 a second, to whoever subscribes.
const dgram = require('dgram');

const kHeader = 16, kPose = 1, kCounters = 3, kPoints = 4, kClock = 7, kSubscribe = 32, kAsk = 33;
const kRate_hz = 200, kInMap = 2;

function now() { return process.hrtime.bigint(); }

class Device {
  constructor(port) {
    this.sequence = 0;
    this.to = null;
    this.socket = dgram.createSocket('udp4');
    this.socket.on('message', (bytes, from) => this.take(bytes, from));
    this.socket.bind(port, '127.0.0.1');
    this.ticks = this.cpu_ms = 0;
    this.timer = setInterval(() => this.tick(), 1000 / kRate_hz);
  }

  close() {
    clearInterval(this.timer);
    this.socket.close();
  }

  datagram(kind, size, sequence) {
    const out = Buffer.alloc(kHeader + size);
    out.write('PVS1', 0, 'latin1');
    out.writeUInt8(kind, 4);
    out.writeUInt16LE(0, 6);
    out.writeUInt16LE(1, 8);
    out.writeUInt32LE(sequence, 10);
    out.writeUInt16LE(size, 14);
    return out;
  }

  take(bytes, from) {
    if (bytes.toString('latin1', 0, 4) !== 'PVS1') return;
    const kind = bytes.readUInt8(4);
    if (kind === kSubscribe) this.to = from;
    if (kind !== kAsk) return;
    const answer = this.datagram(kClock, 16, 0);
    answer.writeBigInt64LE(bytes.readBigInt64LE(kHeader), kHeader);
    answer.writeBigInt64LE(now(), kHeader + 8);
    this.send(answer, from);
  }

  send(bytes, to) { this.socket.send(bytes, to.port, to.address); }

  pose() {
    const t = now(), angle = Number(t % 6_283_185_307n) / 1e9;
    const out = this.datagram(kPose, 24 + 24 + 40 + 21 * 4 + 6 * 4 + 4 + 4 + 2 + 2, this.sequence++);
    let at = kHeader;
    for (let i = 0; i < 3; ++i) at = out.writeBigInt64LE(t, at);
    const up = this.ticks < 1200 ? 1 : 1.25;
    for (const p of [Math.cos(angle), Math.sin(angle), up]) at = out.writeDoubleLE(p, at);
    const floats = [0, 0, Math.sin(angle / 2), Math.cos(angle / 2)];
    floats.push(-Math.sin(angle), Math.cos(angle), 0, 0, 0, 1);
    for (let i = 0; i < 6; ++i) for (let j = i; j < 6; ++j) floats.push(i === j ? 1e-4 : 0);
    for (let i = 0; i < 3; ++i) for (let j = i; j < 3; ++j) floats.push(i === j ? 1e-4 : 0);
    floats.push(0.75);
    for (const value of floats) at = out.writeFloatLE(value, at);
    at = out.writeUInt32LE(up > 1 ? 1 : 0, at);  // resets
    at = out.writeUInt16LE(1, at);               // epoch
    at = out.writeUInt8(1, at);                  // tracking
    out.writeUInt8(kInMap, at);
    return out;
  }

  points() {
    const count = 3, out = this.datagram(kPoints, 10 + 20 * count, this.sequence++);
    let at = out.writeBigInt64LE(now(), kHeader);
    at = out.writeUInt16LE(1, at);
    for (let i = 0; i < count; ++i) {
      at = out.writeUInt32LE(100 + i, at);
      for (const value of [i, 2, 1, 0.01]) at = out.writeFloatLE(value, at);
    }
    return out;
  }

  counters() {
    this.cpu_ms += 150;
    const text = Buffer.from(`frames 77\nstarts 1\nsystem.cpu_ms ${this.cpu_ms}\n`
        + 'system.temperature_mC 48500\n');
    const out = this.datagram(kCounters, text.length, this.sequence++);
    text.copy(out, kHeader);
    return out;
  }

  tick() {
    if (this.to === null) return;
    this.send(this.pose(), this.to);
    if (++this.ticks % 100 === 0) {
      this.send(this.points(), this.to);
      this.send(this.counters(), this.to);
    }
  }
}

module.exports = {Device};
