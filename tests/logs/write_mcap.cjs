// write_mcap.cjs ASL_FOLDER DURATION_S COMPRESSION OUT [rig]: an MCAP file as rosbag2 writes it.
// npm @mcap/core writes the file, @foxglove/rosmsg2-serialization the messages. COMPRESSION: none,
// zstd or lz4. With OUT a folder that is there, the file is OUT/clip_0.mcap beside a metadata.yaml.
// rig: the log says its rig itself, by CameraInfo and /tf_static.
"use strict";
const fs = require("fs");
const path = require("path");
const { McapWriter } = require("@mcap/core");
const { MessageWriter } = require("@foxglove/rosmsg2-serialization");
const { parse } = require("@foxglove/rosmsg");

const HEADER = `std_msgs/Header header
`;
const COMMON = `
================================================================================
MSG: std_msgs/Header
builtin_interfaces/Time stamp
string frame_id
================================================================================
MSG: builtin_interfaces/Time
int32 sec
uint32 nanosec
================================================================================
MSG: geometry_msgs/Vector3
float64 x
float64 y
float64 z
================================================================================
MSG: geometry_msgs/Point
float64 x
float64 y
float64 z
================================================================================
MSG: geometry_msgs/Quaternion
float64 x
float64 y
float64 z
float64 w
`;
const TYPES = {
  "sensor_msgs/msg/CompressedImage": HEADER + "string format\nuint8[] data\n" + COMMON,
  "sensor_msgs/msg/Imu":
    HEADER +
    "geometry_msgs/Quaternion orientation\nfloat64[9] orientation_covariance\n" +
    "geometry_msgs/Vector3 angular_velocity\nfloat64[9] angular_velocity_covariance\n" +
    "geometry_msgs/Vector3 linear_acceleration\nfloat64[9] linear_acceleration_covariance\n" +
    COMMON,
  "geometry_msgs/msg/PoseStamped":
    HEADER +
    "geometry_msgs/Pose pose\n" +
    COMMON +
    "=".repeat(80) +
    "\nMSG: geometry_msgs/Pose\ngeometry_msgs/Point position\ngeometry_msgs/Quaternion orientation\n",
};
const RIG_TYPES = {
  "sensor_msgs/msg/CameraInfo":
    HEADER +
    "uint32 height\nuint32 width\nstring distortion_model\nfloat64[] d\nfloat64[9] k\n" +
    "float64[9] r\nfloat64[12] p\nuint32 binning_x\nuint32 binning_y\n" +
    "sensor_msgs/RegionOfInterest roi\n" +
    COMMON +
    "=".repeat(80) +
    "\nMSG: sensor_msgs/RegionOfInterest\nuint32 x_offset\nuint32 y_offset\nuint32 height\n" +
    "uint32 width\nbool do_rectify\n",
  "tf2_msgs/msg/TFMessage":
    "geometry_msgs/TransformStamped[] transforms\n" +
    COMMON +
    "=".repeat(80) +
    "\nMSG: geometry_msgs/TransformStamped\nstd_msgs/Header header\nstring child_frame_id\n" +
    "geometry_msgs/Transform transform\n" +
    "=".repeat(80) +
    "\nMSG: geometry_msgs/Transform\ngeometry_msgs/Vector3 translation\n" +
    "geometry_msgs/Quaternion rotation\n",
};
const RIG_TOPICS = {
  left_info: ["/cam0/camera_info", "sensor_msgs/msg/CameraInfo"],
  right_info: ["/cam1/camera_info", "sensor_msgs/msg/CameraInfo"],
  tf: ["/tf_static", "tf2_msgs/msg/TFMessage"],
};
const TOPICS = {
  left: ["/cam0/image_raw/compressed", "sensor_msgs/msg/CompressedImage"],
  right: ["/cam1/image_raw/compressed", "sensor_msgs/msg/CompressedImage"],
  imu: ["/imu0", "sensor_msgs/msg/Imu"],
  truth: ["/pose", "geometry_msgs/msg/PoseStamped"],
};

function table(file) {
  return fs
    .readFileSync(file, "utf8")
    .split("\n")
    .filter((line) => line.length > 0 && line[0] !== "#")
    .map((line) => line.trim().split(","));
}

function rows(folder, duration) {
  const mav0 = path.join(folder, "mav0");
  const out = [];
  for (const [camera, kind] of [["cam0", "left"], ["cam1", "right"]]) {
    for (const [t, file] of table(path.join(mav0, camera, "data.csv"))) {
      out.push({ t: BigInt(t), kind, file: path.join(mav0, camera, "data", file.trim()) });
    }
  }
  const first = out[0].t;
  for (const [kind, file] of [["imu", "imu0"], ["truth", "state_groundtruth_estimate0"]]) {
    for (const row of table(path.join(mav0, file, "data.csv"))) {
      out.push({ t: BigInt(row[0]), kind, values: row.slice(1).map(Number) });
    }
  }
  const last = first + BigInt(Math.round(duration * 1e9));
  return out.filter((row) => row.t <= last).sort((a, b) => (a.t < b.t ? -1 : a.t > b.t ? 1 : 0));
}

