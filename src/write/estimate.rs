//! What came in and the estimated motion beside it, in one MCAP file.

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;

use super::dialect::{self, Dialect, Format};
use super::error::WriteError;
use super::merge::{self, Additions, OurChannel, OurMessage};
use super::motion;
use super::{drawing, topics, urdf};
use crate::motion::{PoseSample, Scene, Stamp, Surface};
use crate::report::{EstimateMessage, REPORT_SCHEMA, Reported, TIME_MAP_SCHEMA, TimeMap, json};
use crate::wire::ros2;
use crate::wire::{Container, Transform};

/// Frames per second of the motion, unless the user wants others.
pub const DEFAULT_FRAME_RATE_HZ: f64 = 240.0;

/// The world's frame, where the recording does not name it.
pub const DEFAULT_WORLD_FRAME: &str = "world";

/// Attachment that holds the scene.
const SCENE_NAME: &str = "scene.toml";

/// Attachment that holds the scene of the estimate where the recording has another one.
const ESTIMATE_SCENE_NAME: &str = "estimate_scene.toml";

/// Surfaces are drawn at least this wide \[m\].
const SURFACE_SIDE_M: f64 = 0.5;

/// Everything an output file is made of.
#[derive(Clone, Copy)]
pub struct EstimateFile<'a> {
    /// What came in.
    pub input: &'a Container,
    /// Where it came from, if from a file: the output must be another.
    pub input_path: Option<&'a Path>,
    /// The estimate and what belongs to it.
    pub of: Reported<'a>,
    /// Its scene as text.
    pub scene_toml: &'a [u8],
    /// The frame in which the recording gives its poses.
    pub world_frame: &'a str,
    /// Log time less stamp \[ns\]: messages are logged so much later than they are stamped.
    pub log_offset_ns: i64,
    /// Frames per second of the motion; what was simulated after it has an interval of its own.
    pub frame_rate_hz: f64,
}

/// What was written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Written {
    /// Messages of the input.
    pub copied: u64,
    /// Messages of the estimate.
    pub added: u64,
}

/// Writes the file under that name, whole or not at all.
///
/// Every message, attachment, metadata record, channel and schema of the input is in it as it
/// was, in order of log time, but for what an earlier estimate added. Physical time zero is
/// stamped as the first sample used. See [`topics`] for what is added.
pub fn write_estimate(path: &Path, file: &EstimateFile) -> Result<Written, WriteError> {
    if file.input_path.is_some_and(|input| is_same(path, input)) {
        return Err(WriteError::IsInput {
            path: path.to_owned(),
        });
    }
    let additions = Composer::new(path, file).compose()?;
    let added = additions.messages.len() as u64;
    let copied = merge::write(path, file.input, Some(ESTIMATE_SCENE_NAME), additions)?;
    Ok(Written { copied, added })
}

/// Whether both names mean one file.
pub(super) fn is_same(a: &Path, b: &Path) -> bool {
    let (Ok(a), Ok(b)) = (fs::canonicalize(a), fs::canonicalize(b)) else {
        return false;
    };
    #[cfg(unix)]
    {
        use std::os::unix::fs::MetadataExt;
        if let (Ok(a), Ok(b)) = (fs::metadata(&a), fs::metadata(&b)) {
            return (a.dev(), a.ino()) == (b.dev(), b.ino());
        }
    }
    a == b
}

/// Makes our messages of an estimate.
struct Composer<'a> {
    path: &'a Path,
    file: &'a EstimateFile<'a>,
    dialect: Dialect,
    zero: Stamp,
    additions: Additions,
}

impl<'a> Composer<'a> {
    fn new(path: &'a Path, file: &'a EstimateFile<'a>) -> Self {
        Self {
            path,
            file,
            dialect: Dialect::of(file.input),
            zero: motion::zero(file.of.estimate, file.of.sketch),
            additions: Additions::default(),
        }
    }

    fn compose(mut self) -> Result<Additions, WriteError> {
        let Reported {
            scene,
            estimate,
            sketch,
            ..
        } = self.file.of;
        let mut estimates = Vec::new();
        let mut sketches = Vec::new();
        for (index, body) in scene.bodies.iter().enumerate() {
            let samples = self.estimate_samples(index)?;
            self.add_poses(&topics::estimate_pose(&body.name), &samples)?;
            estimates.push(samples);
            let samples = motion::sketch_samples(estimate, sketch, index, self.zero);
            self.add_poses(&topics::sketch_pose(&body.name), &samples)?;
            sketches.push(samples);
        }
        self.add_transforms(&estimates, &sketches)?;
        self.add_drawings(&estimates)?;
        self.add_events()?;
        self.add_reports();
        self.add_scene();
        Ok(self.additions)
    }

    fn estimate_samples(&self, body: usize) -> Result<Vec<PoseSample>, WriteError> {
        let mut samples = motion::estimate_samples(
            self.path,
            self.file.of.scene,
            self.file.of.estimate,
            body,
            self.zero,
            self.file.frame_rate_hz,
        )?;
        if let Some(settled) = self.file.of.settled {
            motion::append_settled(&mut samples, settled, body, self.zero);
        }
        Ok(samples)
    }

    fn add_poses(&mut self, topic: &str, samples: &[PoseSample]) -> Result<(), WriteError> {
        let channel = self.channel(topic, self.dialect.poses());
        for sample in samples {
            let data = self
                .dialect
                .pose(self.file.world_frame, sample)
                .map_err(WriteError::encode(self.path, topic))?;
            self.push(channel, sample.stamp, data);
        }
        Ok(())
    }

