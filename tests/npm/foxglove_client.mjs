// A client of a live Foxglove server, made of Foxglove's own libraries. Takes commands on standard input and prints
// what the server says, one JSON object a line each.
// Usage: node foxglove_client.mjs URL [ORIGIN] [PROTOCOL]
// Commands: {"subscribe": TOPIC}, {"unsubscribe": TOPIC}, {"get": [NAME, ...]}, {"set": {NAME: VALUE, ...}},
// {"watch": [NAME, ...]}

import { createInterface } from "node:readline";

import { parse } from "@foxglove/rosmsg";
import { MessageReader } from "@foxglove/rosmsg2-serialization";
import protocol from "@foxglove/ws-protocol";
import WebSocket from "ws";

const [url, origin, name] = process.argv.slice(2);
const socket = new WebSocket(url, [name || "foxglove.sdk.v1"], { origin: origin || undefined });
const client = new protocol.FoxgloveClient({ ws: socket });
const channels = new Map(); // by topic
const subscribed = new Map(); // by subscription

// JSON has no words for big integers, typed arrays, NaN and infinities.
function plain(_key, value) {
  if (typeof value === "bigint") return value.toString();
  if (typeof value === "number" && !Number.isFinite(value)) return String(value);
  if (ArrayBuffer.isView(value)) return Array.from(value);
  return value;
}

function say(event, content) {
  process.stdout.write(JSON.stringify({ event, ...content }, plain) + "\n");
}

client.on("error", (error) => say("error", { text: error.message }));
client.on("close", () => {
  say("close", {});
  process.exit(0);
});
client.on("serverInfo", (info) => say("serverInfo", info));
client.on("status", (status) => say("status", status));
client.on("removeStatus", (removed) => say("removeStatus", removed));
client.on("time", ({ timestamp }) => say("time", { timestamp }));
client.on("parameterValues", ({ parameters, id }) => say("parameters", { parameters, id }));
client.on("advertise", (advertised) => {
  for (const channel of advertised) {
    const definition = parse(channel.schema, { ros2: true });
    channels.set(channel.topic, { id: channel.id, reader: new MessageReader(definition) });
    const { topic, encoding, schemaName, schemaEncoding, schema } = channel;
    say("channel", { topic, encoding, schemaName, schemaEncoding, schema });
  }
});
client.on("message", ({ subscriptionId, timestamp, data }) => {
  const topic = subscribed.get(subscriptionId);
  say("message", { topic, time: timestamp, value: channels.get(topic).reader.readMessage(data) });
});

for await (const line of createInterface({ input: process.stdin })) {
  const command = JSON.parse(line);
  if (command.subscribe) subscribed.set(client.subscribe(channels.get(command.subscribe).id), command.subscribe);
  if (command.unsubscribe) {
    const [id] = [...subscribed].find(([, topic]) => topic === command.unsubscribe);
    client.unsubscribe(id);
  }
  if (command.get) client.getParameters(command.get, "get");
  if (command.watch) client.subscribeParameterUpdates(command.watch);
  if (command.set) {
    const parameters = Object.entries(command.set).map(([name, value]) => ({ name, value }));
    client.setParameters(parameters, "set");
  }
}
client.close();