function rig_rows(folder, t) {
  const header = (frame_id) => ({
    stamp: { sec: Number(t / 1000000000n), nanosec: Number(t % 1000000000n) },
    frame_id,
  });
  const out = [];
  const transforms = [];
  for (const [c, side] of [[0, "left"], [1, "right"]]) {
    const text = fs.readFileSync(path.join(folder, `mav0/cam${c}/sensor.yaml`), "utf8");
    const numbers = (key) =>
      new RegExp(key + ":[^\\[]*\\[([^\\]]*)\\]").exec(text)[1].split(",").map(Number);
    const [fx, fy, cx, cy] = numbers("intrinsics");
    const [width, height] = numbers("resolution");
    const info = {
      header: header(side),
      height,
      width,
      distortion_model: "plumb_bob",
      d: [...numbers("distortion_coefficients"), 0],
      k: [fx, 0, cx, 0, fy, cy, 0, 0, 1],
      r: [1, 0, 0, 0, 1, 0, 0, 0, 1],
      p: [fx, 0, cx, 0, 0, fy, cy, 0, 0, 0, 1, 0],
      binning_x: 0,
      binning_y: 0,
      roi: { x_offset: 0, y_offset: 0, height: 0, width: 0, do_rectify: false },
    };
    out.push({ t, kind: side + "_info", content: info });
    const T = numbers("T_BS");
    // Of a turn whose w is not small.
    const w = Math.sqrt(1 + T[0] + T[5] + T[10]) / 2;
    const rotation = {
      x: (T[9] - T[6]) / (4 * w),
      y: (T[2] - T[8]) / (4 * w),
      z: (T[4] - T[1]) / (4 * w),
      w,
    };
    const translation = { x: T[3], y: T[7], z: T[11] };
    transforms.push({
      header: header("imu"),
      child_frame_id: side,
      transform: { translation, rotation },
    });
  }
  return [...out, { t, kind: "tf", content: { transforms } }];
}

function content(row) {
  if (row.content) return row.content;
  const header = {
    stamp: { sec: Number(row.t / 1000000000n), nanosec: Number(row.t % 1000000000n) },
    frame_id: row.kind,
  };
  const xyz = (v) => ({ x: v[0], y: v[1], z: v[2] });
  const v = row.values;
  if (row.kind === "imu") {
    const zeros = new Float64Array(9);
    return {
      header,
      orientation: { x: 0, y: 0, z: 0, w: 1 },
      orientation_covariance: zeros,
      angular_velocity: xyz(v),
      angular_velocity_covariance: zeros,
      linear_acceleration: xyz(v.slice(3)),
      linear_acceleration_covariance: zeros,
    };
  }
  if (row.kind === "truth") {
    const orientation = { w: v[3], x: v[4], y: v[5], z: v[6] };
    return { header, pose: { position: xyz(v), orientation } };
  }
  return { header, format: "jpeg", data: fs.readFileSync(row.file) };
}

async function main() {
  const [folder, duration, compression, target, rig] = process.argv.slice(2);
  const inside = fs.existsSync(target);
  const file = fs.openSync(inside ? path.join(target, "clip_0.mcap") : target, "w");
  let at = 0n;
  const writable = {
    position: () => at,
    write: async (bytes) => {
      fs.writeSync(file, bytes);
      at += BigInt(bytes.length);
    },
  };
  const options = { writable };
  if (compression === "zstd") {
    const { compress } = require("@foxglove/wasm-zstd");
    await require("@foxglove/wasm-zstd").isLoaded;
    options.compressChunk = (data) => ({
      compression: "zstd",
      compressedData: new Uint8Array(compress(Buffer.from(data))),
    });
  }
  const writer = new McapWriter(options);
  await writer.start({ profile: "ros2", library: "test" });
  const channels = {};
  for (const [kind, [topic, type]] of Object.entries({ ...TOPICS, ...(rig ? RIG_TOPICS : {}) })) {
    const definition = { ...TYPES, ...RIG_TYPES }[type];
    const schemaId = await writer.registerSchema({
      name: type,
      encoding: "ros2msg",
      data: new TextEncoder().encode(definition),
    });
    const id = await writer.registerChannel({
      topic,
      schemaId,
      messageEncoding: "cdr",
      metadata: new Map(),
    });
    channels[kind] = { id, write: new MessageWriter(parse(definition, { ros2: true })), n: 0 };
  }
  const all = rows(folder, Number(duration));
  if (rig) all.unshift(...rig_rows(folder, all[0].t));
  for (const row of all) {
    const channel = channels[row.kind];
    await writer.addMessage({
      channelId: channel.id,
      sequence: channel.n++,
      logTime: row.t,
      publishTime: row.t,
      data: channel.write.writeMessage(content(row)),
    });
  }
  await writer.end();
  fs.closeSync(file);
  if (inside) {
    fs.writeFileSync(
      path.join(target, "metadata.yaml"),
      "rosbag2_bagfile_information:\n  version: 5\n  storage_identifier: mcap\n" +
        "  relative_file_paths:\n    - clip_0.mcap\n",
    );
  }
}

main();
