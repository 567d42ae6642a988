//! A recording of ROS 2's profile, of which every message is one of ROS 2: what an estimate added, without what came in.

use std::borrow::Cow;
use std::collections::{BTreeMap, BTreeSet};
use std::io::Cursor;
use std::path::Path;

use mcap::Attachment;
use mcap::records::{MessageHeader, Metadata};

use super::super::dialect::ROS2;
use super::super::error::WriteError;
use super::super::{options, topics};
use super::motion::scene_of_estimate;
use super::names::numbered;
use crate::report::ExportProvenance;
use crate::wire::Container;
use crate::wire::ros2::RosMessage;
use crate::wire::translate::{ros_message, translated};

/// A topic as ROS 2 allows it, that none has had: letters, digits and underscores between slashes, no digit first.
fn ros_name(topic: &str, taken: &mut BTreeSet<String>) -> String {
    let tokens = topic.split('/').map(|token| {
        let plain = |c: char| if c.is_ascii_alphanumeric() { c } else { '_' };
        let plain: String = token.chars().map(plain).collect();
        match plain.chars().next() {
            Some(first) if first.is_ascii_digit() => format!("_{plain}"),
            _ => plain,
        }
    });
    numbered(tokens.collect::<Vec<_>>().join("/"), taken)
}

/// A channel of an estimate and what becomes of it.
struct RosChannel<'a> {
    topic: &'a str,
    schema: &'a str,
    encoding: &'a str,
    to: RosMessage,
    id: u16,
}

/// What a player of ROS 2 offers readers of a channel. RViz takes a robot's description only from who keeps it for
/// those that come later.
fn offered(topic: &str) -> String {
    // Numbers of `rmw/types.h`: keep last, reliable, automatic; transient local or volatile; without end.
    const FOREVER: &str = "\n    sec: 9223372036\n    nsec: 854775807";
    let durability = match topic {
        topics::ROBOT_DESCRIPTION => 1,
        _ => 2,
    };
    format!(
        "- history: 1\n  depth: 10\n  reliability: 1\n  durability: {durability}\n  deadline:{FOREVER}\n  \
         lifespan:{FOREVER}\n  liveliness: 1\n  liveliness_lease_duration:{FOREVER}\n  \
         avoid_ros_namespace_conventions: false"
    )
}

/// The file, on the topics on which ROS 2 looks for such messages: whatever the recording itself had there is not in
/// it. Stamps and log times are those of the estimate. Drawings have no message in ROS 2: the URDF says the same.
///
/// Fails where a message of the estimate cannot be read.
pub fn ros2(
    path: &Path,
    container: &Container,
    provenance: &ExportProvenance,
) -> Result<Vec<u8>, WriteError> {
    let failed = |source| WriteError::mcap(path)(source);
    let mut writer = options::writer(Cursor::new(Vec::new()), ROS2).map_err(failed)?;
    let scene_toml = scene_of_estimate(container).unwrap_or_default();
    let attachment = Attachment {
        log_time: 0,
        create_time: 0,
        name: super::super::estimate::SCENE_NAME.to_owned(),
        media_type: "application/toml".to_owned(),
        data: Cow::Borrowed(scene_toml),
    };
    writer.attach(&attachment).map_err(failed)?;
    let text = provenance.lines().join("\n");
    let metadata = Metadata {
        name: "enact.provenance".to_owned(),
        metadata: [("provenance".to_owned(), text)].into(),
    };
    writer.write_metadata(&metadata).map_err(failed)?;
    // By it later players read what is offered as the numbers that all of them know.
    let metadata = Metadata {
        name: "rosbag2".to_owned(),
        metadata: [("ROS_DISTRO".to_owned(), "humble".to_owned())].into(),
    };
    writer.write_metadata(&metadata).map_err(failed)?;
    let mut channels: BTreeMap<u16, RosChannel> = BTreeMap::new();
    let mut taken = BTreeSet::new();
    let ours = container.channels().iter();
    for (id, channel) in ours.filter(|(_, of)| topics::is_ours(&of.metadata)) {
        let Some(schema) = container.schema_of(channel) else {
            continue;
        };
        let (schema, encoding) = (schema.name.as_str(), channel.message_encoding.as_str());
        let Some(to) = ros_message(schema, encoding) else {
            continue;
        };
        let topic = match to {
            RosMessage::JointState => topics::ROS_JOINTS.to_owned(),
            _ => ros_name(topics::undisputed(&channel.topic), &mut taken),
        };
        let record = to.schema();
        let mut metadata = topics::metadata();
        metadata.insert("offered_qos_profiles".to_owned(), offered(&topic));
        let added = writer
            .add_schema(&record.name, &record.encoding, &record.data)
            .and_then(|schema| writer.add_channel(schema, &topic, "cdr", &metadata));
        let channel = RosChannel {
            topic: &channel.topic,
            schema,
            encoding,
            to,
            id: added.map_err(failed)?,
        };
        channels.insert(*id, channel);
    }
    let mut sequences: BTreeMap<u16, u32> = BTreeMap::new();
    let mut walk = container.walk();
    while let Some(message) = walk.next_message() {
        let Some(channel) = channels.get(&message.channel_id) else {
            continue;
        };
        let data = translated(channel.schema, channel.encoding, channel.to, message.data)
            .map_err(WriteError::translate(path, channel.topic))?;
        let sequence = sequences.entry(channel.id).or_default();
        let header = MessageHeader {
            channel_id: channel.id,
            sequence: *sequence,
            log_time: message.log_time,
            publish_time: message.publish_time,
        };
        *sequence += 1;
        writer
            .write_to_known_channel(&header, &data)
            .map_err(failed)?;
    }
    writer.finish().map_err(failed)?;
    Ok(writer.into_inner().into_inner())
}
