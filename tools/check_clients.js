// Reads one MCAP file with the JavaScript reader, as web viewers do: by its index, every
// checksum, every protobuf decoded by the schema it carries.
const fs = require("fs/promises");
const { McapIndexedReader } = require("@mcap/core");
const { FileHandleReadable } = require("@mcap/nodejs");
const { loadDecompressHandlers } = require("@mcap/support");
const protobuf = require("protobufjs");
const descriptor = require("protobufjs/ext/descriptor");

async function main(path) {
  const readable = new FileHandleReadable(await fs.open(path, "r"));
  const reader = await McapIndexedReader.Initialize({
    readable,
    decompressHandlers: await loadDecompressHandlers(),
  });
  const types = new Map();
  for (const [id, schema] of reader.schemasById) {
    if (schema.encoding === "protobuf") {
      const set = descriptor.FileDescriptorSet.decode(schema.data);
      types.set(id, protobuf.Root.fromDescriptor(set).lookupType(schema.name));
    }
  }
  let count = 0;
  let decoded = 0;
  let last = 0n;
  for await (const message of reader.readMessages({ validateCrcs: true })) {
    const channel = reader.channelsById.get(message.channelId);
    if (message.logTime < last) throw new Error(`${channel.topic}: not in order`);
    last = message.logTime;
    count += 1;
    const type = types.get(channel.schemaId);
    if (channel.messageEncoding === "protobuf") {
      type.decode(message.data);
      decoded += 1;
    } else if (channel.messageEncoding === "json") {
      JSON.parse(new TextDecoder().decode(message.data));
    }
  }
  if (BigInt(count) !== reader.statistics.messageCount) {
    throw new Error(`${count} messages, ${reader.statistics.messageCount} claimed`);
  }
  for await (const attachment of reader.readAttachments({ validateCrcs: true })) {
    console.log(`@mcap/core attachment ${attachment.name}, ${attachment.data.length} bytes`);
  }
  console.log(`@mcap/core ${count} messages, ${decoded} protobufs decoded`);
}

main(process.argv[2]).then(
  () => process.exit(0),
  (error) => {
    console.error(`FAILED: ${error}`);
    process.exit(1);
  },
);
