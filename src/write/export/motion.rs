//! What an estimate added to a recording, read back.

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

use typed_index_collections::TiVec;

use super::super::error::WriteError;
use super::super::estimate::{ESTIMATE_SCENE_NAME, SCENE_NAME};
use super::super::topics;
use crate::motion::{LinkIndex, PoseSample, Scene, Stamp};
use crate::report::{DeviationMessage, EstimateMessage, Provenance};
use crate::sampling::{make_signs_continuous, stamp};
use crate::wire::{Container, DecodeError, PoseFormat, decode_text};

/// The motion as it was written: stamped poses, link by link, with increasing stamps.
#[derive(Clone, Debug, PartialEq)]
pub struct WrittenMotion {
    /// `physical`, `plausible` or `failed`.
    pub verdict: String,
    /// From what the estimate was made, if it says so.
    pub provenance: Option<Provenance>,
    /// All that it says, as JSON.
    pub report: Vec<u8>,
    /// The stamp of physical time zero.
    pub zero: Stamp,
    /// When events happen, with their names, in order of time.
    pub events: Vec<(Stamp, String)>,
    /// From when on the motion is simulated, if it is.
    pub simulated_from: Option<Stamp>,
    /// Names of what was free and is estimated, in alphabetical order.
    pub parameters: Vec<String>,
    /// The estimated motion; empty of a link without one.
    pub estimates: TiVec<LinkIndex, Vec<PoseSample>>,
    /// How certain it is, at its poses; empty of a link of which the file does not say it.
    pub deviations: TiVec<LinkIndex, Vec<DeviationMessage>>,
    /// The performance, at its physical times; empty of a link whose poses no tracker sees.
    pub sketches: TiVec<LinkIndex, Vec<PoseSample>>,
}

/// The scene of the estimate in a file, as text.
pub fn scene_of_estimate(container: &Container) -> Option<&[u8]> {
    let named = |name: &str| {
        let mut attachments = container.attachments().iter();
        attachments.rfind(|attachment| attachment.name == name)
    };
    let scene = named(ESTIMATE_SCENE_NAME).or_else(|| named(SCENE_NAME));
    scene.map(|attachment| container.attachment_data(attachment))
}

/// What a channel of ours has.
#[derive(Clone, Copy)]
enum Has {
    Estimate(LinkIndex, PoseFormat),
    Sketch(LinkIndex, PoseFormat),
    Deviation(LinkIndex),
    Report,
}

impl WrittenMotion {
    /// Reads the motion of the scene's links. Fails where the file has no estimate, or where a message of it
    /// cannot be read: half a motion would look like a whole one.
    pub fn read(path: &Path, container: &Container, scene: &Scene) -> Result<Self, WriteError> {
        let channels = channels(container, scene);
        let mut estimates: TiVec<LinkIndex, Vec<PoseSample>> =
            scene.links.iter().map(|_| Vec::new()).collect();
        let mut sketches = estimates.clone();
        let mut deviations: TiVec<LinkIndex, Vec<DeviationMessage>> =
            scene.links.iter().map(|_| Vec::new()).collect();
        let mut report: Option<(EstimateMessage, Vec<u8>)> = None;
        let mut walk = container.walk();
        while let Some(message) = walk.next_message() {
            let Some((topic, has)) = channels.get(&message.channel_id) else {
                continue;
            };
            let failed = WriteError::decode(path, topic);
            match *has {
                Has::Report => report = Some(report_of(message.data).map_err(failed)?),
                Has::Estimate(link, format) => {
                    estimates[link].push(sample(format, message.data).map_err(failed)?);
                }
                Has::Deviation(link) => {
                    deviations[link].push(deviation_of(message.data).map_err(failed)?);
                }
                Has::Sketch(link, format) => {
                    sketches[link].push(sample(format, message.data).map_err(failed)?);
                }
            }
        }
        let (message, json) = report.ok_or_else(|| WriteError::NoEstimate {
            path: path.to_owned(),
        })?;
        for samples in estimates.iter_mut().chain(&mut sketches) {
            samples.sort_by_key(|sample| sample.stamp);
            samples.dedup_by_key(|sample| sample.stamp);
            make_signs_continuous(samples);
        }
        for deviations in &mut deviations {
            deviations.sort_by_key(DeviationMessage::stamp);
        }
        let zero = message.time_map.physical_zero.unwrap_or_default().into();
        let report = message.report;
        let events = report.events.into_iter();
        let events = events.map(|event| (stamp(zero, event.time_s), event.name));
        let mut events: Vec<(Stamp, String)> = events.collect();
        events.sort_by_key(|(at, _)| *at);
        let parameters = report.parameters.0.into_iter();
        let parameters: BTreeSet<String> = parameters.map(|(name, _)| name).collect();
        Ok(Self {
            verdict: report.verdict,
            provenance: message.provenance,
            report: json,
            zero,
            events,
            simulated_from: report.settled.map(|settled| stamp(zero, settled.from_s)),
            parameters: parameters.into_iter().collect(),
            estimates,
            deviations,
            sketches,
        })
    }
}

