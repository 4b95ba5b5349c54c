// Reads files that mcap_samples wrote with MCAP's official reader, by index and as a stream, whole
// and cut at every byte, and decodes every message by the schema in the file.
// Usage: node check_mcap.mjs FOLDER
import { strict as assert } from "node:assert";
import { readFileSync } from "node:fs";
import { join } from "node:path";
import { McapIndexedReader, McapStreamReader } from "@mcap/core";
import { parse } from "@foxglove/rosmsg";
import common from "@foxglove/rosmsg-msgs-common";
import { MessageReader } from "@foxglove/rosmsg2-serialization";
import { decompress } from "fzstd";

const folder = process.argv[2];
const expected = JSON.parse(readFileSync(join(folder, "expected.json"), "utf8"));
const decompressHandlers = {
  zstd: (buffer, size) => decompress(buffer, new Uint8Array(Number(size))),
};

const readable = (bytes) => ({
  size: async () => BigInt(bytes.length),
  read: async (offset, size) => bytes.subarray(Number(offset), Number(offset + size)),
});

/** Decoded messages in file order, as {topic, time, message}. */
function* stream(bytes, whole) {
  const reader = new McapStreamReader({ decompressHandlers, validateCrcs: true });
  const schemas = new Map(), channels = new Map();
  reader.append(bytes);
  for (let record = reader.nextRecord(); record != undefined; record = reader.nextRecord()) {
    if (record.type === "Schema") schemas.set(record.id, new MessageReader(definition(record)));
    if (record.type === "Channel") channels.set(record.id, record);
    if (record.type !== "Message") continue;
    const channel = channels.get(record.channelId);
    const message = schemas.get(channel.schemaId).readMessage(record.data);
    yield { topic: channel.topic, time: record.logTime, message };
  }
  if (whole) assert.ok(reader.done(), "the stream reader found no end");
}

const definition = (schema) => {
  assert.equal(schema.encoding, "ros2msg");
  return parse(new TextDecoder().decode(schema.data), { ros2: true });
};

/** Each ROS type of the file, parts included, is what ROS 2 says; names of types without /msg/. */
function checkAgainstRos(schema) {
  const short = (name) => name.replace("/msg/", "/");
  let compared = 0;
  for (const part of definition(schema)) {
    const name = short(part.name ?? schema.name);
    const official = common.ros2humble[name];
    if (official == undefined) {
      assert.ok(name.startsWith("sanso_msgs/"), `${name} is no type of ROS 2`);
      continue;
    }
    const fields = (d) => d.definitions.map((f) =>
      [f.name, short(f.type), f.isArray ?? false, f.arrayLength ?? -1].join(" "));
    assert.deepEqual(fields(part), fields(official), name);
    ++compared;
  }
  return compared;
}

async function checkIndexed(name, bytes, topics) {
  const reader = await McapIndexedReader.Initialize({ readable: readable(bytes), decompressHandlers });
  const counts = {};
  let last = 0n;
  for await (const message of reader.readMessages({ validateCrcs: true })) {
    const { topic } = reader.channelsById.get(message.channelId);
    counts[topic] = (counts[topic] ?? 0) + 1;
    assert.ok(message.logTime >= last);
    last = message.logTime;
  }
  assert.deepEqual(counts, topics, `${name} by index`);
  assert.equal(reader.statistics.messageCount, BigInt(Object.values(topics).reduce((a, b) => a + b)));
  let types = 0;
  for (const schema of reader.schemasById.values()) types += checkAgainstRos(schema);
  assert.ok(types >= 3, `${name}: only ${types} types of ROS`);
  return reader;
}

function checkStreamed(name, bytes, topics) {
  const counts = {};
  for (const { topic } of stream(bytes, true)) counts[topic] = (counts[topic] ?? 0) + 1;
  assert.deepEqual(counts, topics, `${name} as a stream`);
}

function checkValues(bytes) {
  const first = {};
  for (const { topic, message } of stream(bytes, true)) first[topic] ??= message;
  const knee = first["/joint_states"].name.indexOf("r_knee");
  assert.equal(first["/joint_states"].position[knee], expected.knee);
  assert.equal(first["/joint_commands"].position[knee], expected.command);
  assert.deepEqual(first["/imu"].linear_acceleration, { x: 0, y: 0.5, z: 9.81 });
  assert.deepEqual(first["/imu"].orientation, { x: 0, y: 0, z: 0.8, w: 0.6 });
  assert.equal(first["/odom"].child_frame_id, "base_link");
  const tick = first["/tick"];
  assert.deepEqual([tick.tick, tick.fault, tick.state, tick.lost], [1n, 30, 7, 2n]);
  assert.equal(tick.u_upper[3], 0.25);
  assert.equal(tick.u_lower[11], -0.125);
  assert.equal(tick.position_raw[11], 2048);
  assert.equal(tick.datagrams_dropped, 5, "the last field");
}

/** The tf of a trial is a tree of the robot's links, and the knee is turned in it. */
function checkTrial(bytes) {
  const first = {};
  for (const { topic, message } of stream(bytes, true)) first[topic] ??= message;
  const { transforms } = first["/tf"];
  const parents = new Map(transforms.map((t) => [t.child_frame_id, t.header.frame_id]));
  assert.equal(parents.size, transforms.length, "a link has two parents");
  for (let link of parents.keys()) {
    for (let steps = 0; link !== "world"; link = parents.get(link), ++steps)
      assert.ok(link != undefined && steps < 20, "a link hangs nowhere");
  }
  const links = new Set([...first["/robot_description"].data.matchAll(/<link name="([^"]+)"/g)].map((m) => m[1]));
  assert.deepEqual(new Set(parents.keys()), links, "tf and URDF name other links");
  const knee = transforms.find((t) => t.child_frame_id === "r_knee_link").transform.rotation;
  assert.ok(Math.abs(knee.w - Math.cos(0.35)) < 1e-12 && Math.abs(knee.y + Math.sin(0.35)) < 1e-12, "r_knee turns about -y");
  assert.equal(first["/foot_wrench/right"].wrench.force.z, 12.5);
  assert.equal(first["/foot_wrench/left"].wrench.force.z, 18);
  const { sequence, late, u, x } = first["/policy"];
  assert.deepEqual([sequence, late, u.length, x.length, u[12 + 3]], [4, 1, 24, 74, 0.25]);
}

let cuts = 0;
for (const [name, topics] of Object.entries(expected.files)) {
  const bytes = new Uint8Array(readFileSync(join(folder, name)));
  await checkIndexed(name, bytes, topics);
  checkStreamed(name, bytes, topics);
}
const box = new Uint8Array(readFileSync(join(folder, "box.mcap")));
checkValues(box);
checkTrial(new Uint8Array(readFileSync(join(folder, "trial.mcap"))));
for (let size = 8; size < box.length; ++size, ++cuts) {
  let rows = 0;
  for (const { topic } of stream(box.subarray(0, size), false)) rows += topic === "/joint_states";
  assert.equal(rows, expected.rows_of_cut[size - 8], `cut at byte ${size}`);
}
console.log(`${Object.keys(expected.files).length} files, ${cuts} cuts: as written`);