    /// One message per instant, of all frames that have a pose there.
    fn add_transforms(
        &mut self,
        estimates: &[Vec<PoseSample>],
        sketches: &[Vec<PoseSample>],
    ) -> Result<(), WriteError> {
        let channel = self.channel(topics::TRANSFORMS, self.dialect.transforms());
        let bodies = &self.file.of.scene.bodies;
        let frames: Vec<String> = bodies
            .iter()
            .map(|body| topics::estimate_frame(&body.name))
            .chain(bodies.iter().map(|body| topics::sketch_frame(&body.name)))
            .collect();
        let mut instants: BTreeMap<Stamp, Vec<Transform>> = BTreeMap::new();
        for (child, samples) in frames.iter().zip(estimates.iter().chain(sketches)) {
            for &sample in samples {
                instants.entry(sample.stamp).or_default().push(Transform {
                    parent: self.file.world_frame,
                    child,
                    sample,
                });
            }
        }
        for (stamp, transforms) in instants {
            let data = self
                .dialect
                .transforms_of(&transforms)
                .map_err(WriteError::encode(self.path, topics::TRANSFORMS))?;
            self.push(channel, stamp, data);
        }
        Ok(())
    }

    fn add_drawings(&mut self, estimates: &[Vec<PoseSample>]) -> Result<(), WriteError> {
        let (scene, world_frame) = (self.file.of.scene, self.file.world_frame);
        let side_m = surface_side_m(scene, estimates);
        if let Some(format) = self.dialect.drawings() {
            let channel = self.channel(topics::SCENE, format);
            let data = drawing::scene_update(self.path, scene, world_frame, self.zero, side_m)?;
            self.push(channel, self.zero, data);
        }
        let channel = self.channel(topics::ROBOT_DESCRIPTION, dialect::text());
        let data = ros2::string(&urdf::robot(scene, world_frame, side_m));
        self.push(channel, self.zero, data);
        Ok(())
    }

    fn add_events(&mut self) -> Result<(), WriteError> {
        let channel = self.channel(topics::EVENTS, self.dialect.events());
        let events = self.file.of.estimate.events.iter().map(|estimate| {
            let event = &self.file.of.scene.events[estimate.event];
            (estimate.time_s, event.name.as_str(), event.kind.as_str())
        });
        let settled = self.file.of.settled.iter();
        let simulated = settled.map(|s| (s.from_s, "simulated from here", "simulation"));
        for (time_s, name, kind) in events.chain(simulated) {
            let stamp = motion::stamp(self.zero, time_s);
            if stamp.0 < 0 {
                continue;
            }
            let data = self
                .dialect
                .event(stamp, Some(name), Some(kind))
                .map_err(WriteError::encode(self.path, topics::EVENTS))?;
            self.push(channel, stamp, data);
        }
        Ok(())
    }

    fn add_reports(&mut self) {
        let Reported {
            scene,
            sketch,
            estimate,
            ..
        } = self.file.of;
        let time_map = TimeMap::new(scene, sketch, estimate, self.zero);
        let report = EstimateMessage::new(&self.file.of, self.zero);
        for (topic, name, schema, data) in [
            (
                topics::TIME_MAP,
                "enact.TimeMap",
                TIME_MAP_SCHEMA,
                json(&time_map),
            ),
            (
                topics::REPORT,
                "enact.EstimateReport",
                REPORT_SCHEMA,
                json(&report),
            ),
        ] {
            let channel = self.channel(topic, self.dialect.json(name, schema));
            self.push(channel, self.zero, self.dialect.json_of(data));
        }
    }

    fn add_scene(&mut self) {
        let input = self.file.input;
        let given = input
            .attachments()
            .iter()
            .rfind(|attachment| attachment.name == SCENE_NAME)
            .map(|attachment| input.attachment_data(attachment));
        let name = match given {
            None => SCENE_NAME,
            Some(scene) if scene != self.file.scene_toml => ESTIMATE_SCENE_NAME,
            Some(_) => return,
        };
        self.additions.scene = Some((name, self.file.scene_toml.to_vec()));
    }

    /// A channel on that topic, or under `/estimate` where the input has one there.
    fn channel(&mut self, topic: &str, (schema, message_encoding): Format) -> usize {
        let input = self.file.input;
        let is_taken = input
            .channels()
            .values()
            .any(|channel| channel.topic == topic && !topics::is_ours(&channel.metadata));
        self.additions.channels.push(OurChannel {
            topic: if is_taken {
                format!("/estimate{topic}")
            } else {
                topic.to_owned()
            },
            schema,
            message_encoding,
            metadata: topics::metadata(),
        });
        self.additions.channels.len() - 1
    }

    fn push(&mut self, channel: usize, stamp: Stamp, data: Vec<u8>) {
        let log_time = stamp.0.saturating_add(self.file.log_offset_ns);
        self.additions.messages.push(OurMessage {
            channel,
            // A log time before 1970 cannot be said; zero is the nearest.
            log_time: u64::try_from(log_time).unwrap_or(0),
            data,
        });
    }
}

/// How wide surfaces are drawn for the motion to stay above them \[m\].
pub(super) fn surface_side_m(scene: &Scene, estimates: &[Vec<PoseSample>]) -> f64 {
    let mut side_m = SURFACE_SIDE_M;
    for (point_m, normal) in scene.surfaces.iter().filter_map(Surface::plane) {
        for sample in estimates.iter().flatten() {
            let offset_m = sample.position_m - point_m;
            let along_m = offset_m - normal * offset_m.dot(&normal);
            side_m = side_m.max(2.2 * along_m.norm());
        }
    }
    side_m
}

#[cfg(test)]
mod tests;