/// Our channels by what they have, with their topics.
fn channels<'a>(container: &'a Container, scene: &Scene) -> BTreeMap<u16, (&'a str, Has)> {
    let ours = container.channels().iter();
    let ours = ours.filter(|(_, channel)| topics::is_ours(&channel.metadata));
    let of = ours.filter_map(|(id, channel)| {
        let topic = channel.topic.as_str();
        let format = || {
            let schema = container.schema_of(channel)?;
            PoseFormat::of(&schema.name, &channel.message_encoding)
        };
        // The topic as we name it, before the same where the recording had one there.
        let has = [Some(topic), topic.strip_prefix("/estimate")]
            .into_iter()
            .flatten()
            .find_map(|topic| {
                if topic == topics::REPORT {
                    return Some(Has::Report);
                }
                let mut links = scene.links.iter_enumerated();
                links.find_map(|(link, of)| {
                    if topic == topics::estimate_pose(&of.name) {
                        Some(Has::Estimate(link, format()?))
                    } else if topic == topics::estimate_deviation(&of.name) {
                        Some(Has::Deviation(link))
                    } else if topic == topics::sketch_pose(&of.name) {
                        Some(Has::Sketch(link, format()?))
                    } else {
                        None
                    }
                })
            });
        Some((*id, (topic, has?)))
    });
    of.collect()
}

/// The JSON of a report, as it is or in a ROS 2 string.
pub(super) fn json_of(data: &[u8]) -> Result<Vec<u8>, DecodeError> {
    match data.first() {
        Some(b'{') => Ok(data.to_vec()),
        _ => Ok(decode_text(data)?.into_bytes()),
    }
}

/// What it says, and its JSON. Fails where it does not say when the motion is.
fn report_of(data: &[u8]) -> Result<(EstimateMessage, Vec<u8>), DecodeError> {
    let json = json_of(data)?;
    let message = EstimateMessage::read(&json);
    let message = message.map_err(|error| DecodeError::Json(error.to_string()))?;
    let report = &message.report;
    let event_times = report.events.iter().map(|event| event.time_s);
    let mut times = event_times.chain(report.settled.as_ref().map(|settled| settled.from_s));
    let lacks = [
        ("verdict", report.verdict.is_empty()),
        ("physical zero", message.time_map.physical_zero.is_none()),
        ("finite time", !times.all(f64::is_finite)),
    ];
    match lacks.into_iter().find(|(_, lacks)| *lacks) {
        Some((what, _)) => Err(DecodeError::Missing(what)),
        None => Ok((message, json)),
    }
}

fn deviation_of(data: &[u8]) -> Result<DeviationMessage, DecodeError> {
    let message = DeviationMessage::read(&json_of(data)?);
    message.map_err(|error| DecodeError::Json(error.to_string()))
}

fn sample(format: PoseFormat, data: &[u8]) -> Result<PoseSample, DecodeError> {
    let mut poses = Vec::new();
    format.decode(data, &mut poses)?;
    let pose = poses.pop().ok_or(DecodeError::Missing("pose"))?;
    let mut numbers = pose.position_m.iter().chain(&pose.quaternion_xyzw);
    if !numbers.all(|number| number.is_finite()) {
        return Err(DecodeError::Missing("finite pose"));
    }
    // Where a message has no stamp its time is zero: that is how zero is encoded.
    Ok(pose.sample(Stamp(0)))
}
