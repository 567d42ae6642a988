//! A motion for those who watch live: it is played in a loop, in real time, beside the
//! performance that it fits.
//!
//! Stamps are of the wall clock, for a live viewer draws what is now. Frames are those of an
//! estimate's file, and `<body>_live` where the tracker is. A body is drawn in its estimate's
//! frame, as a ghost in its sketch's, and as a paler one in its live frame.

use std::path::Path;

use super::drawing;
use super::error::WriteError;
use super::estimate::{DEFAULT_FRAME_RATE_HZ, DEFAULT_WORLD_FRAME};
use super::export::{ExportedBody, Key, glb};
use super::topics;
use typed_index_collections::TiSlice;

use crate::math::Pose;
use crate::motion::{LinkIndex, Mark, PoseSample, Scene, Stamp, TrackIndex};
use crate::report::{
    EstimateMessage, ExportProvenance, REPORT_SCHEMA, Reported, TIME_MAP_SCHEMA, TimeMapMessage,
    json,
};
use crate::sampling::{self, SampledMotion};
use crate::visual::patches;
use crate::wire::encode::{self, SchemaRecord};
use crate::wire::{Encoded, Transform};

/// What is said of what, in errors: there is no file.
const VIEWER: &str = "the viewer";

/// A topic that viewers are shown.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ShownTopic {
    /// Its name.
    pub topic: String,
    /// What its messages are.
    pub schema: SchemaRecord,
    /// How they are encoded.
    pub encoding: &'static str,
}

impl ShownTopic {
    /// A topic of protobuf messages.
    fn protobuf(topic: &str, kind: Encoded) -> Self {
        Self {
            topic: topic.to_owned(),
            schema: kind.schema(),
            encoding: "protobuf",
        }
    }

    fn json(topic: &str, name: &str, schema: &str) -> Self {
        let schema = SchemaRecord {
            name: name.to_owned(),
            encoding: "jsonschema".to_owned(),
            data: schema.as_bytes().to_vec(),
        };
        Self {
            topic: topic.to_owned(),
            schema,
            encoding: "json",
        }
    }

    /// Poses of one frame.
    pub fn poses(topic: &str) -> Self {
        Self::protobuf(topic, Encoded::PoseInFrame)
    }

    /// Marks.
    pub fn marks(topic: &str) -> Self {
        Self::protobuf(topic, Encoded::Event)
    }

    /// Transforms of all frames: [`topics::TRANSFORMS`].
    pub fn transforms() -> Self {
        Self::protobuf(topics::TRANSFORMS, Encoded::FrameTransforms)
    }

    /// What is drawn: [`topics::SCENE`].
    pub fn scene() -> Self {
        Self::protobuf(topics::SCENE, Encoded::SceneUpdate)
    }

    /// The whole estimate: [`topics::REPORT`].
    pub fn report() -> Self {
        Self::json(topics::REPORT, "enact.EstimateReport", REPORT_SCHEMA)
    }

    /// Acted time against physical time: [`topics::TIME_MAP`].
    pub fn time_map() -> Self {
        Self::json(topics::TIME_MAP, "enact.TimeMap", TIME_MAP_SCHEMA)
    }
}

/// An estimate that is played.
#[derive(Clone, Debug)]
pub struct Showing {
    motion: SampledMotion,
    from: Stamp,
    until: Stamp,
    /// The message of [`ShownTopic::report`].
    pub report: Vec<u8>,
    /// The message of [`ShownTopic::time_map`].
    pub time_map: Vec<u8>,
}

impl Showing {
    /// Samples the motion at [`DEFAULT_FRAME_RATE_HZ`]. Fails where it is too long for that.
    pub fn new(of: &Reported) -> Result<Self, WriteError> {
        let (scene, sketch, estimate) = (of.scene, of.sketch, of.estimate);
        let motion = SampledMotion::new(scene, sketch, estimate, None, DEFAULT_FRAME_RATE_HZ)
            .map_err(WriteError::sampling(Path::new(VIEWER)))?;
        let zero = motion.zero;
        let stamps = || motion.estimates.iter().flatten().map(|sample| sample.stamp);
        Ok(Self {
            from: stamps().min().unwrap_or(zero),
            until: stamps().max().unwrap_or(zero),
            report: json(&EstimateMessage::new(of, zero, None)),
            time_map: json(&TimeMapMessage::new(scene, sketch, estimate, zero)),
            motion,
        })
    }

    /// How long the motion lasts \[s\].
    pub fn duration_s(&self) -> f64 {
        self.until.seconds_since(self.from)
    }

    /// The motion as binary glTF, beside the performance; `None` where nothing moves.
    pub fn glb(&self, scene: &Scene, provenance: &ExportProvenance) -> Option<Vec<u8>> {
        let key = |sample: &PoseSample| Key {
            sample: *sample,
            event: None,
            is_exact: true,
        };
        let moving = scene.links.keys();
        let moving = moving.filter(|link| !self.motion.estimates[*link].is_empty());
        let bodies: Vec<ExportedBody> = moving
            .map(|link| ExportedBody {
                link,
                keys: self.motion.estimates[link].iter().map(key).collect(),
                acted: self.motion.sketches[link].iter().map(key).collect(),
            })
            .collect();
        let zero = self.motion.zero;
        let is_moving = !bodies.is_empty();
        is_moving.then(|| glb(scene, &bodies, zero, DEFAULT_FRAME_RATE_HZ, provenance))
    }

