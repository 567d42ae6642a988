//! What came in and the estimated motion beside it, in one MCAP file.

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;

use super::atomic::AtomicFile;
use super::dialect::{self, Dialect, Format};
use super::error::WriteError;
use super::merge::{self, Additions, OurChannel, OurMessage};
use super::skeleton::Skeleton;
use super::{topics, trails, urdf};
use crate::motion::{LinkIndex, PoseSample, Stamp};
use crate::report::{
    DEVIATION_SCHEMA, DeviationMessage, EstimateMessage, Provenance, REPORT_SCHEMA, Reported,
    TIME_MAP_SCHEMA, TimeMapMessage, json,
};
use crate::sampling::{self, SampledMotion};
use crate::visual::patches;
use crate::wire::ros2;
use crate::wire::{Container, JointState, Transform};

/// Frames per second of the motion, unless the user wants others.
pub const DEFAULT_FRAME_RATE_HZ: f64 = 240.0;

/// The world's frame, where the recording does not name it.
pub const DEFAULT_WORLD_FRAME: &str = "world";

/// Attachment that holds the scene.
pub(super) const SCENE_NAME: &str = "scene.toml";

/// Attachment that holds the scene of the estimate where the recording has another one.
pub(super) const ESTIMATE_SCENE_NAME: &str = "estimate_scene.toml";

/// Everything an output file is made of.
#[derive(Clone, Copy)]
pub struct EstimateFile<'a> {
    /// What came in.
    pub input: &'a Container,
    /// The files that it is made of: none is replaced, and nobody may read it who may not read them.
    pub made_of: &'a [&'a Path],
    /// The estimate and what belongs to it.
    pub of: Reported<'a>,
    /// Its scene as text.
    pub scene_toml: &'a [u8],
    /// From what it is made, to be noted in the file.
    pub provenance: Option<&'a Provenance>,
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
    if file.made_of.iter().any(|of| is_same(path, of)) {
        return Err(WriteError::IsInput {
            path: path.to_owned(),
        });
    }
    let Reported {
        scene,
        sketch,
        estimate,
        settled,
        ..
    } = file.of;
    let motion = SampledMotion::new(scene, sketch, estimate, settled, file.frame_rate_hz)
        .map_err(WriteError::sampling(path))?;
    let additions = Composer::new(path, file, &motion).compose()?;
    let added = additions.messages.len() as u64;
    let copied = merge::write(
        AtomicFile::create_of(path, file.made_of)?,
        file.input,
        Some(ESTIMATE_SCENE_NAME),
        additions,
    )?;
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
    motion: &'a SampledMotion,
    additions: Additions,
}

impl<'a> Composer<'a> {
    fn new(path: &'a Path, file: &'a EstimateFile<'a>, motion: &'a SampledMotion) -> Self {
        Self {
            path,
            file,
            dialect: Dialect::of(file.input),
            motion,
            additions: Additions::default(),
        }
    }

