// Usage: node check_mcap.mjs TRIAL.mcap LAYOUTS-FOLDER
import { strict as assert } from "node:assert";
import { readFileSync } from "node:fs";
import { join } from "node:path";
import { McapIndexedReader } from "@mcap/core";
import { parse } from "@foxglove/rosmsg";
import { ros2humble } from "@foxglove/rosmsg-msgs-common";
import { MessageReader } from "@foxglove/rosmsg2-serialization";
import { decompress } from "fzstd";

const [file, layouts] = process.argv.slice(2);
const bytes = readFileSync(file);
const reader = await McapIndexedReader.Initialize({
  readable: { size: async () => BigInt(bytes.length),
              read: async (from, count) => new Uint8Array(bytes.subarray(Number(from), Number(from + count))) },
  decompressHandlers: { zstd: (packed) => decompress(packed) },
});

// --- schemas: field for field those of ROS 2 -----------------------------------------------------
const plain = (type) => type?.replace("/msg/", "/");
const kCore = { "builtin_interfaces/Time": "time", "builtin_interfaces/Duration": "duration" };
const fieldsOf = (definition) => definition.filter((f) => !f.isConstant).map((f) =>
  [kCore[plain(f.type)] ?? plain(f.type), f.name, !!f.isArray, f.arrayLength ?? 0].join(" "));
const own = /^sanso_msgs\//;
const definitions = new Map();
for (const schema of reader.schemasById.values()) {
  assert.equal(schema.encoding, "ros2msg");
  const parsed = parse(new TextDecoder().decode(schema.data), { ros2: true });
  definitions.set(schema.id, parsed);
  for (const part of parsed) {
    const name = plain(part.name ?? schema.name);
    if (own.test(name) || kCore[name]) continue;
    const known = ros2humble[name] ?? ros2humble[name.replace("/", "/msg/")];
    assert.ok(known, `${name} is no message of ROS 2`);
    assert.deepEqual(fieldsOf(part.definitions), fieldsOf(known.definitions), `${schema.name}: ${name}`);
  }
}

// --- messages: every one decodes with its schema -------------------------------------------------
const readers = new Map([...definitions].map(([id, d]) => [id, new MessageReader(d)]));
const counts = new Map(), last = new Map(), kinds = new Map();
let description = "", previous = 0n;
const frames = new Set();
for await (const message of reader.readMessages()) {
  assert.ok(message.logTime >= previous, "in the order of time");
  previous = message.logTime;
  const channel = reader.channelsById.get(message.channelId);
  const value = readers.get(channel.schemaId).readMessage(message.data);
  counts.set(channel.topic, (counts.get(channel.topic) ?? 0) + 1);
  last.set(channel.topic, value);
  kinds.set(channel.topic, reader.schemasById.get(channel.schemaId).name);
  if (channel.topic === "/robot_description") description = value.data;
  if (channel.topic === "/tf") for (const t of value.transforms) {
    frames.add(t.child_frame_id);
    const q = t.transform.rotation, norm = Math.hypot(q.x, q.y, q.z, q.w);
    assert.ok(Math.abs(norm - 1) < 1e-6, `${t.child_frame_id}: a rotation of length ${norm}`);
  }
}
assert.equal(Number(reader.statistics.messageCount), [...counts.values()].reduce((a, b) => a + b, 0));
const ticks = counts.get("/joint_states");
assert.ok(ticks > 100, `${ticks} ticks`);
for (const topic of ["/tf", "/imu", "/reference", "/foot_wrench/right", "/foot_wrench/left", "/tick"])
  assert.ok(counts.get(topic) >= 0.9 * ticks, `${topic}: ${counts.get(topic)} of ${ticks}`);
assert.ok(counts.get("/policy") > 10);
// a viewer can put every link of the description somewhere
for (const [, link] of description.matchAll(/<link name="([^"]+)"/g)) assert.ok(frames.has(link), `no tf of ${link}`);
const weight = 9.81 * [...description.matchAll(/<mass value="([^"]+)"/g)].reduce((sum, m) => sum + Number(m[1]), 0);
const carried = ["right", "left"].reduce((sum, s) => sum + last.get(`/foot_wrench/${s}`).wrench.force.z, 0);
assert.ok(Math.abs(carried / weight - 1) < 0.3, `feet carry ${carried} N of ${weight} N at the end of standing`);

// --- layouts: every curve and topic is there -----------------------------------------------------
function valueAt(path) {
  const [, topic, rest] = /^(\/[\w/]+?)((?:\.|\[).*)?$/.exec(path);
  assert.ok(last.has(topic), `a layout asks for ${topic}`);
  let value = last.get(topic);
  for (const [, name, index] of (rest ?? "").matchAll(/\.(\w+)|\[(\d+)\]/g)) value = value?.[name ?? Number(index)];
  return value;
}
const foxglove = JSON.parse(readFileSync(join(layouts, "foxglove.json"), "utf8"));
const panels = Object.keys(foxglove.configById);
let curves = 0;
for (const config of Object.values(foxglove.configById)) {
  for (const path of config.paths ?? []) {
    assert.equal(typeof valueAt(path.value), "number", `foxglove.json: ${path.value} is no number`);
    ++curves;
  }
  for (const topic of Object.keys(config.topics ?? {})) assert.ok(last.has(topic), `foxglove.json: ${topic}`);
}
const placed = (node) => (typeof node === "string" ? [node] : [...placed(node.first), ...placed(node.second)]);
assert.deepEqual(placed(foxglove.layout).sort(), panels.sort(), "every panel has its place");

// PlotJuggler names a joint's numbers by the joint
function plotJuggler(name) {
  const joint = /^(\/joint_\w+|\/reference)\/(\w+)\/(position|velocity|effort)$/.exec(name);
  if (joint) return last.get(joint[1])[joint[3]][last.get(joint[1]).name.indexOf(joint[2])];
  const topic = [...last.keys()].find((t) => name.startsWith(t + "/"));
  assert.ok(topic, `plotjuggler.xml: ${name}`);
  return valueAt(topic + name.slice(topic.length).replaceAll("/", "."));
}
for (const [, name] of readFileSync(join(layouts, "plotjuggler.xml"), "utf8").matchAll(/<curve[^>]*name="([^"]+)"/g)) {
  assert.equal(typeof plotJuggler(name), "number", `plotjuggler.xml: ${name} is no number`);
  ++curves;
}
assert.ok(curves > 20);
console.log(`${counts.size} topics, ${definitions.size} schemas, ${curves} curves of layouts: as ROS 2 has them`);