    /// Where a link's estimate and its performance are so long after the beginning, stamped
    /// `now`; none of a link without samples.
    pub fn at(&self, link: LinkIndex, time_s: f64, now: Stamp) -> [Option<PoseSample>; 2] {
        let stamp = sampling::stamp(self.from, time_s);
        let motion = &self.motion;
        [&motion.estimates[link], &motion.sketches[link]].map(|samples| {
            let after = samples.partition_point(|sample| sample.stamp <= stamp);
            let sample = samples.get(after.saturating_sub(1))?;
            Some(PoseSample {
                stamp: now,
                ..*sample
            })
        })
    }
}

/// The pose of the link whose tracker reads that, of the frame in which its scene gives it; `None` of numbers
/// that make no pose.
pub fn given_pose(scene: &Scene, track: TrackIndex, reading: &PoseSample) -> Option<PoseSample> {
    let [x, y, z, w] = reading.quaternion_xyzw;
    let quaternion = nalgebra::Quaternion::new(w, x, y, z);
    let is_pose = (quaternion.norm() - 1.0).abs() <= 0.01;
    if !is_pose || reading.position_m.iter().any(|x| !x.is_finite()) {
        return None;
    }
    let rotation = nalgebra::UnitQuaternion::from_quaternion(quaternion);
    let world_from_tracker = Pose::from_parts(reading.position_m.into(), rotation);
    let world_from_link = world_from_tracker * scene.tracks[track].link_from_tracker.inverse();
    let world_from_given = world_from_link * scene.link_seen_by(track).link_from_given;
    Some(PoseSample::from_pose(reading.stamp, &world_from_given))
}

/// Where a tracker is on its link, in the frame in which the scene gives the link.
pub fn tracker_mount(scene: &Scene, track: TrackIndex) -> PoseSample {
    let link_from_tracker = scene.tracks[track].link_from_tracker;
    let given_from_link = scene.link_seen_by(track).link_from_given.inverse();
    PoseSample::from_pose(Stamp(0), &(given_from_link * link_from_tracker))
}

/// The message of [`ShownTopic::poses`].
pub fn pose(sample: &PoseSample) -> Option<Vec<u8>> {
    encode::pose_in_frame(DEFAULT_WORLD_FRAME, sample).ok()
}

/// The message of [`ShownTopic::marks`].
pub fn mark(mark: &Mark) -> Option<Vec<u8>> {
    encode::event(mark).ok()
}

/// The message of [`ShownTopic::transforms`]: frames and where they are in the world's.
pub fn transforms(frames: &[(String, PoseSample)]) -> Option<Vec<u8>> {
    let transforms: Vec<Transform> = frames
        .iter()
        .map(|(child, sample)| Transform {
            parent: DEFAULT_WORLD_FRAME,
            child,
            sample: *sample,
        })
        .collect();
    encode::frame_transforms(&transforms).ok()
}

/// The message of [`ShownTopic::scene`].
pub fn scene(scene: &Scene, now: Stamp) -> Option<Vec<u8>> {
    let patches = patches(scene, TiSlice::from_ref(&[]));
    drawing::live_scene_update(scene, DEFAULT_WORLD_FRAME, now, &patches).ok()
}

#[cfg(test)]
mod tests {
    use nalgebra::Vector3;

    use super::*;
    use crate::fixture;
    use crate::motion::SampleCounts;

    #[test]
    fn a_motion_is_played_from_its_beginning_to_its_end_and_stands_there() {
        let (scene, sketch, estimate) = (fixture::scene(), fixture::sketch(), fixture::estimate());
        let showing = Showing::new(&Reported {
            scene: &scene,
            inferred: &[],
            sketch: &sketch,
            counts: &SampleCounts::default(),
            estimate: &estimate,
            verification: None,
            settled: None,
            diagnoses: &[],
            seen: &[],
            freed: &[],
            rest: None,
        })
        .expect("a motion");
        let now = Stamp(7);
        let at = |time_s: f64| showing.at(LinkIndex(0), time_s, now)[0].expect("a pose");
        let duration_s = showing.duration_s();
        assert!(duration_s > 0.0);
        assert_eq!(at(0.0).stamp, now);
        let distance_m = (at(duration_s).position_m - at(0.0).position_m).norm();
        assert!(distance_m > 0.0);
        assert_eq!(at(duration_s + 0.4), at(duration_s));
        // The ghost is never ahead of its last sample.
        assert!(showing.at(LinkIndex(0), duration_s, now)[1].is_some());
    }

    #[test]
    fn a_tracker_that_sits_off_the_centre_is_moved_there_and_nonsense_is_not_shown() {
        let mut scene = fixture::scene();
        let track = &mut scene.tracks[TrackIndex(0)];
        track.link_from_tracker = Pose::translation(0.0, 0.0, 0.1);
        let reading = PoseSample::new(Stamp(1), Vector3::new(1.0, 2.0, 3.0), [1.0, 0.0, 0.0, 0.0]);
        // Upside down, the tracker's z is the world's −z.
        let (scene, track) = (&scene, TrackIndex(0));
        let pose = given_pose(scene, track, &reading).expect("a pose");
        assert!((pose.position_m - Vector3::new(1.0, 2.0, 3.1)).norm() < 1e-12);
        for (position_m, quaternion_xyzw) in [
            (Vector3::repeat(f64::NAN), [0.0, 0.0, 0.0, 1.0]),
            (Vector3::zeros(), [0.0; 4]),
            (Vector3::zeros(), [f64::NAN; 4]),
        ] {
            let wrong = PoseSample::new(Stamp(1), position_m, quaternion_xyzw);
            assert_eq!(given_pose(scene, track, &wrong), None);
        }
    }
}
