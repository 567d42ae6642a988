//! Any bytes as a recording: never a panic, never what they claim allocated.
#![no_main]

use enact::wire::container::{Container, digest};
use enact::wire::decode::{MarkFormat, PoseFormat};
use libfuzzer_sys::fuzz_target;

fuzz_target!(|bytes: &[u8]| {
    let _ = std::hint::black_box(digest(
        &mut std::io::Cursor::new(bytes),
        "/tracker/pencil/pose",
    ));
    let Ok(container) = Container::new(bytes.to_vec()) else {
        return;
    };
    for attachment in container.attachments() {
        std::hint::black_box(container.attachment_data(attachment));
    }
    let mut walk = container.walk();
    let mut poses = Vec::new();
    while let Some(message) = walk.next_message() {
        let Some(channel) = container.channels().get(&message.channel_id) else {
            continue;
        };
        let name = container
            .schema_of(channel)
            .map_or("", |schema| schema.name.as_str());
        if let Some(format) = PoseFormat::of(name, &channel.message_encoding) {
            poses.clear();
            let _ = format.decode(message.data, &mut poses);
        }
        if let Some(format) = MarkFormat::of(name, &channel.message_encoding) {
            let _ = format.decode(message.data);
        }
    }
});
