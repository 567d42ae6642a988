//! What readings show of a link.
//!
//! Which part of a reading counts depends on its message ([`Holds`]) and on what its track sees
//! ([`Sees`]). The part that does not count is set to something constant, so that checks of whole
//! readings pass over it.

use nalgebra::{Matrix6, Quaternion, Translation3, UnitQuaternion, UnitVector3, Vector3};

use super::reading::Reading;
use crate::math::{Pose, so3};
use crate::motion::{Covariance, Holds, Seen, Sees, TakeEvent, Track, Weighing};

/// Leaves of a reading only what its track sees; `false` where the message holds nothing of it.
pub(super) fn show(track: &Track, reading: &mut Reading) -> bool {
    let (no_place, no_turn) = (Vector3::zeros(), [0.0, 0.0, 0.0, 1.0]);
    let shown = match (track.sees, reading.holds) {
        (Sees::Pose, holds @ (Holds::Pose | Holds::Position | Holds::Orientation)) => holds,
        (Sees::Point, Holds::Pose | Holds::Position) => Holds::Position,
        (Sees::Orientation, Holds::Pose | Holds::Orientation) => Holds::Orientation,
        (Sees::Direction(_), Holds::Pose | Holds::Orientation | Holds::Direction) => {
            Holds::Direction
        }
        _ => return false,
    };
    match shown {
        Holds::Pose => {}
        Holds::Position => reading.quaternion_xyzw = no_turn,
        Holds::Orientation => reading.position_m = no_place,
        Holds::Direction => {
            let direction = match (track.sees, reading.holds) {
                (_, Holds::Direction) => reading.position_m,
                (Sees::Direction(axis), _) => {
                    let [x, y, z, w] = reading.quaternion_xyzw;
                    let tracker_from_link = track.link_from_tracker.rotation.inverse();
                    // A quaternion that is none shows in the norm.
                    Quaternion::new(w, x, y, z).norm()
                        * (rotation(reading) * (tracker_from_link * axis.into_inner()))
                }
                _ => return false,
            };
            reading.position_m = no_place;
            reading.quaternion_xyzw = pointing(&direction);
        }
    }
    reading.holds = shown;
    true
}

/// What a reading on which [`show`] was called shows.
pub(super) fn seen(tracker_from_link: &Pose, shown: &Reading) -> Seen {
    match shown.holds {
        Holds::Pose => {
            let world_from_tracker =
                Pose::from_parts(Translation3::from(shown.position_m), rotation(shown));
            let world_from_link = world_from_tracker * tracker_from_link;
            Seen::Pose {
                position_m: world_from_link.translation.vector,
                orientation: world_from_link.rotation,
            }
        }
        Holds::Position => Seen::Point(shown.position_m),
        Holds::Orientation => Seen::Orientation(rotation(shown) * tracker_from_link.rotation),
        Holds::Direction => {
            Seen::Direction(UnitVector3::new_normalize(rotation(shown) * Vector3::z()))
        }
    }
}

/// A rotation that turns the z axis to a direction, of the norm of a direction that is none where
/// it has none, as a quaternion `[x, y, z, w]`.
fn pointing(direction: &Vector3<f64>) -> [f64; 4] {
    let norm = direction.norm();
    if !(norm.is_finite() && norm > 0.0) {
        return [norm; 4];
    }
    let turn = so3::between(&Vector3::z(), direction);
    let q = turn.quaternion();
    [q.i, q.j, q.k, q.w]
}

fn rotation(reading: &Reading) -> UnitQuaternion<f64> {
    let [x, y, z, w] = reading.quaternion_xyzw;
    UnitQuaternion::new_normalize(Quaternion::new(w, x, y, z))
}

/// The covariances of a track's readings, where it is weighed by them and every reading has one that is
/// positive definite in what is seen; empty otherwise.
pub(super) fn covariances(
    track: &Track,
    stream: &[Reading],
    events: &[TakeEvent],
) -> Vec<Matrix6<f64>> {
    if track.weighing != Weighing::Messages {
        return Vec::new();
    }
    let matrices = stream.iter().map(|reading| {
        let matrix = reading.covariance(events).map(Covariance::matrix)?;
        let is_sound = match reading.holds {
            Holds::Pose => matrix.cholesky().is_some(),
            Holds::Position => matrix
                .fixed_view::<3, 3>(0, 0)
                .clone_owned()
                .cholesky()
                .is_some(),
            Holds::Orientation | Holds::Direction => matrix
                .fixed_view::<3, 3>(3, 3)
                .clone_owned()
                .cholesky()
                .is_some(),
        };
        is_sound.then_some(matrix)
    });
    matrices.collect::<Option<_>>().unwrap_or_default()
}
