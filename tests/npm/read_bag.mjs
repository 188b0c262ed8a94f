// Reads one MCAP file with the libraries that Foxglove is made of and prints all of it as JSON.
// Usage: node read_bag.mjs FILE.mcap

import { open } from "node:fs/promises";

import { parse } from "@foxglove/rosmsg";
import { MessageReader } from "@foxglove/rosmsg2-serialization";
import { McapIndexedReader } from "@mcap/core";
import { loadDecompressHandlers } from "@mcap/support";

const file = await open(process.argv[2]);
const readable = {
  size: async () => BigInt((await file.stat()).size),
  read: async (offset, length) => {
    const buffer = new Uint8Array(Number(length));
    await file.read(buffer, 0, Number(length), Number(offset));
    return buffer;
  },
};

// JSON has no words for big integers, typed arrays, NaN and infinities.
function plain(_key, value) {
  if (typeof value === "bigint") return value.toString();
  if (typeof value === "number" && !Number.isFinite(value)) return String(value);
  if (ArrayBuffer.isView(value)) return Array.from(value);
  return value;
}

const reader = await McapIndexedReader.Initialize({ readable, decompressHandlers: await loadDecompressHandlers() });
const decoders = new Map();
for (const [id, schema] of reader.schemasById) {
  const definition = parse(new TextDecoder().decode(schema.data), { ros2: true });
  decoders.set(id, new MessageReader(definition));
}

const messages = [];
for await (const message of reader.readMessages()) {
  const channel = reader.channelsById.get(message.channelId);
  messages.push({
    topic: channel.topic,
    time: message.logTime,
    publishTime: message.publishTime,
    value: decoders.get(channel.schemaId).readMessage(message.data),
  });
}
const metadata = [];
for await (const record of reader.readMetadata()) {
  metadata.push({ name: record.name, values: Object.fromEntries(record.metadata) });
}
const attachments = [];
for await (const record of reader.readAttachments()) {
  attachments.push({ name: record.name, mediaType: record.mediaType, text: new TextDecoder().decode(record.data) });
}
const channels = Array.from(reader.channelsById.values(), (channel) => ({
  topic: channel.topic,
  encoding: channel.messageEncoding,
  type: reader.schemasById.get(channel.schemaId).name,
  schemaEncoding: reader.schemasById.get(channel.schemaId).encoding,
  metadata: Object.fromEntries(channel.metadata),
  count: reader.statistics.channelMessageCounts.get(channel.id),
}));

const all = { profile: reader.header.profile, channels, messages, metadata, attachments };
process.stdout.write(JSON.stringify(all, plain));
await file.close();
