// Reads an MCAP file with the format's own library and decodes its messages as ROS 2 does.
//   decode.mjs --indexed FILE  through the index of a finished file
//   decode.mjs --stream FILE   from the beginning, as far as the file is whole
// Prints one JSON object for each message, in the order of the file's reader: topic, type, times, the message itself, and
// whether encoding it again gives the same bytes, which requires that the file's definition is that of the data.
import fs from 'node:fs/promises';
import {parse} from '@foxglove/rosmsg';
import {MessageReader, MessageWriter} from '@foxglove/rosmsg2-serialization';
import {McapIndexedReader, McapStreamReader} from '@mcap/core';

// The file interface of the indexed reader.
class FileHandle {
  constructor(file) { this.file = file; }
  async size() { return BigInt((await this.file.stat()).size); }
  async read(offset, length) {
    const bytes = new Uint8Array(Number(length));
    const {bytesRead} = await this.file.read(bytes, 0, bytes.length, Number(offset));
    if (bytesRead !== bytes.length) throw new Error(`${length} bytes at ${offset} are not there`);
    return bytes;
  }
}

async function* indexed(path) {
  const file = await fs.open(path);
  const reader = await McapIndexedReader.Initialize({readable: new FileHandle(file)});
  console.error(JSON.stringify({profile: reader.header.profile, library: reader.header.library,
    messages: Number(reader.statistics.messageCount), chunks: reader.chunkIndexes.length}));
  for await (const message of reader.readMessages({validateCrcs: true})) {
    const channel = reader.channelsById.get(message.channelId);
    yield {message, channel, schema: reader.schemasById.get(channel.schemaId)};
  }
  await file.close();
}

async function* stream(path) {
  const reader = new McapStreamReader({validateCrcs: true});
  reader.append(await fs.readFile(path));
  const schemas = new Map();
  const channels = new Map();
  for (let record = reader.nextRecord(); record; record = reader.nextRecord()) {
    if (record.type === 'Schema') schemas.set(record.id, record);
    if (record.type === 'Channel') channels.set(record.id, record);
    if (record.type === 'Message') {
      const channel = channels.get(record.channelId);
      yield {message: record, channel, schema: schemas.get(channel.schemaId)};
    }
  }
}

const codecs = new Map();
function codec(schema) {
  if (!codecs.has(schema.id)) {
    if (schema.encoding !== 'ros2msg') throw new Error(`${schema.name} is ${schema.encoding}`);
    const definition = parse(new TextDecoder().decode(schema.data), {ros2: true});
    codecs.set(schema.id, {reader: new MessageReader(definition), writer: new MessageWriter(definition)});
  }
  return codecs.get(schema.id);
}

// DDS pads to a multiple of four bytes; the fourth byte has the number of padding bytes.
function isSame(again, data) {
  again[3] = data.length - again.length;
  return again[3] < 4 && again.equals(data.subarray(0, again.length)) &&
    data.subarray(again.length).every((byte) => byte === 0);
}

const plain = (_, value) =>
  typeof value === 'bigint' ? String(value) : ArrayBuffer.isView(value) ? Array.from(value) : value;

const [how, path] = process.argv.slice(2);
for await (const {message, channel, schema} of how === '--stream' ? stream(path) : indexed(path)) {
  if (channel.messageEncoding !== 'cdr') throw new Error(`${channel.topic} is ${channel.messageEncoding}`);
  const {reader, writer} = codec(schema);
  const value = reader.readMessage(message.data);
  const again = Buffer.from(writer.writeMessage(value));
  console.log(JSON.stringify({topic: channel.topic, type: schema.name, log_time: message.logTime,
    publish_time: message.publishTime, sequence: message.sequence, bytes: message.data.length,
    same: isSame(again, Buffer.from(message.data)), value}, plain));
}
