// read_mcap.cjs FILE: what is in an MCAP file, as Foxglove reads it: by its index, each message
// decoded by the definition that the file has of its type.
// Prints "topic TOPIC TYPE COUNT", and of each Odometry and PoseStamped a line as TUM has it.
"use strict";
const fs = require("fs");
const { McapIndexedReader, McapStreamReader } = require("@mcap/core");
const { MessageReader } = require("@foxglove/rosmsg2-serialization");
const { parse } = require("@foxglove/rosmsg");
const zstd = require("@foxglove/wasm-zstd");

function pose_line(message) {
  const { stamp } = message.header;
  const { position: p, orientation: q } = message.pose.pose ?? message.pose;
  const t = `${stamp.sec}.${String(stamp.nanosec ?? stamp.nsec).padStart(9, "0")}`;
  return [t, ...[p.x, p.y, p.z, q.x, q.y, q.z, q.w].map((v) => v.toFixed(9))].join(" ");
}

function text(schema) {
  return new TextDecoder().decode(schema.data);
}

async function main() {
  await zstd.isLoaded;
  const decompressHandlers = {
    zstd: (bytes, size) => zstd.decompress(Buffer.from(bytes), Number(size)),
  };
  const bytes = fs.readFileSync(process.argv[2]);
  const readable = {
    size: async () => BigInt(bytes.length),
    read: async (at, size) => new Uint8Array(bytes.subarray(Number(at), Number(at + size))),
  };
  const reader = await McapIndexedReader.Initialize({ readable, decompressHandlers });
  const readers = new Map();
  const counts = new Map();
  let last = 0n;
  for await (const record of reader.readMessages()) {
    if (record.logTime < last) throw new Error("not in order of time");
    last = record.logTime;
    const channel = reader.channelsById.get(record.channelId);
    const schema = reader.schemasById.get(channel.schemaId);
    if (!readers.has(schema.id)) {
      readers.set(schema.id, new MessageReader(parse(text(schema), { ros2: true })));
    }
    const message = readers.get(schema.id).readMessage(record.data);
    const key = `${channel.topic} ${schema.name}`;
    counts.set(key, (counts.get(key) ?? 0) + 1);
    if (/Odometry|PoseStamped/.test(schema.name)) console.log(pose_line(message));
    if (/PointCloud2/.test(schema.name)) console.log(`points ${message.width}`);
    if (/Image/.test(schema.name) && message.data.length < 100) throw new Error("no image");
  }
  let all = 0;
  for (const count of counts.values()) all += count;
  if (reader.statistics.messageCount !== BigInt(all)) throw new Error("statistics differ");
  const stream = new McapStreamReader({ decompressHandlers, validateCrcs: true });
  stream.append(bytes);
  for (let record; (record = stream.nextRecord()); ) all -= record.type === "Message" ? 1 : 0;
  if (all !== 0) throw new Error("front to end there are others than by the index");
  for (const [key, count] of counts) console.log(`topic ${key} ${count}`);
}

main().catch((error) => {
  console.error(error);
  process.exit(1);
});
