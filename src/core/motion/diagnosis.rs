//! Likely mistakes in what is said of a performance, each with what corrects it.

use nalgebra::{UnitQuaternion, Vector3};

use super::index::{LinkIndex, TrackIndex};
use super::take::{SampleSource, Stamp};
use crate::math::Pose;

/// A likely mistake: with its remedy the performance has a motion that fits, without it none that
/// fits as well.
#[derive(Clone, Debug, PartialEq)]
pub struct Diagnosis {
    /// What corrects it.
    pub remedy: Remedy,
    /// Whether trackers say how the bodies move, or somebody who wrote keyframes of them.
    pub source: SampleSource,
    /// How far the motion is from the samples as things are said; `None` where there is no motion.
    pub without: Option<Distance>,
    /// How far with the remedy.
    pub with: Distance,
}

/// Root mean square distance of a motion from all samples.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Distance {
    /// Of the centres of mass \[m\].
    pub position_m: f64,
    /// Of the orientations \[rad\].
    pub orientation_rad: f64,
}

/// A change of what is said of a performance: of the scene, or of the meaning of its streams.
#[derive(Clone, Debug, PartialEq)]
pub enum Remedy {
    /// Another axis of the streams' world points up.
    Up {
        /// The axis.
        axis: SignedAxis,
        /// Gravity in the streams' axes [m/s²].
        gravity_m_s2: Vector3<f64>,
    },
    /// Gravity points elsewhere.
    Gravity {
        /// Gravity [m/s², world].
        gravity_m_s2: Vector3<f64>,
    },
    /// The streams' positions are not in metres.
    PositionUnit(LengthUnit),
    /// The scene's lengths are not in millimetres.
    SceneUnit(LengthUnit),
    /// Intervals of the stamps are so many times as long as those meant: 1000 where milliseconds
    /// were taken for seconds.
    StampUnit {
        /// Stamped over meant interval.
        factor: f64,
    },
    /// Stamps are numbers of frames, taken for seconds.
    FrameNumbers {
        /// Rate that makes the motion fall as fast as it should, or at the tempo of a usual
        /// performance [frames/s].
        rate_hz: f64,
    },
    /// Stamps are acted times, not physical ones.
    Tempo {
        /// Acted over physical duration.
        slowness: f64,
    },
    /// The tracker is mounted otherwise.
    Mount {
        /// The tracker.
        track: TrackIndex,
        /// Pose of its frame in its link's axes.
        link_from_tracker: Pose,
        /// How the pose was mistaken.
        slip: MountSlip,
    },
    /// The streams' quaternions mean something else.
    StreamQuaternions(QuaternionSlip),
    /// The quaternions of the scene's goals mean something else.
    GoalQuaternions(QuaternionSlip),
    /// A surface is higher, along its normal.
    Surface {
        /// Index into `Scene::surfaces`.
        surface: usize,
        /// By how much, along its normal [m, world].
        higher_m: Vector3<f64>,
        /// The point of the plane, moved so [m, world].
        point_m: Vector3<f64>,
    },
    /// A body hits a surface of which no event tells.
    MissedCollision {
        /// Where its event comes in `Scene::events`.
        index: usize,
        /// What hits.
        link: LinkIndex,
        /// What is hit (index into `Scene::surfaces`).
        surface: usize,
        /// When, on the clock of the samples.
        stamp: Stamp,
        /// When, in acted time \[s\].
        acted_s: f64,
    },
    /// Two bodies that hit each other are one from then on.
    StuckTogether {
        /// The collision.
        event: usize,
        /// What hits, and what is hit.
        links: [LinkIndex; 2],
    },
    /// The labels of a body's faces may be turned: then it rests as asked.
    FreeLabels {
        /// Index into `Scene::rest_goals`.
        goal: usize,
    },
    /// The streams' zero is elsewhere: surfaces, obstacles and goals are all higher.
    Origin {
        /// By how much [m, world].
        higher_m: Vector3<f64>,
    },
}

/// An axis of a frame, or its opposite.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SignedAxis {
    /// 0, 1 or 2.
    pub axis: usize,
    /// Whether it is the opposite.
    pub is_negative: bool,
}

/// A unit in which lengths are mistaken for metres or millimetres.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LengthUnit {
    /// 1 mm.
    Millimetre,
    /// 10 mm.
    Centimetre,
    /// 25.4 mm.
    Inch,
    /// 304.8 mm.
    Foot,
    /// 1000 mm.
    Metre,
}

/// How a mount was mistaken.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MountSlip {
    /// The offset has the wrong sign.
    Negated,
    /// It is the pose of the link in the tracker's frame.
    Inverted,
    /// The scene has no offset, but there is one.
    Missing,
    /// The offset is another.
    Offset,
    /// The components of the orientation are in another order.
    Quaternion,
    /// The tracker's axes are turned otherwise.
    Turned,
    /// They are, and the offset is another too.
    Elsewhere,
}

