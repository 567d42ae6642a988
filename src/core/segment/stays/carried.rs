//! Where something carries a body that is no surface: another body that is tracked, or a hand that is not.
//!
//! A body goes with another one where its velocity is that of a point of the other, `v + ω × r`, and both turn alike. It is in a hand
//! where it does not fall and touches nothing: that is told only beside what nobody acts in the air, a flight as exact as the
//! tracker sees or a rest on a surface, for a hand that acts a flight falls nowhere. Where all of a stretch is still, it is held still.

use std::ops::Range;

use nalgebra::Vector3;

use super::local::LocalMotions;
use super::surface::{LONG_S, LONG_SAMPLES, NOISE, STILL};
use crate::math::Pose;
use crate::motion::{Fall, LinkIndex, Scene, Timing, acceleration};
use crate::segment::toss::flights;

/// What goes with another is no faster relative to it than this [m/s], [rad/s],
const APART_M_S: f64 = 0.02;
const APART_RAD_S: f64 = 0.25;
/// strays in it by no more than this \[m\],
const STRAY_M: f64 = 0.004;
/// and goes as far as this \[m\] at least.
const WAY_M: f64 = 0.03;
/// Poses of the other are told between samples that are no farther apart \[s\].
const WITHIN_S: f64 = 0.05;

/// For so long it may seem not to \[s\].
const BRIEF_S: f64 = 0.1;

/// What is off by more than this share of it does not fall as the scene has it.
const NO_FALL_SHARE: f64 = 0.5;
/// Windows tell it, of so long \[s\] and so many samples at least.
const WINDOW_S: f64 = 0.1;
const WINDOW_SAMPLES: usize = 5;
/// A flight that tells of a hand is as long as this \[s\], and no farther from it.
const FLOWN_S: f64 = 0.12;
const BESIDE_S: f64 = 0.1;
/// From a rest it is lifted so slowly that it leaves the surface so much later at most \[s\].
const LIFTED_S: f64 = 0.3;
/// What is held still is so for so long \[s\], and strays by no more than this \[m\].
const HELD_STILL_S: f64 = 0.25;
const HELD_STRAY_M: f64 = 0.003;

/// The times in which a body goes with another one that moves \[s\].
pub(super) fn together(own: &LocalMotions, other: &LocalMotions) -> Vec<[f64; 2]> {
    let sd_m_s = own.velocity_sd_m_s.hypot(other.velocity_sd_m_s);
    let sd_rad_s = own.spin_sd_rad_s.hypot(other.spin_sd_rad_s);
    let relative = |at: usize| {
        let of = &own.each[at];
        let with = other.at(of.time_s, WITHIN_S)?;
        let arm_m = of.pose.translation.vector - with.pose.translation.vector;
        let apart_m_s = of.velocity_m_s - with.velocity_m_s - with.spin_rad_s.cross(&arm_m);
        let apart_rad_s = of.spin_rad_s - with.spin_rad_s;
        // The arm is as uncertain as the other's turn.
        let most_m_s = APART_M_S.max(NOISE * sd_m_s.hypot(arm_m.norm() * other.spin_sd_rad_s));
        let is_alike =
            apart_m_s.norm() <= most_m_s && apart_rad_s.norm() <= APART_RAD_S.max(NOISE * sd_rad_s);
        is_alike.then(|| with.pose.rotation.inverse() * arm_m)
    };
    let places: Vec<Option<Vector3<f64>>> = (0..own.each.len()).map(relative).collect();
    let mut whole: Vec<Range<usize>> = Vec::new();
    for run in runs(places.len(), |at| places[at].is_some()) {
        match whole.last_mut() {
            Some(last) if own.each[run.start].time_s - own.each[last.end - 1].time_s <= BRIEF_S => {
                last.end = run.end;
            }
            _ => whole.push(run),
        }
    }
    let mut found = Vec::new();
    for run in whole {
        let inside: Vec<&Vector3<f64>> = places[run.clone()].iter().flatten().collect();
        let mean: Vector3<f64> = inside.iter().copied().sum::<Vector3<f64>>() / inside.len() as f64;
        let noise_m = NOISE * own.noise_m.hypot(other.noise_m);
        let arm_m = mean.norm() * NOISE * other.noise_rad;
        let is_fixed = { inside }
            .iter()
            .all(|of| (*of - mean).norm() <= STRAY_M + noise_m + arm_m);
        let span_s = [own.each[run.start].time_s, own.each[run.end - 1].time_s];
        let first_m = own.each[run.start].pose.translation.vector;
        let way_m = own.each[run.clone()]
            .iter()
            .map(|of| (of.pose.translation.vector - first_m).norm());
        let goes = way_m.fold(0.0, f64::max) >= WAY_M;
        let is_long = span_s[1] - span_s[0] >= LONG_S && own.count(span_s) >= LONG_SAMPLES;
        if is_fixed && goes && is_long {
            found.push(span_s);
        }
    }
    found
}

