//! The record in which a chunk repeats what its messages need to be understood.
//!
//! The format has no such record, and the writer of the library defines a schema and a channel
//! once in a file. A private record in the chunk holds both as they are defined, after a text by
//! which our reader knows it; readers that do not know it pass over it.

use std::fs::File;
use std::io::BufWriter;

use mcap::records::op;
use mcap::write::PrivateRecordOptions;
use mcap::{McapResult, Writer};

use crate::wire::container::{REPEATED, REPEATS};
use crate::wire::encode::SchemaRecord;

/// The body of the record for a schema and a channel: id and schema; id, topic and encoding.
pub(super) fn definition(
    schema_id: u16,
    schema: &SchemaRecord,
    id: u16,
    topic: &str,
    encoding: &str,
) -> Vec<u8> {
    let schema = [
        &schema_id.to_le_bytes()[..],
        &prefixed(schema.name.as_bytes()),
        &prefixed(schema.encoding.as_bytes()),
        &prefixed(&schema.data),
    ];
    let channel = [
        &id.to_le_bytes()[..],
        &schema_id.to_le_bytes(),
        &prefixed(topic.as_bytes()),
        &prefixed(encoding.as_bytes()),
        // No metadata.
        &prefixed(&[]),
    ];
    [
        REPEATED,
        &framed(op::SCHEMA, &schema.concat()),
        &framed(op::CHANNEL, &channel.concat()),
    ]
    .concat()
}

/// Writes it into the chunk.
pub(super) fn write(writer: &mut Writer<BufWriter<File>>, definition: &[u8]) -> McapResult<()> {
    let in_chunk = PrivateRecordOptions::IncludeInChunks.into();
    writer.write_private_record(REPEATS, definition, in_chunk)
}

fn framed(opcode: u8, body: &[u8]) -> Vec<u8> {
    [&[opcode][..], &(body.len() as u64).to_le_bytes(), body].concat()
}

fn prefixed(bytes: &[u8]) -> Vec<u8> {
    let length = u32::try_from(bytes.len()).expect("schemas and topics are short");
    [&length.to_le_bytes()[..], bytes].concat()
}