/// How a quaternion was mistaken.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum QuaternionSlip {
    /// Its real part is written first, where it is expected last.
    ScalarFirst,
    /// Its real part is written last, where it is expected first.
    ScalarLast,
    /// It is body from world, not world from body.
    Inverse,
}

impl Remedy {
    /// How many of its numbers are fitted to the performance.
    pub fn fitted(&self) -> usize {
        match self {
            Remedy::Mount { slip, .. } => {
                3 * (usize::from(slip.is_turned()) + usize::from(slip.is_fitted()))
            }
            Remedy::Origin { .. } => 3,
            Remedy::Surface { .. }
            | Remedy::Tempo { .. }
            | Remedy::FrameNumbers { .. }
            | Remedy::MissedCollision { .. } => 1,
            _ => 0,
        }
    }

    /// The remedy with a place moved [m, world; of a mount in its link's axes]; `None` where it has none.
    pub fn moved(&self, by_m: &Vector3<f64>) -> Option<Self> {
        let mut moved = self.clone();
        match &mut moved {
            Remedy::Surface {
                higher_m, point_m, ..
            } => {
                *point_m += by_m;
                *higher_m += by_m;
            }
            Remedy::Origin { higher_m } => *higher_m += by_m,
            Remedy::Mount {
                link_from_tracker, ..
            } => link_from_tracker.translation.vector += by_m,
            _ => return None,
        }
        Some(moved)
    }
}

impl SignedAxis {
    /// The axis along which a vector mostly points; `None` where it points along none.
    pub fn along(vector: &Vector3<f64>) -> Option<Self> {
        /// cos 30°.
        const LEAST_SHARE: f64 = 0.866;
        let axis = vector.iamax();
        let is_along = vector[axis].abs() > LEAST_SHARE * vector.norm();
        is_along.then_some(Self {
            axis,
            is_negative: vector[axis] < 0.0,
        })
    }

    /// As a unit vector.
    pub fn vector(self) -> Vector3<f64> {
        let mut vector = Vector3::zeros();
        vector[self.axis] = if self.is_negative { -1.0 } else { 1.0 };
        vector
    }

    /// The opposite.
    pub fn opposite(self) -> Self {
        Self {
            is_negative: !self.is_negative,
            ..self
        }
    }
}

impl MountSlip {
    /// Whether the turn was fitted to the performance.
    pub fn is_turned(self) -> bool {
        matches!(self, MountSlip::Turned | MountSlip::Elsewhere)
    }

    /// Whether the offset was fitted to the performance.
    pub fn is_fitted(self) -> bool {
        matches!(
            self,
            MountSlip::Missing | MountSlip::Offset | MountSlip::Elsewhere
        )
    }
}

impl LengthUnit {
    /// Its length \[m\].
    pub fn length_m(self) -> f64 {
        match self {
            LengthUnit::Millimetre => 1e-3,
            LengthUnit::Centimetre => 1e-2,
            LengthUnit::Inch => 0.0254,
            LengthUnit::Foot => 0.3048,
            LengthUnit::Metre => 1.0,
        }
    }
}

impl QuaternionSlip {
    /// What was meant.
    pub fn corrected(self, given: &UnitQuaternion<f64>) -> UnitQuaternion<f64> {
        let q = given.quaternion();
        let [w, x, y, z] = match self {
            QuaternionSlip::ScalarFirst => [q.i, q.j, q.k, q.w],
            QuaternionSlip::ScalarLast => [q.k, q.w, q.i, q.j],
            QuaternionSlip::Inverse => [q.w, -q.i, -q.j, -q.k],
        };
        UnitQuaternion::new_unchecked(nalgebra::Quaternion::new(w, x, y, z))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_slip_is_corrected() {
        let q = nalgebra::Quaternion::new(0.1, 0.5, -0.7, 0.5);
        let meant = UnitQuaternion::new_unchecked(q);
        // The writer's components, in the order in which they are written, where `x, y, z, w` is
        // read; and where `w, x, y, z` is read.
        let first = UnitQuaternion::new_unchecked(nalgebra::Quaternion::new(q.k, q.w, q.i, q.j));
        let last = UnitQuaternion::new_unchecked(nalgebra::Quaternion::new(q.i, q.j, q.k, q.w));
        assert_eq!(QuaternionSlip::ScalarFirst.corrected(&first), meant);
        assert_eq!(QuaternionSlip::ScalarLast.corrected(&last), meant);
        assert_eq!(QuaternionSlip::Inverse.corrected(&meant.inverse()), meant);
    }

    #[test]
    fn axes_have_signs() {
        let down = SignedAxis::along(&Vector3::new(0.3, -9.0, 0.2)).expect("along y");
        assert_eq!(down.vector(), -Vector3::y());
        assert_eq!(down.opposite().vector(), Vector3::y());
        assert_eq!(SignedAxis::along(&Vector3::new(1.0, 1.0, 0.0)), None);
    }
}