/// Whether a body is in a hand, or held still, in times that nothing else explains.
pub(super) enum Carrying {
    Hand,
    Still,
}

/// The times in which a body is in a hand or held still, of those in which nothing else is known of it. `stays` are the times at
/// which it is on a surface, and `rests` those at which it rests there.
pub(super) fn in_hand(
    scene: &Scene,
    link: LinkIndex,
    motions: &LocalMotions,
    known_s: &[[f64; 2]],
    rests_s: &[[f64; 2]],
) -> Vec<(Carrying, [f64; 2])> {
    let pull = scene.links[link].body.pull_m_s2(&scene.gravity_m_s2);
    let size = pull.norm();
    if scene.timing != Timing::Known || !(size > 0.0) {
        return Vec::new();
    }
    let is_in = |spans_s: &[[f64; 2]], time_s: f64| {
        spans_s.iter().any(|of| of[0] <= time_s && time_s <= of[1])
    };
    // As many as there are moments tell enough.
    let stride = (motions.poses.len() / motions.each.len().max(1)).max(1);
    let poses: Vec<(f64, Pose)> = motions.poses.iter().step_by(stride).copied().collect();
    let times_s: Vec<f64> = poses.iter().map(|of| of.0).collect();
    let points: Vec<Vector3<f64>> = poses.iter().map(|of| of.1.translation.vector).collect();
    let is_unknown = |at: usize| !is_in(known_s, times_s[at]);
    let unknown_s: f64 = runs(times_s.len(), is_unknown)
        .map(|of| times_s[of.end - 1] - times_s[of.start])
        .fold(0.0, f64::max);
    if unknown_s < LONG_S {
        return Vec::new();
    }
    let flights = flights(&times_s, &points, &pull);
    let falls_s = |of: &Fall| [times_s[of.samples.start], times_s[of.samples.end - 1]];
    let flights_s: Vec<[f64; 2]> = flights.iter().map(falls_s).collect();
    let touches = touches(scene, link, &poses, motions.noise_m);
    let is_free = |at: usize| is_unknown(at) && !is_in(&flights_s, times_s[at]) && !touches[at];
    let mut found = Vec::new();
    for run in runs(times_s.len(), is_free) {
        let span_s = [times_s[run.start], times_s[run.end - 1]];
        if span_s[1] - span_s[0] < LONG_S || run.len() < LONG_SAMPLES {
            continue;
        }
        if is_still(motions, span_s) && span_s[1] - span_s[0] >= HELD_STILL_S {
            found.push((Carrying::Still, span_s));
            continue;
        }
        let is_beside = |of: &[f64; 2], within_s: f64| {
            (span_s[0] - of[1]).abs() <= within_s || (of[0] - span_s[1]).abs() <= within_s
        };
        let is_told = flights_s
            .iter()
            .any(|of| of[1] - of[0] >= FLOWN_S && is_beside(of, BESIDE_S))
            || rests_s.iter().any(|of| is_beside(of, LIFTED_S));
        if is_told && does_not_fall(&times_s[run.clone()], &points[run.clone()], &pull) {
            found.push((Carrying::Hand, span_s));
        } else if let Some(until_s) = still_until_s(motions, span_s).filter(|_| run.start == 0) {
            found.push((Carrying::Still, [span_s[0], until_s]));
        }
    }
    found
}

