//! The tracker's place on its body.
//!
//! A wrong offset is constant in the body's axes, while a hand's wander is not: with `δ` added to
//! the offset, the centres of mass that were taken for acted are `x_i + R_i δ`, so that in a flight
//!
//! ```text
//! p_i − ½ g s_i² = x + v s_i + R_i δ
//! ```
//!
//! which is linear in `x`, `v` of each flight and the one `δ` of a track.

use nalgebra::{Matrix3, SymmetricEigen, Translation3, Vector3};

use super::facts::Facts;
use super::motion::Motion;
use crate::math::Pose;
use crate::motion::{MountSlip, QuaternionSlip, Remedy, TrackIndex};

/// Least offset \[m\].
const LEAST_M: f64 = 1e-3;
/// Least mean square share of an axis in the body's turning for an offset along it to be seen.
const LEAST_SHARE: f64 = 0.02;

/// Other mounts of each tracker.
pub(super) fn remedies(facts: &Facts) -> Vec<Remedy> {
    let tracks = facts.scene.tracks.iter_enumerated();
    tracks
        .flat_map(|(track, seen)| {
            let given = seen.link_from_tracker;
            let offset_m = given.translation.vector;
            let has_offset = offset_m.norm() > LEAST_M;
            let has_turn = given.rotation.angle() > 1e-6;
            let negated = Pose::from_parts(Translation3::from(-offset_m), given.rotation);
            let turned = |slip: QuaternionSlip| {
                Pose::from_parts(given.translation, slip.corrected(&given.rotation))
            };
            let fitted = facts.motion.and_then(|motion| fitted(motion, track));
            let slip = if has_offset {
                MountSlip::Offset
            } else {
                MountSlip::Missing
            };
            [
                (has_offset, MountSlip::Negated, Some(negated)),
                (has_turn, MountSlip::Inverted, Some(given.inverse())),
                (
                    has_turn,
                    MountSlip::Quaternion,
                    Some(turned(QuaternionSlip::ScalarLast)),
                ),
                (true, slip, fitted),
            ]
            .into_iter()
            .filter_map(move |(is_possible, slip, pose)| {
                Some(Remedy::Mount {
                    track,
                    link_from_tracker: pose.filter(|_| is_possible)?,
                    slip,
                })
            })
        })
        .collect()
}

/// The mount with the offset that fits the flights of a motion best; `None` where it has no
/// flights of the track in which the body turns.
pub(super) fn fitted(motion: &Motion, track: TrackIndex) -> Option<Pose> {
    let (sketch, estimate) = (&motion.sketch, &motion.estimate);
    let mut times = estimate.sample_times.iter();
    let (mut normal, mut right, mut count) = (Matrix3::zeros(), Vector3::zeros(), 0.0);
    for residual in &estimate.residuals {
        let times: Vec<_> = times.by_ref().take(residual.samples).collect();
        if residual.track != track {
            continue;
        }
        let samples = &sketch.tracks[track].samples;
        let seen: Vec<(f64, Vector3<f64>, Matrix3<f64>)> = times
            .iter()
            .filter_map(|time| {
                let at = samples.binary_search_by_key(&time.stamp, |sample| sample.stamp);
                let sample = &samples[at.ok()?];
                let turn = sample.orientation.to_rotation_matrix().into_inner();
                Some((time.time_s, sample.position_m, turn))
            })
            .collect();
        let size = seen.len() as f64;
        let mean_s = seen.iter().map(|(s, ..)| s).sum::<f64>() / size;
        let square_s2: f64 = seen.iter().map(|(s, ..)| (s - mean_s).powi(2)).sum();
        if !(square_s2 > 0.0) {
            continue;
        }
        // A flight's own position and velocity: what is left is orthogonal to a straight line.
        let fallen =
            |s: f64, p: &Vector3<f64>| p - estimate.gravity_m_s2 * (0.5 * (s - mean_s).powi(2));
        let (mut mean, mut slope) = (
            (Vector3::zeros(), Matrix3::zeros()),
            (Vector3::zeros(), Matrix3::zeros()),
        );
        for (s, p, turn) in &seen {
            let fallen = fallen(*s, p);
            mean = (mean.0 + fallen / size, mean.1 + turn / size);
            let share = (s - mean_s) / square_s2;
            slope = (slope.0 + fallen * share, slope.1 + turn * share);
        }
        for (s, p, turn) in &seen {
            let since_s = s - mean_s;
            let left = fallen(*s, p) - mean.0 - slope.0 * since_s;
            let turned = turn - mean.1 - slope.1 * since_s;
            normal += turned.tr_mul(&turned);
            right += turned.tr_mul(&left);
        }
        count += size;
    }
    let eigen = SymmetricEigen::new(normal);
    let mut offset_m = Vector3::zeros();
    for (value, axis) in eigen
        .eigenvalues
        .iter()
        .zip(eigen.eigenvectors.column_iter())
    {
        if *value > LEAST_SHARE * count {
            offset_m += axis * (axis.dot(&right) / value);
        }
    }
    // A body's acted centre is off by `R δ` where the mount's offset lacks `δ`.
    let given = motion.scene.tracks[track].link_from_tracker;
    let moved = Translation3::from(given.translation.vector + offset_m);
    (offset_m.norm() > LEAST_M).then(|| Pose::from_parts(moved, given.rotation))
}
