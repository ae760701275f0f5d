// An autopilot that shares no code with us: node-mavlink decodes what the link says.
//   node client.cjs file LOG.tlog TRUTH.json   every field against what went into the link
//   node client.cjs live PORT                  talks with a link until it falls silent
// Out: one JSON object; exit status 1: a check of `file` has failed, with a line each on stderr.
// Needs NODE_PATH: a folder with node-mavlink.
'use strict';
const dgram = require('dgram');
const fs = require('fs');
const { PassThrough } = require('stream');
const { createMavLinkStream, MavLinkProtocolV2, minimal, common } = require('node-mavlink');

const kKinds = { ...minimal.REGISTRY, ...common.REGISTRY };
const kDiagonal = [0, 6, 11, 15, 18, 20];  // of an upper triangle of 6 x 6 by rows

// Calls take(name, message, header) for every frame that is pushed into the answer.
function decoder(take, refuse) {
  const input = new PassThrough();
  createMavLinkStream(input, { onCrcError: refuse }).on('data', (packet) => {
    const kind = kKinds[packet.header.msgid];
    take(kind.MSG_NAME, packet.protocol.data(packet.payload, kind), packet.header);
  });
  return input;
}

function length_in_float(q) {
  let squares = Math.fround(0);
  for (const x of q) squares = Math.fround(squares + Math.fround(x * x));
  return Math.fround(Math.sqrt(squares));
}

// ---- a file ------------------------------------------------------------------------------------

const product = (A, B) => A.map((row) => B[0].map((_, j) =>
  row.reduce((sum, a, k) => sum + a * B[k][j], 0)));
const transposed = (A) => A[0].map((_, j) => A.map((row) => row[j]));
const skew = ([x, y, z]) => [[0, -z, y], [z, 0, -x], [-y, x, 0]];
const kOver = [[1, 0, 0], [0, -1, 0], [0, 0, -1]];

// J C J' for J given as three blocks of columns: theta, p, v. null: zero.
function propagate(blocks, covariance) {
  const zero = blocks.find((b) => b !== null).map(() => [0, 0, 0]);
  const J = blocks.map((b) => b ?? zero);
  const rows = J[0].map((_, i) => [...J[0][i], ...J[1][i], ...J[2][i]]);
  return product(product(rows, covariance), transposed(rows));
}

// What ODOMETRY should hold of a pose: p_WB, R_WB, v_WB, w_B, 9 x 9 covariance of theta, p, v.
function expected(truth) {
  const { R, p, v, w, cov } = truth;
  const column = (x) => x.map((value) => [value]);
  const flat = (A) => A.map((row) => row[0]);
  const v_B = flat(product(transposed(R), column(v)));
  const RB = product(kOver, transposed(R));
  return {
    place: [p[0], -p[1], -p[2]],
    attitude: product(product(kOver, R), kOver),
    speed: [v_B[0], -v_B[1], -v_B[2]],
    rates: [w[0], -w[1], -w[2]],
    cov_place: propagate([null, kOver, null], cov),
    cov_attitude: propagate([product(kOver, R), null, null], cov),
    cov_speed: propagate([product(kOver, skew(v_B)), null, RB], cov),
  };
}

