// Watches a daemon with the client library that Lichtblick uses, as a viewer would: subscribes to
// everything, decodes every message by the schema it is announced with, and fails unless what a
// viewer draws is there.
//
//     NODE_PATH=... node watch.js ws://127.0.0.1:8765 [SECONDS] [stay]
//
// With `stay` it looks on for as long as it is told, whatever there is, and says what it saw.
const { FoxgloveClient } = require("@foxglove/ws-protocol");
const WebSocket = require("ws");
const protobuf = require("protobufjs");
const descriptor = require("protobufjs/ext/descriptor");

const [url, seconds = "60", stay] = process.argv.slice(2);

// Where a viewer must see something move: the tracker, the estimate, the sketch as a ghost.
const POSES = [/^\/tracker\/.*\/pose$/, /^\/estimate\/.*\/pose$/, /^\/sketch\/.*\/pose$/];
const FRAMES = [/_live$/, /_estimate$/, /_sketch$/];

const decoders = new Map();
const counts = new Map();
const places = new Map();
const frames = new Set();
let entities = 0;

function decoder(channel) {
  if (channel.encoding === "json") return (data) => JSON.parse(new TextDecoder().decode(data));
  const set = descriptor.FileDescriptorSet.decode(Buffer.from(channel.schema, "base64"));
  const type = protobuf.Root.fromDescriptor(set).lookupType(channel.schemaName);
  return (data) => type.decode(new Uint8Array(data.buffer, data.byteOffset, data.byteLength));
}

function note(topic, message) {
  counts.set(topic, (counts.get(topic) ?? 0) + 1);
  if (POSES.some((pattern) => pattern.test(topic))) {
    const { x, y, z } = message.pose.position;
    if (![x, y, z].every(Number.isFinite)) throw new Error(`${topic}: ${x} ${y} ${z}`);
    if (!places.has(topic)) places.set(topic, new Set());
    places.get(topic).add(`${x} ${y} ${z}`);
  }
  if (topic === "/tf") for (const tf of message.transforms) frames.add(tf.childFrameId);
  if (topic === "/scene") entities = Math.max(entities, message.entities.length);
}

function missing() {
  const all = [...POSES.map((pattern) => [pattern, [...places.keys()].filter((t) => places.get(t).size > 1)]),
    ...FRAMES.map((pattern) => [pattern, [...frames]])];
  const lacks = all.filter(([pattern, names]) => !names.some((name) => pattern.test(name)));
  const what = lacks.map(([pattern]) => String(pattern));
  if (entities === 0) what.push("/scene");
  for (const topic of ["/estimate/report", "/estimate/time_map", "/marks"]) {
    if (!counts.has(topic)) what.push(topic);
  }
  return what;
}

function end(code, text) {
  (code ? console.error : console.log)(text);
  process.exit(code);
}

function seen() {
  for (const [topic, count] of [...counts].sort()) console.log(`${topic}: ${count}`);
  end(0, `frames ${[...frames].sort().join(", ")}; ${entities} entities`);
}

const client = new FoxgloveClient({ ws: new WebSocket(url, ["foxglove.sdk.v1"]) });
client.on("error", (error) => end(1, `FAILED: ${error.message ?? error}`));
client.on("close", () => end(1, "FAILED: closed"));
client.on("advertise", (channels) => {
  for (const channel of channels) {
    decoders.set(client.subscribe(channel.id), { channel, decode: decoder(channel) });
  }
});
client.on("message", ({ subscriptionId, data }) => {
  const { channel, decode } = decoders.get(subscriptionId);
  try {
    note(channel.topic, decode(data));
  } catch (error) {
    end(1, `FAILED: ${channel.topic}: ${error}`);
  }
  if (!stay && missing().length === 0) seen();
});
const late = () => end(1, `FAILED: nothing of ${missing().join(", ")}`);
setTimeout(stay ? seen : late, 1000 * Number(seconds));