/// Whether velocities and turns are noise in a time, and the place stays.
fn is_still(motions: &LocalMotions, span_s: [f64; 2]) -> bool {
    still_until_s(motions, span_s).is_some_and(|until_s| span_s[1] - until_s <= BESIDE_S)
}

/// Until when a body is still from the beginning of a time on, if it is so for long \[s\].
fn still_until_s(motions: &LocalMotions, span_s: [f64; 2]) -> Option<f64> {
    let first = motions.each.partition_point(|of| of.time_s < span_s[0]);
    let from = motions.each.get(first)?.pose.translation.vector;
    let slow_m_s = STILL[0].max(NOISE * motions.velocity_sd_m_s);
    let slow_rad_s = STILL[1].max(NOISE * motions.spin_sd_rad_s);
    let stray_m = HELD_STRAY_M + NOISE * motions.noise_m;
    let still = motions.each[first..].iter().take_while(|of| {
        of.time_s <= span_s[1]
            && of.velocity_m_s.norm() <= slow_m_s
            && of.spin_rad_s.norm() <= slow_rad_s
            && (of.pose.translation.vector - from).norm() <= stray_m
    });
    let until_s = still.last()?.time_s;
    (until_s - span_s[0] >= HELD_STILL_S).then_some(until_s)
}

/// Whether no part of a path falls as gravity has it.
fn does_not_fall(times_s: &[f64], points: &[Vector3<f64>], pull: &Vector3<f64>) -> bool {
    let (mut begin, mut windows, mut falling) = (0, 0, 0);
    while begin < times_s.len() {
        let after = times_s.partition_point(|of| *of <= times_s[begin] + WINDOW_S);
        let end = after.max(begin + WINDOW_SAMPLES);
        if end > times_s.len() {
            break;
        }
        if let Some((of, sd)) = acceleration(&times_s[begin..end], &points[begin..end]) {
            windows += 1;
            falling += usize::from((of - pull).norm() <= NO_FALL_SHARE * pull.norm() + 3.0 * sd);
        }
        begin = end;
    }
    windows > 0 && 3 * falling <= windows
}

/// At which samples a body is within reach of a surface: of its lowest point, to noise and the scene's accuracy.
pub(super) fn touches(
    scene: &Scene,
    link: LinkIndex,
    poses: &[(f64, Pose)],
    noise_m: f64,
) -> Vec<bool> {
    let of = &scene.links[link];
    let solid = of.solid();
    let reach_m = NOISE * noise_m + scene.tolerance_m.max(0.05 * of.radius_m());
    let obstacles = scene.obstacles.iter().filter_map(|obstacle| {
        let of = obstacle.shape.solid().ok()?;
        Some((of, obstacle.world_from_shape, obstacle.shape.radius_m()))
    });
    let obstacles: Vec<_> = obstacles.collect();
    let is_near = |pose: &Pose| {
        let centre_m = pose.translation.vector;
        let planes = scene.surfaces.iter().filter_map(|surface| surface.plane());
        let mut planes = planes.filter(|(point_m, normal)| {
            normal.dot(&(centre_m - point_m)) <= of.radius_m() + reach_m
        });
        planes.any(|(point_m, normal)| {
            let lowest = solid.lowest(pose, &point_m, &normal);
            lowest.is_ok_and(|of| of.gap_m <= reach_m)
        }) || obstacles.iter().any(|(other, there, radius_m)| {
            let apart_m = (centre_m - there.translation.vector).norm();
            apart_m <= radius_m + of.radius_m() + reach_m
                && solid
                    .distance_m(pose, other, there)
                    .is_ok_and(|of| of <= reach_m)
        })
    };
    poses.iter().map(|(_, pose)| is_near(pose)).collect()
}

/// The stretches of a range from 0 on in which something holds.
pub(super) fn runs(
    count: usize,
    holds: impl Fn(usize) -> bool,
) -> impl Iterator<Item = Range<usize>> {
    let mut found = Vec::new();
    let mut begin = 0;
    for at in 0..=count {
        if at == count || !holds(at) {
            if at > begin {
                found.push(begin..at);
            }
            begin = at + 1;
        }
    }
    found.into_iter()
}
