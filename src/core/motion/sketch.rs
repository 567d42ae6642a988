//! The performance as the estimator sees it: cleaned, in body axes, cut at the marks.

use std::collections::BTreeMap;
use std::ops::Range;

use nalgebra::{Matrix6, UnitQuaternion, UnitVector3, Vector3};
use typed_index_collections::TiVec;

use super::held::HeldMotion;
use super::index::{MechanismIndex, TrackIndex};
use super::scene::{EventKind, Scene};
use super::take::Stamp;

/// One acted sample of a link.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sample {
    /// When the tracker measured it.
    pub stamp: Stamp,
    /// Acted time [s since [`Sketch::origin`]].
    pub acted_s: f64,
    /// What it shows.
    pub seen: Seen,
}

/// What one sample shows of a link: a function of its state (the projection `p_i` of paper eq. 1).
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Seen {
    /// The pose of its axes.
    Pose {
        /// Centre of mass [m, world].
        position_m: Vector3<f64>,
        /// World from body; signs are continuous along a stream.
        orientation: UnitQuaternion<f64>,
    },
    /// The place of the point on which the tracker is mounted ([`Track::point_m`]) [m, world].
    ///
    /// [`Track::point_m`]: super::scene::Track::point_m
    Point(Vector3<f64>),
    /// The orientation of its axes, world from body; signs are continuous along a stream.
    Orientation(UnitQuaternion<f64>),
    /// The direction of one of its axes ([`Sees::Direction`](super::scene::Sees::Direction))
    /// \[world\].
    Direction(UnitVector3<f64>),
}

impl Sample {
    /// A sample that shows a pose.
    pub fn of_pose(
        stamp: Stamp,
        acted_s: f64,
        position_m: Vector3<f64>,
        orientation: UnitQuaternion<f64>,
    ) -> Self {
        Self {
            stamp,
            acted_s,
            seen: Seen::Pose {
                position_m,
                orientation,
            },
        }
    }
}

impl Seen {
    /// The centre of mass, or the point that is seen instead [m, world].
    pub fn position_m(&self) -> Option<Vector3<f64>> {
        match self {
            Seen::Pose { position_m, .. } | Seen::Point(position_m) => Some(*position_m),
            Seen::Orientation(_) | Seen::Direction(_) => None,
        }
    }

    /// World from body.
    pub fn orientation(&self) -> Option<UnitQuaternion<f64>> {
        match self {
            Seen::Pose { orientation, .. } | Seen::Orientation(orientation) => Some(*orientation),
            Seen::Point(_) | Seen::Direction(_) => None,
        }
    }
}

/// The samples of one track, strictly increasing in time.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct TrackSketch {
    /// Samples in order of time.
    pub samples: Vec<Sample>,
    /// Where the messages say how good they are, for every sample the covariance of the tracker's
    /// position and of its orientation's rotation vector, both in world axes \[m², m rad, rad²\];
    /// empty otherwise.
    pub covariances: Vec<Matrix6<f64>>,
    /// Of samples whose times are not known, by their index: the least and the greatest that is to
    /// be added to `acted_s` \[s\].
    pub open_times_s: BTreeMap<usize, [f64; 2]>,
    /// Whether somebody wrote them as keyframes.
    pub are_written: bool,
    /// The motion that they show of a body in the hand.
    pub held: Option<HeldMotion>,
    /// The motions that they show of what is in a hand for a while.
    pub grips: Vec<Grip>,
}

/// The motion of a body in a hand in one of its phases.
#[derive(Clone, Debug, PartialEq)]
pub struct Grip {
    /// Index into `Scene::phases`.
    pub phase: usize,
    /// How the tracker moves.
    pub motion: HeldMotion,
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
    /// How long contacts last in the stream, by their event \[s\]: samples meanwhile are of neither side. Others are one moment.
    pub contacts_s: BTreeMap<usize, f64>,
    /// How uncertain it is where the stream is cut as a hand lets go of a body or takes it, by the event \[s\].
    pub cuts_sd_s: BTreeMap<usize, f64>,
}

impl TrackSketch {
    /// Samples without covariances.
    pub fn new(samples: Vec<Sample>) -> Self {
        Self {
            samples,
            covariances: Vec::new(),
            open_times_s: BTreeMap::new(),
            are_written: false,
            held: None,
            grips: Vec::new(),
        }
    }

    /// All motions that they show of what is in a hand.
    pub fn motions(&self) -> impl Iterator<Item = &HeldMotion> {
        self.held
            .iter()
            .chain(self.grips.iter().map(|of| &of.motion))
    }

    /// The same, to be changed.
    pub fn motions_mut(&mut self) -> impl Iterator<Item = &mut HeldMotion> {
        let grips = self.grips.iter_mut().map(|of| &mut of.motion);
        self.held.iter_mut().chain(grips)
    }
}

impl Sketch {
    /// Acted time at which what touches at an event comes off, where the stream is cut [s since `origin`].
    pub fn left_s(&self, event: usize) -> f64 {
        self.marks_s[event] + self.contacts_s.get(&event).unwrap_or(&0.0)
    }

    /// How a tracker moves that shows what is in a hand in a phase (index into `Scene::phases`).
    pub fn grip(&self, phase: usize) -> Option<&HeldMotion> {
        let mut grips = self.tracks.iter().flat_map(|track| &track.grips);
        Some(&grips.find(|grip| grip.phase == phase)?.motion)
    }

