//! The performance as the estimator sees it: cleaned, in body axes, cut at the marks.

use std::collections::BTreeMap;
use std::ops::Range;

use nalgebra::{UnitQuaternion, Vector3};
use typed_index_collections::TiVec;

use super::held::HeldMotion;
use super::index::{MechanismIndex, TrackIndex};
use super::scene::Scene;
use super::take::Stamp;

/// One acted pose of a link.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sample {
    /// When the tracker measured it.
    pub stamp: Stamp,
    /// Acted time [s since [`Sketch::origin`]].
    pub acted_s: f64,
    /// Centre of mass [m, world].
    pub position_m: Vector3<f64>,
    /// World from body; signs are continuous along a stream.
    pub orientation: UnitQuaternion<f64>,
}

/// The samples of one track, strictly increasing in time.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct TrackSketch {
    /// Samples in order of time.
    pub samples: Vec<Sample>,
    /// The motion that they show of a body in the hand.
    pub held: Option<HeldMotion>,
}

/// A whole performance.
#[derive(Clone, Debug, PartialEq)]
pub struct Sketch {
    /// Zero of `acted_s`.
    pub origin: Stamp,
    /// One per track of the scene.
    pub tracks: TiVec<TrackIndex, TrackSketch>,
    /// Acted time of each of the scene's events, where the stream is cut [s since `origin`].
    pub marks_s: Vec<f64>,
    /// The performer's mark of each event; `None` for an unmarked one.
    pub marks: Vec<Option<MarkTime>>,
}

impl Sketch {
    /// The performance as another scene sees it, in which trackers are mounted otherwise than in
    /// the one of which this is the sketch.
    pub fn seen_in(mut self, of: &Scene, other: &Scene) -> Self {
        for (track, sketch) in self.tracks.iter_mut_enumerated() {
            let [old, new] = [of, other].map(|scene| scene.tracks[track].link_from_tracker);
            if old == new {
                continue;
            }
            let old_from_new = old * new.inverse();
            for sample in &mut sketch.samples {
                let shift = sample.orientation * old_from_new.translation.vector;
                sample.position_m += shift;
                sample.orientation *= old_from_new.rotation;
            }
        }
        self
    }
}

/// A mark as a measurement of its event's acted time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MarkTime {
    /// Acted time of the mark [s since [`Sketch::origin`]].
    pub acted_s: f64,
    /// Its standard deviation, in acted time \[s\].
    pub sd_s: f64,
    /// How often it counts in the objective, where samples count once; one until flights are
    /// fitted.
    pub counted: f64,
}

/// Collision-free flight of one mechanism between two of its events.
#[derive(Clone, Debug, PartialEq)]
pub struct Segment {
    /// What flies.
    pub mechanism: MechanismIndex,
    /// Event that begins it, if any (index into `Scene::events`).
    pub start_event: Option<usize>,
    /// Event that ends it, if any.
    pub end_event: Option<usize>,
    /// What saw it.
    pub track: TrackIndex,
    /// The track's samples that lie in it, those near a collision left out.
    pub samples: Range<usize>,
}

/// Why a sample was not used.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum DropReason {
    /// A coordinate or a component is NaN or infinite.
    NotFinite,
    /// The quaternion's norm is off 1 by more than 1 %.
    NotUnit,
    /// Same stamp as another sample of the track.
    Duplicate,
    /// Bit for bit the pose before it: the tracker stood still or lost sight.
    Frozen,
    /// Further from its neighbours than the stream and any motion explain.
    Outlier,
    /// Before the start.
    BeforeStart,
    /// After the end.
    AfterEnd,
    /// Within the window about a collision in which a sample may belong to either side.
    NearCollision,
}

impl DropReason {
    /// Its name in reports.
    pub fn as_str(self) -> &'static str {
        match self {
            DropReason::NotFinite => "not_finite",
            DropReason::NotUnit => "not_unit",
            DropReason::Duplicate => "duplicate",
            DropReason::Frozen => "frozen",
            DropReason::Outlier => "outlier",
            DropReason::BeforeStart => "before_start",
            DropReason::AfterEnd => "after_end",
            DropReason::NearCollision => "near_collision",
        }
    }
}

/// Counts of the samples.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SampleCounts {
    /// Samples delivered.
    pub read: usize,
    /// Samples in the objective.
    pub used: usize,
    /// Samples left out, by reason.
    pub dropped: BTreeMap<DropReason, usize>,
    /// Samples that arrived after one with a later stamp, and were sorted in.
    pub reordered: usize,
    /// Quaternions within 1 % of unit norm that were normalised.
    pub normalised: usize,
    /// Quaternions whose sign was flipped for continuity.
    pub flipped: usize,
    /// Intervals longer than 2.5 times the median one.
    pub gaps: usize,
    /// Changes of the performer's marks.
    pub marks: MarkChanges,
}

/// Marks that are not those that the performer made. Events are indices into `Scene::events`.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct MarkChanges {
    /// Events without a mark, placed where the stream suggests, or at its first or last sample.
    pub proposed: Vec<usize>,
    /// Events whose mark was far from any kink of the stream and was moved to one.
    pub moved: Vec<usize>,
    /// Starts and ends whose mark was before the first sample or after the last and was moved
    /// there.
    pub late: Vec<usize>,
    /// Marks that stand for no event.
    pub ignored: usize,
}

impl Sketch {
    /// The samples of a segment.
    pub fn samples_of(&self, segment: &Segment) -> &[Sample] {
        &self.tracks[segment.track].samples[segment.samples.clone()]
    }
}

impl SampleCounts {
    /// Counts one more sample dropped.
    pub fn drop(&mut self, reason: DropReason, count: usize) {
        if count > 0 {
            *self.dropped.entry(reason).or_default() += count;
        }
    }
}
