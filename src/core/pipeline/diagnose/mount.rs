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
use super::motion::{TriedFlight, TriedMotion};
use super::turned::mounts;
use crate::math::Pose;
use crate::math::so3::{exp, log};
use crate::motion::{MountSlip, QuaternionSlip, Remedy, Scene, TrackIndex};

/// Least offset \[m\].
const LEAST_M: f64 = 1e-3;
/// Least mean square share of an axis in the body's turning for an offset along it to be seen.
const LEAST_SHARE: f64 = 0.02;
/// The same, below which impacts are asked too.
const WEAK_SHARE: f64 = 0.1;

/// Other mounts of each tracker.
pub(super) fn remedies(facts: &Facts) -> Vec<Remedy> {
    let tracks = facts.scene.tracks.iter_enumerated();
    tracks
        .filter(|(track, _)| facts.is_tracked(*track))
        .flat_map(|(track, seen)| {
            // Slips are of what was typed: in the frame in which the scene gives the body.
            let link = &facts.scene.links[seen.link];
            let (link_from_given, given) = (
                link.link_from_given,
                link.given_from(&seen.link_from_tracker),
            );
            let offset_m = given.translation.vector;
            let has_offset = offset_m.norm() > LEAST_M;
            let has_turn = given.rotation.angle() > 1e-6;
            let negated = Pose::from_parts(Translation3::from(-offset_m), given.rotation);
            let turned = |slip: QuaternionSlip| {
                Pose::from_parts(given.translation, slip.corrected(&given.rotation))
            };
            let in_link = move |pose: Pose| link_from_given * pose;
            let fitted = fitted(facts.scene, &facts.flights, track);
            let slip = if has_offset {
                MountSlip::Offset
            } else {
                MountSlip::Missing
            };
            [
                (has_offset, MountSlip::Negated, Some(in_link(negated))),
                (
                    has_turn,
                    MountSlip::Inverted,
                    Some(in_link(given.inverse())),
                ),
                (
                    has_turn,
                    MountSlip::Quaternion,
                    Some(in_link(turned(QuaternionSlip::ScalarLast))),
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

/// Mounts of each tracker that are turned otherwise, with the offset as it is said and with that which fits flights
/// best.
pub(super) fn turned(facts: &Facts) -> Vec<Remedy> {
    let tracks = facts.scene.tracks.keys();
    let tracks = tracks.filter(|track| facts.is_tracked(*track));
    let remedies = tracks.flat_map(|track| {
        mounts(facts, track).into_iter().flat_map(move |turned| {
            let elsewhere = elsewhere(facts, track, &turned);
            [
                (MountSlip::Turned, Some(turned)),
                (MountSlip::Elsewhere, elsewhere),
            ]
            .into_iter()
            .filter_map(move |(slip, pose)| {
                Some(Remedy::Mount {
                    track,
                    link_from_tracker: pose?,
                    slip,
                })
            })
        })
    });
    let mut remedies: Vec<Remedy> = remedies.collect();
    // What is wrong in one thing before what is wrong in two.
    remedies.sort_by_key(|remedy| {
        matches!(
            remedy,
            Remedy::Mount {
                slip: MountSlip::Elsewhere,
                ..
            }
        )
    });
    remedies
}

/// A turned mount with the offset that fits flights best. Flights show where the centre of mass is in the tracker's own
/// axes, however these are turned on the body.
fn elsewhere(facts: &Facts, track: TrackIndex, turned: &Pose) -> Option<Pose> {
    let given = facts.scene.tracks[track].link_from_tracker;
    let fitted = fitted(facts.scene, &facts.flights, track)?;
    let centre_m = given.rotation.inverse() * fitted.translation.vector;
    let moved = Translation3::from(turned.rotation * centre_m);
    Some(Pose::from_parts(moved, turned.rotation))
}

/// A mount turned so that what is seen of a flight is, in the mean, as the motion has it.
pub(super) fn aligned(motion: &TriedMotion, track: TrackIndex) -> Option<Pose> {
    let (scene, estimate) = (&motion.scene, &motion.estimate);
    let mechanism = scene.mechanism_seen_by(track);
    let arcs = estimate
        .arcs
        .iter()
        .filter(|arc| arc.mechanism == mechanism);
    let arcs: Vec<_> = arcs.collect();
    let (mut sum, mut count) = (Vector3::zeros(), 0.0);
    for flight in motion.flights().iter().filter(|of| of.track == track) {
        for (time_s, sample) in &flight.readings {
            let within = arcs.iter().find(|arc| *time_s <= arc.end_s);
            let (Some(arc), Some(seen)) = (within.or(arcs.last()), sample.seen.orientation())
            else {
                continue;
            };
            let state = scene.flown(arc, &estimate.gravity_m_s2, *time_s);
            sum += log(&(state.orientation.inverse() * seen));
            count += 1.0;
        }
    }
    let given = scene.tracks[track].link_from_tracker;
    let turned = exp(&(sum / count)) * given.rotation;
    (count > 0.0).then(|| Pose::from_parts(given.translation, turned))
}

/// The mount with the offset that fits flights best; `None` where the body turns in none of the track, and
/// where the mount as it is fits as well.
pub(super) fn fitted(scene: &Scene, flights: &[TriedFlight], track: TrackIndex) -> Option<Pose> {
    let (eigen, right, count) = normal(scene, flights, track);
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
    let given = scene.tracks[track].link_from_tracker;
    // A body's acted centre is off by `R δ` where the mount's offset lacks `δ`.
    let moved = Translation3::from(given.translation.vector + offset_m);
    (offset_m.norm() > LEAST_M).then(|| Pose::from_parts(moved, given.rotation))
}

/// Axes of the body along which flights do not show an offset.
pub(super) fn unseen(
    scene: &Scene,
    flights: &[TriedFlight],
    track: TrackIndex,
) -> Vec<Vector3<f64>> {
    let (eigen, _, count) = normal(scene, flights, track);
    let axes = eigen
        .eigenvalues
        .iter()
        .zip(eigen.eigenvectors.column_iter());
    let weak = axes.filter(|(value, _)| **value <= WEAK_SHARE * count);
    weak.map(|(_, axis)| axis.into_owned()).collect()
}

/// Normal equations of `δ`, and the number of samples.
fn normal(
    scene: &Scene,
    flights: &[TriedFlight],
    track: TrackIndex,
) -> (SymmetricEigen<f64, nalgebra::U3>, Vector3<f64>, f64) {
    let (mut normal, mut right, mut count) = (Matrix3::zeros(), Vector3::zeros(), 0.0);
    for flight in flights.iter().filter(|flight| flight.track == track) {
        let size = flight.readings.len() as f64;
        let mean_s = flight.readings.iter().map(|(s, _)| s).sum::<f64>() / size;
        let square_s2: f64 = flight
            .readings
            .iter()
            .map(|(s, _)| (s - mean_s).powi(2))
            .sum();
        if !(square_s2 > 0.0) {
            continue;
        }
        let seen = || {
            flight.readings.iter().filter_map(|(s, sample)| {
                let since_s = s - mean_s;
                let fallen_m = scene.gravity_m_s2 * (0.5 * since_s * since_s);
                let turn = sample.seen.orientation()?.to_rotation_matrix().into_inner();
                Some((since_s, sample.seen.position_m()? - fallen_m, turn))
            })
        };
        // A flight's own position and velocity: what is left is orthogonal to a straight line.
        let mut mean = (Vector3::zeros(), Matrix3::zeros());
        let mut slope = (Vector3::zeros(), Matrix3::zeros());
        for (since_s, p, turn) in seen() {
            let share = since_s / square_s2;
            mean = (mean.0 + p / size, mean.1 + turn / size);
            slope = (slope.0 + p * share, slope.1 + turn * share);
        }
        for (since_s, p, turn) in seen() {
            let left = p - mean.0 - slope.0 * since_s;
            let turned = turn - mean.1 - slope.1 * since_s;
            normal += turned.tr_mul(&turned);
            right += turned.tr_mul(&left);
        }
        count += size;
    }
    (SymmetricEigen::new(normal), right, count)
}