    /// Stamps at which the motion of a scene with joined bodies begins and ends \[s\]: the events, or the first and the
    /// last sample.
    pub fn whole_span_s(&self, scene: &Scene) -> [f64; 2] {
        let samples = || self.tracks.iter().flat_map(|track| &track.samples);
        let first_s = samples()
            .map(|sample| sample.acted_s)
            .fold(f64::INFINITY, f64::min);
        let last_s = samples()
            .map(|sample| sample.acted_s)
            .fold(f64::NEG_INFINITY, f64::max);
        let mark_s = |kind: EventKind| {
            let event = scene.events.iter().position(|event| event.kind == kind)?;
            Some(self.marks_s[event])
        };
        [
            mark_s(EventKind::Start).unwrap_or(first_s),
            mark_s(EventKind::End).unwrap_or(last_s),
        ]
    }

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
                match &mut sample.seen {
                    Seen::Pose {
                        position_m,
                        orientation,
                    } => {
                        *position_m += *orientation * old_from_new.translation.vector;
                        *orientation *= old_from_new.rotation;
                    }
                    Seen::Orientation(orientation) => *orientation *= old_from_new.rotation,
                    // These are what the tracker itself saw.
                    Seen::Point(_) | Seen::Direction(_) => {}
                }
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

impl MarkTime {
    /// Standard deviation with which it counts \[s\].
    pub fn counted_sd_s(&self) -> f64 {
        self.sd_s / self.counted.sqrt()
    }
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
    /// What was seen of it, one per track of the mechanism.
    pub views: Vec<View>,
}

/// What one track saw of a flight.
#[derive(Clone, Debug, PartialEq)]
pub struct View {
    /// What saw it.
    pub track: TrackIndex,
    /// The track's samples that lie in the flight, those near a collision left out.
    pub samples: Range<usize>,
}

impl Segment {
    /// The events that begin and end it.
    pub fn ends(&self) -> [Option<usize>; 2] {
        [self.start_event, self.end_event]
    }

    /// Number of samples of all its tracks.
    pub fn sample_count(&self) -> usize {
        self.views.iter().map(|view| view.samples.len()).sum()
    }
}

/// Why a sample was not used.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum DropReason {
    /// A coordinate or a component is NaN or infinite.
    NotFinite,
    /// The quaternion's norm is off 1 by more than a tenth.
    NotUnit,
    /// Its message holds nothing of what its track sees.
    NotSeen,
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
    /// What is wrong with such samples, after their number in a sentence.
    pub fn said(self) -> &'static str {
        match self {
            DropReason::NotFinite => "with a number that is not finite",
            DropReason::NotUnit => {
                "with a quaternion whose norm is off 1 by more than a tenth (is another column among its four numbers?)"
            }
            DropReason::NotSeen => {
                "without what the track sees (`sees` of a [[body.track]] says what)"
            }
            DropReason::Duplicate => "with the stamp of another",
            DropReason::Frozen => "with the very pose before them",
            DropReason::Outlier => "far from their neighbours",
            DropReason::BeforeStart => "before the mark of the start",
            DropReason::AfterEnd => "after the mark of the end",
            DropReason::NearCollision => "too near a collision",
        }
    }

    /// Its name in reports.
    pub fn as_str(self) -> &'static str {
        match self {
            DropReason::NotFinite => "not_finite",
            DropReason::NotUnit => "not_unit",
            DropReason::NotSeen => "not_seen",
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
    /// Quaternions within a tenth of unit norm that were normalised.
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
    /// The samples of a view.
    pub fn samples_of(&self, view: &View) -> &[Sample] {
        &self.tracks[view.track].samples[view.samples.clone()]
    }

    /// The samples of a segment, one view after the other.
    pub fn samples_in<'s>(&'s self, segment: &'s Segment) -> impl Iterator<Item = &'s Sample> {
        segment.views.iter().flat_map(|view| self.samples_of(view))
    }

    /// Acted times of the first and the last sample of a segment \[s\].
    pub fn span_s(&self, segment: &Segment) -> Option<[f64; 2]> {
        let ends = segment.views.iter().filter_map(|view| {
            let samples = self.samples_of(view);
            Some([samples.first()?.acted_s, samples.last()?.acted_s])
        });
        ends.reduce(|a, b| [a[0].min(b[0]), a[1].max(b[1])])
    }
}

impl SampleCounts {
    /// Counts one more sample dropped.
    pub fn drop(&mut self, reason: DropReason, count: usize) {
        if count > 0 {
            *self.dropped.entry(reason).or_default() += count;
        }
    }

    /// Adds what of another part of the same take was used or left out, beyond what both began with.
    pub fn add_beyond(&mut self, other: &Self, begun: &Self) {
        self.used += other.used;
        for (reason, count) in &other.dropped {
            let before = begun.dropped.get(reason).copied().unwrap_or(0);
            self.drop(*reason, count - before);
        }
        let moved = other.marks.moved.iter();
        self.marks
            .moved
            .extend(moved.filter(|of| !begun.marks.moved.contains(of)));
        self.marks.moved.sort_unstable();
    }
}
