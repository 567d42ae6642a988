//! Raw parts of MCAP files, valid or not, as somebody would make them who means harm.

use std::io::Write;

pub const MAGIC: [u8; 8] = *b"\x89MCAP0\r\n";
pub const SCHEMA: u8 = 0x03;
pub const CHANNEL: u8 = 0x04;
pub const MESSAGE: u8 = 0x05;
pub const CHUNK: u8 = 0x06;
pub const ATTACHMENT: u8 = 0x09;
pub const METADATA: u8 = 0x0c;

/// The topic of the pencil's tracker, and its scene.
pub const TOPIC: &str = "/tracker/pencil/pose";
pub const SCENE: &str = include_str!("../../config/pencil_tip.toml");

pub fn record(opcode: u8, body: &[u8]) -> Vec<u8> {
    let length = (body.len() as u64).to_le_bytes();
    [&[opcode][..], &length, body].concat()
}

pub fn text(text: &[u8]) -> Vec<u8> {
    [&(text.len() as u32).to_le_bytes()[..], text].concat()
}

pub fn schema(id: u16, name: &str, data: &[u8]) -> Vec<u8> {
    let id = id.to_le_bytes();
    let encoding = text(b"protobuf");
    record(
        SCHEMA,
        &[&id[..], &text(name.as_bytes()), &encoding, &text(data)].concat(),
    )
}

pub fn channel(id: u16, schema: u16, topic: &str, encoding: &str, pairs: &[u8]) -> Vec<u8> {
    let ids = [id.to_le_bytes(), schema.to_le_bytes()].concat();
    let (topic, encoding) = (text(topic.as_bytes()), text(encoding.as_bytes()));
    record(CHANNEL, &[ids, topic, encoding, text(pairs)].concat())
}

pub fn message(channel: u16, log_time: u64, data: &[u8]) -> Vec<u8> {
    let (channel, time) = (channel.to_le_bytes(), log_time.to_le_bytes());
    record(
        MESSAGE,
        &[&channel[..], &[0; 4], &time, &time, data].concat(),
    )
}

/// An attachment; its checksum is wrong if wanted.
pub fn attachment(name: &str, data: &[u8], is_wrong: bool) -> Vec<u8> {
    let length = (data.len() as u64).to_le_bytes();
    let names = [text(name.as_bytes()), text(b"application/toml")].concat();
    let mut body = [&[0; 16][..], &names, &length, data].concat();
    let crc = crc32fast::hash(&body) ^ u32::from(is_wrong);
    body.extend_from_slice(&crc.to_le_bytes());
    record(ATTACHMENT, &body)
}

/// The body of a chunk up to its data.
pub fn chunk_head(compression: &str, size: u64, crc: u32, packed: u64) -> Vec<u8> {
    let name = text(compression.as_bytes());
    let (size, crc, packed) = (size.to_le_bytes(), crc.to_le_bytes(), packed.to_le_bytes());
    [&[0; 16][..], &size, &crc, &name, &packed].concat()
}

/// A valid chunk.
pub fn chunk(compression: &str, records: &[u8]) -> Vec<u8> {
    let packed = match compression {
        "zstd" => zstd::bulk::compress(records, 3).expect("compress"),
        "lz4" => {
            let mut encoder = lz4::EncoderBuilder::new()
                .build(Vec::new())
                .expect("encoder");
            encoder.write_all(records).expect("compress");
            encoder.finish().0
        }
        _ => records.to_vec(),
    };
    let (size, crc) = (records.len() as u64, crc32fast::hash(records));
    let head = chunk_head(compression, size, crc, packed.len() as u64);
    record(CHUNK, &[head, packed].concat())
}

/// A file of these parts, without summary.
pub fn file(parts: &[&[u8]]) -> Vec<u8> {
    let data_end = record(0x0f, &[0; 4]);
    let footer = record(0x02, &[0; 20]);
    let header = record(0x01, &[text(b""), text(b"")].concat());
    let parts = parts.concat();
    [&MAGIC[..], &header, &parts, &data_end, &footer, &MAGIC].concat()
}

/// Scene, schema and channel of a pencil's recording.
pub fn beginning() -> Vec<u8> {
    [
        attachment("scene.toml", SCENE.as_bytes(), false),
        schema(1, "foxglove.PoseInFrame", b""),
        channel(1, 1, TOPIC, "protobuf", b""),
    ]
    .concat()
}

/// A `foxglove.PoseInFrame` at a time, upright above the table.
pub fn pose(nanoseconds: u64) -> Vec<u8> {
    let double = |field: u8, value: f64| [&[field << 3 | 1][..], &value.to_le_bytes()].concat();
    let nested = |field: u8, body: Vec<u8>| [vec![field << 3 | 2, body.len() as u8], body].concat();
    let position = nested(1, double(3, 0.4));
    let orientation = nested(2, double(4, 1.0));
    let seconds = nanoseconds / 1_000_000_000;
    let nanos = (nanoseconds % 1_000_000_000) as u32;
    let mut time = vec![0x08];
    varint(&mut time, seconds);
    time.push(0x10);
    varint(&mut time, u64::from(nanos));
    let pose = nested(3, [position, orientation].concat());
    [nested(1, time), nested(2, b"map".to_vec()), pose].concat()
}

fn varint(bytes: &mut Vec<u8>, mut value: u64) {
    while value >= 0x80 {
        bytes.push(value as u8 | 0x80);
        value >>= 7;
    }
    bytes.push(value as u8);
}
