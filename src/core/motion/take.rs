//! A take as trackers and performer delivered it: integer nanoseconds, tracker frames.

use super::index::TrackIndex;
use crate::math::Pose;

/// A point in time in integer nanoseconds, on the tracker's clock.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Stamp(pub i64);

impl Stamp {
    /// Seconds from `origin` to this stamp; exact to a nanosecond for takes under 104 days.
    pub fn seconds_since(self, origin: Stamp) -> f64 {
        (self.0 - origin.0) as f64 * 1e-9
    }

    /// The stamp so long after this one \[s\], to the nearest nanosecond.
    pub fn after(self, time_s: f64) -> Self {
        Self(self.0 + (1e9 * time_s).round() as i64)
    }
}

/// One reading of one tracker.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PoseSample {
    /// When it was measured (sensor time where there is one).
    pub stamp: Stamp,
    /// Position \[m\] as measured: possibly not finite.
    pub position_m: nalgebra::Vector3<f64>,
    /// Quaternion `[x, y, z, w]` as measured: possibly not unit, not finite, of either sign.
    pub quaternion_xyzw: [f64; 4],
    /// Which of them the message holds.
    pub holds: Holds,
    /// Covariance that came with it.
    pub covariance: Option<Covariance>,
    /// How far its true time may be from its stamp, where that is not known.
    pub open: Option<OpenTime>,
    /// Who says it.
    pub from: SampleSource,
}

/// Who says where a body is: of a keyframe no tracker can be mounted wrongly.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum SampleSource {
    /// A tracker on the body.
    #[default]
    Tracker,
    /// Somebody who wrote down the pose of the body itself.
    Keyframe,
}

/// How far the true time of a reading may be from its stamp, which then only says where among
/// others it is and where a search for its time begins.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct OpenTime {
    /// Before the stamp, at most \[ns\]; `None`: by anything.
    pub before_ns: Option<i64>,
    /// After the stamp, at most \[ns\]; `None`: by anything.
    pub after_ns: Option<i64>,
}

impl OpenTime {
    /// The least and the greatest that is to be added to the stamp \[s\].
    pub fn range_s(self) -> [f64; 2] {
        let seconds = |ns: Option<i64>| ns.map_or(f64::INFINITY, |ns| ns as f64 * 1e-9);
        [-seconds(self.before_ns), seconds(self.after_ns)]
    }
}

/// What a message of a tracker holds.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Holds {
    /// A pose.
    #[default]
    Pose,
    /// A position; the quaternion means nothing.
    Position,
    /// An orientation; the position means nothing.
    Orientation,
    /// A direction, in place of the position; the quaternion means nothing.
    Direction,
}

/// The covariance of a reading's position and of its orientation's rotation vector, both in world
/// axes \[m², m rad, rad²\]: the lower triangle, row by row. Single precision is more than any
/// tracker knows of its own errors.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Covariance(pub [f32; 21]);

impl Covariance {
    /// The lower triangle of a matrix given row by row.
    pub fn of_rows(rows: &[f64; 36]) -> Self {
        let mut entries = rows.chunks_exact(6).enumerate();
        let mut lower = entries.by_ref().flat_map(|(row, entries)| &entries[..=row]);
        Self(std::array::from_fn(|_| {
            *lower.next().expect("21 entries") as f32
        }))
    }

    /// The whole matrix.
    pub fn matrix(&self) -> nalgebra::Matrix6<f64> {
        nalgebra::Matrix6::from_fn(|row, column| {
            let (row, column) = (row.max(column), row.min(column));
            f64::from(self.0[row * (row + 1) / 2 + column])
        })
    }
}

impl PoseSample {
    /// A reading of a pose as measured.
    pub fn new(
        stamp: Stamp,
        position_m: nalgebra::Vector3<f64>,
        quaternion_xyzw: [f64; 4],
    ) -> Self {
        Self {
            stamp,
            position_m,
            quaternion_xyzw,
            holds: Holds::Pose,
            covariance: None,
            open: None,
            from: SampleSource::default(),
        }
    }

    /// A sample from a valid pose.
    pub fn from_pose(stamp: Stamp, world_from_tracker: &Pose) -> Self {
        let q = world_from_tracker.rotation.quaternion();
        Self::new(
            stamp,
            world_from_tracker.translation.vector,
            [q.i, q.j, q.k, q.w],
        )
    }
}

/// The performer's note that an event of the scene happens near this time.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Mark {
    /// When the mark was made, on the clock of the samples.
    pub stamp: Stamp,
    /// Name of the scene's event it stands for; `None`: the next one in order.
    pub event: Option<String>,
}

/// An event that a source delivers, in any order of stamps.
#[derive(Clone, Debug, PartialEq)]
pub enum TakeEvent {
    /// A tracker reading of a track.
    Pose {
        /// Of which of the scene's tracks.
        track: TrackIndex,
        /// Which of the track's streams it is on, from 0: see `Scene::streams`.
        stream: usize,
        /// The reading.
        sample: PoseSample,
    },
    /// The performer marked an event.
    Mark(Mark),
}

impl TakeEvent {
    /// When it was.
    pub fn stamp(&self) -> Stamp {
        match self {
            TakeEvent::Pose { sample, .. } => sample.stamp,
            TakeEvent::Mark(mark) => mark.stamp,
        }
    }

    /// The mark, if it is one.
    pub fn mark(&self) -> Option<&Mark> {
        match self {
            TakeEvent::Pose { .. } => None,
            TakeEvent::Mark(mark) => Some(mark),
        }
    }
}

/// The source of a live tracker's stamps.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum StampSource {
    /// The driver's own times on the system clock.
    Sample,
    /// The device's clock, mapped to this machine's.
    Device,
    /// The sequence numbers of a tracker that keeps this rate.
    Sequence {
        /// Readings per second.
        rate_hz: f64,
    },
    /// Arrivals of the readings, with the jitter filtered out.
    Receipt,
}

impl StampSource {
    /// Its name in scene files and reports.
    pub fn as_str(self) -> &'static str {
        match self {
            StampSource::Sample => "sample",
            StampSource::Device => "device",
            StampSource::Sequence { .. } => "sequence",
            StampSource::Receipt => "receipt",
        }
    }
}