    fn compose(mut self) -> Result<Additions, WriteError> {
        for (index, link) in self.file.of.scene.links.iter_enumerated() {
            let (topic, samples) = (topics::estimate_pose(&link.name), &self.motion.estimates);
            self.add_poses(&topic, &samples[index])?;
            self.add_deviations(index);
            let (topic, samples) = (topics::sketch_pose(&link.name), &self.motion.sketches);
            self.add_poses(&topic, &samples[index])?;
        }
        self.add_transforms()?;
        self.add_joints()?;
        self.add_drawings()?;
        self.add_events()?;
        self.add_reports();
        self.add_scene();
        Ok(self.additions)
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

    fn add_deviations(&mut self, link: LinkIndex) {
        let Reported {
            scene, estimate, ..
        } = self.file.of;
        let poses = &self.motion.estimates[link];
        let samples = sampling::deviation_frames(scene, estimate, link, poses, self.motion.zero);
        if samples.is_empty() {
            return;
        }
        let topic = topics::estimate_deviation(&scene.links[link].name);
        let format = self.dialect.json("enact.Deviation", DEVIATION_SCHEMA);
        let channel = self.channel(&topic, format);
        for sample in samples {
            let message = DeviationMessage::new(sample.stamp, &sample.deviation);
            self.push(channel, sample.stamp, self.dialect.json_of(json(&message)));
        }
    }

    /// One message per instant, of all frames that have a pose there.
    fn add_transforms(&mut self) -> Result<(), WriteError> {
        let channel = self.channel(topics::TRANSFORMS, self.dialect.transforms());
        let (world_frame, bodies) = (self.file.world_frame, &self.file.of.scene.links);
        let skeleton = Skeleton::new(self.file.of.scene, world_frame);
        let moved = skeleton.moved(self.motion);
        let estimates = moved
            .iter()
            .map(|of| ((of.parent, of.child), of.samples.as_slice()));
        let sketches = bodies.iter().map(|body| topics::sketch_frame(&body.name));
        let sketches: Vec<String> = sketches.collect();
        let sketches = sketches.iter().zip(&self.motion.sketches);
        let sketches =
            sketches.map(|(child, samples)| ((world_frame, child.as_str()), samples.as_slice()));
        let mut instants: BTreeMap<Stamp, Vec<Transform>> = BTreeMap::new();
        for ((parent, child), samples) in estimates.chain(sketches) {
            for &sample in samples {
                instants.entry(sample.stamp).or_default().push(Transform {
                    parent,
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

    /// The joints of each tree, a message per frame.
    fn add_joints(&mut self) -> Result<(), WriteError> {
        let skeleton = Skeleton::new(self.file.of.scene, self.file.world_frame);
        let trees = self.motion.joints.iter();
        let trees = trees.map(|of| (skeleton.hinges_of(of.mechanism), &of.samples));
        let trees: Vec<_> = trees.filter(|(names, _)| !names.is_empty()).collect();
        if trees.is_empty() {
            return Ok(());
        }
        let topic = self.dialect.joints_topic();
        let channel = self.channel(topic, self.dialect.joints());
        for (names, samples) in trees {
            for sample in samples {
                let joints = names.iter().enumerate().map(|(place, &name)| JointState {
                    name,
                    angle_rad: sample.angles_rad[place],
                    rate_rad_s: sample.rates_rad_s.as_ref().map(|rates| rates[place]),
                });
                let joints: Vec<JointState> = joints.collect();
                let data = self
                    .dialect
                    .joints_of(sample.stamp, &joints)
                    .map_err(WriteError::encode(self.path, topic))?;
                self.push(channel, sample.stamp, data);
            }
        }
        Ok(())
    }

    fn add_drawings(&mut self) -> Result<(), WriteError> {
        let (scene, world_frame) = (self.file.of.scene, self.file.world_frame);
        let patches = patches(scene, &self.motion.estimates);
        if let Some(format) = self.dialect.drawings() {
            let channel = self.channel(topics::SCENE, format);
            let estimate = self.file.of.estimate;
            let data = trails::scene_update(
                self.path,
                scene,
                estimate,
                self.motion,
                world_frame,
                &patches,
            )?;
            self.push(channel, self.motion.zero, data);
        }
        let acted = self.motion.sketches.iter_enumerated();
        let acted = acted.filter(|(_, samples)| !samples.is_empty());
        let acted: Vec<LinkIndex> = acted.map(|(link, _)| link).collect();
        let channel = self.channel(topics::ROBOT_DESCRIPTION, dialect::text());
        let data = ros2::string(&urdf::robot(scene, world_frame, &patches, &acted));
        self.push(channel, self.motion.zero, data);
        Ok(())
    }

    fn add_events(&mut self) -> Result<(), WriteError> {
        let channel = self.channel(topics::EVENTS, self.dialect.events());
        let events = self.file.of.estimate.events.iter().map(|estimate| {
            let event = &self.file.of.scene.events[estimate.event];
            (estimate.time_s, event.name.as_str(), event.kind.as_str())
        });
        let settled = self.file.of.settled.iter();
        let simulated = settled.map(|s| match s.is_predicted {
            true => (s.from_s, "predicted from here", "prediction"),
            false => (s.from_s, "simulated from here", "simulation"),
        });
        for (time_s, name, kind) in events.chain(simulated) {
            let stamp = sampling::stamp(self.motion.zero, time_s);
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
        let time_map = TimeMapMessage::new(scene, sketch, estimate, self.motion.zero);
        let report = EstimateMessage::new(&self.file.of, self.motion.zero, self.file.provenance);
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
            self.push(channel, self.motion.zero, self.dialect.json_of(data));
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
                format!("{}{topic}", topics::DISPUTED)
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

#[cfg(test)]
mod tests;