function rotation([w, x, y, z]) {
  return [[1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
    [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
    [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)]];
}

function check_file(log, truth_file) {
  const truth = JSON.parse(fs.readFileSync(truth_file));
  const failures = [];
  const heard = { ODOMETRY: [], HEARTBEAT: [], STATUSTEXT: [] };
  const input = decoder((name, message, header) => {
    (heard[name] ??= []).push(message);
    if (header.compid !== 197 || header.sysid !== 7) failures.push(`from ${header.compid}`);
  }, () => failures.push('a checksum is wrong'));
  const bytes = fs.readFileSync(log);
  for (let at = 0; at < bytes.length;) {
    const size = 12 + bytes[at + 9];  // header and checksum of a frame without signature
    const stamp = bytes.readBigUInt64BE(at);
    if (stamp < BigInt(truth[0].t_us)) failures.push(`stamp ${stamp}`);
    input.write(bytes.subarray(at + 8, at + 8 + size));
    at += 8 + size;
  }
  input.end(() => setTimeout(() => {
    const close = (what, is, wanted, tolerance = 1e-5) => {
      if (!(Math.abs(is - wanted) <= tolerance * Math.max(1, Math.abs(wanted)))) {
        failures.push(`${what}: ${is} instead of ${wanted}`);
      }
    };
    close('poses', heard.ODOMETRY.length, truth.length, 0);
    heard.ODOMETRY.forEach((m, k) => check_pose(m, truth[k], (what, ...rest) =>
      close(`pose ${k}, ${what}`, ...rest)));
    for (const beat of heard.HEARTBEAT) {
      close('type', beat.type, 18, 0);
      close('autopilot', beat.autopilot, 8, 0);
    }
    for (const failure of failures.slice(0, 20)) console.error(failure);
    console.log(JSON.stringify({ odometry: heard.ODOMETRY.length, failures: failures.length,
      heartbeats: heard.HEARTBEAT.length, texts: heard.STATUSTEXT.map((m) => m.text) }));
    process.exit(failures.length > 0 ? 1 : 0);
  }, 50));
}

function check_pose(m, truth, close) {
  const wanted = expected(truth);
  close('time', Number(m.timeUsec), truth.t_us, 0);
  close('frame', m.frameId, truth.frame, 0);
  close('child frame', m.childFrameId, 12, 0);
  close('estimator', m.estimatorType, 3, 0);
  close('quality', m.quality, truth.quality, 0);
  close('reset counter', m.resetCounter, truth.resets % 256, 0);
  close('length of q', length_in_float(m.q), 1, 1e-5);
  ['x', 'y', 'z'].forEach((axis, i) => close(axis, m[axis], wanted.place[i]));
  rotation(m.q).forEach((row, i) => row.forEach((x, j) =>
    close(`R ${i} ${j}`, x, wanted.attitude[i][j])));
  ['rollspeed', 'pitchspeed', 'yawspeed'].forEach((axis, i) => close(axis, m[axis], wanted.rates[i]));
  let at = 0;
  for (let i = 0; i < 6; ++i) {
    for (let j = i; j < 6; ++j, ++at) {
      const is = m.poseCovariance[at];
      if (j < 3) close(`cov ${i} ${j}`, is, wanted.cov_place[i][j]);
      if (i >= 3) close(`cov ${i} ${j}`, is, wanted.cov_attitude[i - 3][j - 3]);
    }
  }
  if (truth.has_velocity) {
    ['vx', 'vy', 'vz'].forEach((axis, i) => close(axis, m[axis], wanted.speed[i]));
    [0, 1, 2, 6, 7, 11].forEach((k, n) => {
      const [i, j] = [[0, 0], [0, 1], [0, 2], [1, 1], [1, 2], [2, 2]][n];
      close(`cov of v ${i} ${j}`, m.velocityCovariance[k], wanted.cov_speed[i][j]);
    });
  } else {
    const not_none = [m.vx, m.vy, m.vz, ...m.velocityCovariance].filter((x) => !Number.isNaN(x));
    close('numbers in a velocity that there is not', not_none.length, 0, 0);
  }
}

// ---- live --------------------------------------------------------------------------------------

const kSilence_ms = 1500, kStart_ms = 60000;
const kPlace = [10, 20, -3], kYaw_deg = 90, kSetPoseAfter_ms = 2500;
const now_ns = () => process.hrtime.bigint();

function live(port) {
  const out = { odometry: 0, gap_ms_max: 0, arrival_gap_ms_max: 0, arrival_gaps_over_100_ms: 0,
    length_error_max: 0, frames: [], qualities: [], resets: [], covariances_bad: 0, trips_ms: [],
    clock_ahead_ms_max: 0, acks: [], heartbeats: 0, states: [], texts: [], checksums_wrong: 0,
    questions: 0, set_pose: null };
  const socket = dgram.createSocket('udp4');
  const protocol = new MavLinkProtocolV2(1, 1);
  let sequence = 0, robot = null, last_ns = 0n, last_usec = 0n, arrived = 0n, silence = null;
  const see = (list, value) => list.includes(value) || list.push(value);
  const send = (message) => socket.send(protocol.serialize(message, sequence++ & 255),
    robot.port, robot.address);
  const finish = () => {
    out.trips_ms.sort((a, b) => a - b);
    const trips = out.trips_ms;
    out.trips_ms = { count: trips.length, median: trips[trips.length >> 1],
      p90: trips[Math.floor(trips.length * 0.9)], max: trips[trips.length - 1] };
    console.log(JSON.stringify(out));
    process.exit(0);
  };
  const ask_for = (command, ...parameters) => {
    const message = new common.CommandLong();
    Object.assign(message, { targetSystem: 1, targetComponent: 197, command, confirmation: 0 });
    for (let i = 0; i < 7; ++i) message[`_param${i + 1}`] = parameters[i] ?? 0;
    send(message);
  };
  const begin = () => {
    setInterval(() => {
      const question = new common.TimeSync();
      Object.assign(question, { tc1: 0n, ts1: now_ns() });
      send(question);
    }, 20);
    let ticks = 0;
    setInterval(() => {
      const beat = new minimal.Heartbeat();
      Object.assign(beat, { type: 2, autopilot: 12, baseMode: 0, customMode: 0, systemStatus: 4,
        mavlinkVersion: 3 });
      if (ticks % 5 === 0) send(beat);
      const fix = new common.GpsRawInt();
      Object.assign(fix, { timeUsec: now_ns() / 1000n, fixType: 3, lat: 473977420, lon: 85455940,
        alt: 488000, eph: 100, epv: 100, vel: 0, cog: 0, satellitesVisible: 12,
        altEllipsoid: 535300, hAcc: 800, vAcc: 1500, velAcc: 100, hdgAcc: 0, yaw: 0 });
      send(fix);
      const wheels = new common.WheelDistance();
      Object.assign(wheels, { timeUsec: now_ns() / 1000n, count: 2,
        distance: Array.from({ length: 16 }, (_, i) => (i < 2 ? 0.1 * ticks : 0)) });
      send(wheels);
      ++ticks;
    }, 200);
    setTimeout(() => ask_for(31011, ...kPlace, kYaw_deg), kSetPoseAfter_ms);
    setTimeout(() => ask_for(400, 1), kSetPoseAfter_ms);
  };
  const take = {
    ODOMETRY(m) {
      if (out.odometry++ === 0) begin();
      else {
        out.gap_ms_max = Math.max(out.gap_ms_max, Number(m.timeUsec - last_usec) / 1e3);
        const gap_ms = Number(arrived - last_ns) / 1e6;
        out.arrival_gap_ms_max = Math.max(out.arrival_gap_ms_max, gap_ms);
        out.arrival_gaps_over_100_ms += gap_ms > 100;
      }
      last_usec = m.timeUsec;
      last_ns = arrived;
      out.length_error_max = Math.max(out.length_error_max, Math.abs(1 - length_in_float(m.q)));
      see(out.frames, `${m.frameId}/${m.childFrameId}/${m.estimatorType}`);
      see(out.qualities, m.quality);
      if (out.resets[out.resets.length - 1] !== m.resetCounter) {
        out.resets.push(m.resetCounter);
        const R = rotation(m.q);
        out.set_pose = { place: [m.x, m.y, m.z], yaw_deg: Math.atan2(R[1][0], R[0][0]) * 180 / Math.PI };
      }
      out.covariances_bad += !kDiagonal.every((k) => m.poseCovariance[k] > 0) ||
        !(Number.isNaN(m.vx) || kDiagonal.every((k) => m.velocityCovariance[k] > 0));
    },
    TIMESYNC(m) {
      if (m.tc1 === 0n) {
        ++out.questions;
        const answer = new common.TimeSync();
        Object.assign(answer, { tc1: now_ns(), ts1: m.ts1 });
        send(answer);
        return;
      }
      out.trips_ms.push(Number(arrived - m.ts1) / 1e6);
      // The clock that stamps the poses: none has been sent before its time.
      out.clock_ahead_ms_max = Math.max(out.clock_ahead_ms_max,
        Number(m.tc1 / 1000n - last_usec) / 1e3);
    },
    COMMAND_ACK(m) { out.acks.push([m.command, m.result]); },
    HEARTBEAT(m) {
      ++out.heartbeats;
      see(out.states, m.systemStatus);
    },
    STATUSTEXT(m) {
      if (m.chunkSeq > 0) out.texts[out.texts.length - 1] += m.text;
      else out.texts.push(m.text);
    },
  };
  const input = decoder((name, message) => take[name]?.(message), () => ++out.checksums_wrong);
  const start = setTimeout(finish, kStart_ms);
  socket.on('message', (bytes, from) => {
    arrived = now_ns();
    robot = from;
    clearTimeout(start);
    clearTimeout(silence);
    silence = setTimeout(finish, kSilence_ms);
    input.write(bytes);
  });
  socket.bind(port, '127.0.0.1', () => console.error(`port ${socket.address().port}`));
}

if (process.argv[2] === 'file') check_file(process.argv[3], process.argv[4]);
else live(Number(process.argv[3]));
