//! What the poses in a recording are like, topic by topic, whatever scene reads them.

use std::collections::{BTreeMap, BTreeSet};

use super::path::PathSeen;
use super::recording::Recording;
use crate::motion::{Holds, Stamp};
use crate::wire::{FramedPose, PoseFormat};

/// The poses of one child on one topic.
#[derive(Clone, Debug, PartialEq)]
pub struct PoseExtent {
    /// The topic.
    pub topic: String,
    /// The child frame, or the index in an array of poses; empty where messages hold one without a name.
    pub child: String,
    /// Frames in which they are given.
    pub frames: BTreeSet<String>,
    /// How many.
    pub count: u64,
    /// Least and greatest coordinate of each axis \[m\]; `None` where no position is held.
    pub extent_m: Option<[[f64; 2]; 3]>,
    /// Least and greatest norm of the quaternions, as sent; `None` where none is held.
    pub norms: Option<[f64; 2]>,
    /// Poses with a number that is not finite; they count for nothing else.
    pub not_finite: u64,
    /// Whether they seem to be of two publishers, in words.
    pub mixed: Option<String>,
}

impl Recording {
    /// The poses of every topic that has some, by topic and child. Messages that cannot be decoded are left
    /// out: a take counts them.
    pub fn poses(&self) -> Vec<PoseExtent> {
        let container = self.container();
        let formats: BTreeMap<u16, PoseFormat> = container
            .channels()
            .iter()
            .filter_map(|(id, channel)| {
                let schema = container.schema_of(channel)?;
                Some((
                    *id,
                    PoseFormat::of(&schema.name, &channel.message_encoding)?,
                ))
            })
            .collect();
        let mut found: BTreeMap<(u16, String), PoseExtent> = BTreeMap::new();
        // Several channels may have one topic.
        let mut paths: BTreeMap<(&str, String), PathSeen> = BTreeMap::new();
        let mut poses: Vec<FramedPose> = Vec::new();
        let mut walk = container.walk();
        while let Some(message) = walk.next_message() {
            let Some(format) = formats.get(&message.channel_id) else {
                continue;
            };
            poses.clear();
            if format.decode(message.data, &mut poses).is_err() {
                continue;
            }
            let topic = container.channels()[&message.channel_id].topic.as_str();
            for pose in &poses {
                let path = paths.entry((topic, pose.child.clone())).or_default();
                path.note(&pose.sample(Stamp(0)));
                let key = (message.channel_id, pose.child.clone());
                let of = found.entry(key).or_insert_with(|| PoseExtent {
                    topic: topic.to_owned(),
                    child: pose.child.clone(),
                    frames: BTreeSet::new(),
                    count: 0,
                    extent_m: None,
                    norms: None,
                    not_finite: 0,
                    mixed: None,
                });
                of.add(pose);
            }
        }
        for of in found.values_mut() {
            let path = paths.remove(&(of.topic.as_str(), of.child.clone()));
            of.mixed = path.and_then(|path| path.mixed(&of.topic));
        }
        let mut all: Vec<PoseExtent> = found.into_values().collect();
        all.sort_by(|a, b| (&a.topic, &a.child).cmp(&(&b.topic, &b.child)));
        all
    }
}

impl PoseExtent {
    fn add(&mut self, pose: &FramedPose) {
        self.count += 1;
        if !self.frames.contains(&pose.parent) {
            self.frames.insert(pose.parent.clone());
        }
        let norm = pose.quaternion_xyzw.iter().map(|part| part * part);
        let norm = norm.sum::<f64>().sqrt();
        if !(pose.position_m.iter().all(|of| of.is_finite()) && norm.is_finite()) {
            self.not_finite += 1;
            return;
        }
        if matches!(pose.holds, Holds::Pose | Holds::Position) {
            let none = [[f64::INFINITY, f64::NEG_INFINITY]; 3];
            let extent = self.extent_m.get_or_insert(none);
            for (of, at) in extent.iter_mut().zip(pose.position_m.iter()) {
                *of = [of[0].min(*at), of[1].max(*at)];
            }
        }
        if matches!(pose.holds, Holds::Pose | Holds::Orientation) {
            let norms = self.norms.get_or_insert([f64::INFINITY, f64::NEG_INFINITY]);
            *norms = [norms[0].min(norm), norms[1].max(norm)];
        }
    }
}
