//! When the lamp flashes, and where bodies are then.

use nalgebra::{Quaternion, Translation3, UnitQuaternion, Vector3};

use crate::math::Pose;
use crate::motion::{LinkIndex, PoseSample, Scene, Stamp};
use crate::report::EstimateReport;
use crate::sampling::stamp;
use crate::visual::mesh;
use crate::write::export::{WrittenMotion, acted_at, motion_at};

/// Between two flashes a body should move by so much of its radius.
const MOVE_RADII: f64 = 1.0;

/// At least and at most so many flashes of the motion.
const FLASHES: [f64; 2] = [8.0, 40.0];

/// Steps that people count in, in any power of ten.
const STEPS: [f64; 9] = [1.0, 1.2, 1.5, 2.0, 2.5, 3.0, 4.0, 5.0, 6.0];

/// What is simulated is drawn where it has moved by so much of its radius.
const SETTLING_RADII: f64 = 0.5;

/// A turn of a long body moves what is seen of it as far as a way of so much of its radius per radian; that of one
/// as long as wide shows nothing new.
const TURN_RADII: f64 = 0.55;

/// Acted poses farther apart than this many steps have nothing between them.
pub(super) const GAP_STEPS: f64 = 2.0;

/// What a flash shows.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Shows {
    /// The estimated motion.
    Motion,
    /// What is simulated after it.
    Simulated,
    /// The motion at an event.
    Event,
    /// The performance.
    Acted,
}

/// A body as it is seen at an instant.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Flash {
    pub link: LinkIndex,
    pub at: Stamp,
    pub world_from_link: Pose,
    pub shows: Shows,
}

/// The time between flashes: a number that people count in, so that bodies move by about their radius in it.
/// `None` of a motion without poses.
pub(super) fn step_s(scene: &Scene, motion: &WrittenMotion) -> Option<f64> {
    let [from, until] = extent(motion)?;
    let until = motion.simulated_from.map_or(until, |at| at.min(until));
    let mut moves: f64 = 0.0;
    for (link, samples) in motion.estimates.iter_enumerated() {
        let body = PlanSize::of(scene, link);
        let before = samples.iter().filter(|sample| sample.stamp <= until);
        let before: Vec<&PoseSample> = before.collect();
        let ways = before
            .windows(2)
            .map(|pair| way_radii(pair[0], pair[1], &body));
        moves = moves.max(ways.sum());
    }
    let count = (moves / MOVE_RADII).clamp(FLASHES[0], FLASHES[1]);
    let wanted_s = (until.seconds_since(from) / count).max(1e-4);
    let power = 10f64.powf(wanted_s.log10().floor());
    let nice = STEPS.map(|step| step * power);
    let near = nice.into_iter().find(|step_s| *step_s >= 0.95 * wanted_s);
    Some(near.unwrap_or(10.0 * power))
}

/// From where to where the motion of all bodies is.
pub(super) fn extent(motion: &WrittenMotion) -> Option<[Stamp; 2]> {
    let stamps = || motion.estimates.iter().flatten().map(|sample| sample.stamp);
    Some([stamps().min()?, stamps().max()?])
}

/// How far what is seen of a body moves, in its radii.
fn way_radii(a: &PoseSample, b: &PoseSample, body: &PlanSize) -> f64 {
    let [from, to] = [a, b].map(pose);
    let turn_rad = from.rotation.angle_to(&to.rotation);
    let way_m = (to.translation.vector - from.translation.vector).norm();
    way_m / body.radius_m + TURN_RADII * body.length * turn_rad
}

/// How large a body is.
struct PlanSize {
    radius_m: f64,
    /// From 0 of what is as long as wide to 1 of a line.
    length: f64,
}

impl PlanSize {
    fn of(scene: &Scene, link: LinkIndex) -> Self {
        let shape = &scene.links[link].shape;
        let corners = mesh(shape).into_iter().flatten();
        let half_m = corners.fold(Vector3::zeros(), |half_m: Vector3<f64>, corner| {
            half_m.sup(&corner.abs())
        });
        let (widest_m, narrowest_m) = (half_m.max(), half_m.min());
        Self {
            radius_m: shape.radius_m().max(1e-9),
            length: if widest_m > 0.0 {
                1.0 - narrowest_m / widest_m
            } else {
                0.0
            },
        }
    }
}

pub(super) fn pose(sample: &PoseSample) -> Pose {
    let [x, y, z, w] = sample.quaternion_xyzw;
    let turn = UnitQuaternion::from_quaternion(Quaternion::new(w, x, y, z));
    Pose::from_parts(Translation3::from(sample.position_m), turn)
}

/// The instants of the flashes.
fn instants(motion: &WrittenMotion, step_s: f64) -> Vec<Stamp> {
    let Some([from, until]) = extent(motion) else {
        return Vec::new();
    };
    let count = (until.seconds_since(from) / step_s + 1e-6).floor() as usize;
    let at = |step: usize| stamp(from, step as f64 * step_s);
    (0..=count).map(at).collect()
}

/// The bodies at all flashes and at their events. Of what is simulated those that have moved, and the last.
pub(super) fn flashes(
    scene: &Scene,
    said: &EstimateReport,
    motion: &WrittenMotion,
    step_s: f64,
) -> Vec<Flash> {
    let mut all = Vec::new();
    for (link, samples) in motion.estimates.iter_enumerated() {
        let flash = |sample: &PoseSample, shows| Flash {
            link,
            at: sample.stamp,
            world_from_link: pose(sample),
            shows,
        };
        let is_simulated = |at: Stamp| motion.simulated_from.is_some_and(|from| at > from);
        let body = PlanSize::of(scene, link);
        let seen = instants(motion, step_s).into_iter();
        let mut settled: Option<PoseSample> = None;
        for sample in seen.filter_map(|at| motion_at(motion, link, at)) {
            if !is_simulated(sample.stamp) {
                all.push(flash(&sample, Shows::Motion));
                settled = Some(sample);
                continue;
            }
            let has_moved = settled
                .as_ref()
                .is_none_or(|last| way_radii(last, &sample, &body) > SETTLING_RADII);
            if has_moved {
                all.push(flash(&sample, Shows::Simulated));
                settled = Some(sample);
            }
        }
        if let Some(last) = samples.last().filter(|last| is_simulated(last.stamp)) {
            all.push(flash(last, Shows::Simulated));
        }
        let name = &scene.links[link].name;
        for event in said.events.iter().filter(|of| of.bodies.contains(name)) {
            let at = stamp(motion.zero, event.time_s);
            if let Ok(here) = samples.binary_search_by_key(&at, |sample| sample.stamp) {
                all.push(flash(&samples[here], Shows::Event));
            }
        }
    }
    all
}

/// The bodies as they were acted, at the same instants.
pub(super) fn ghosts(scene: &Scene, motion: &WrittenMotion, step_s: f64) -> Vec<Flash> {
    let instants = instants(motion, step_s);
    let flown = scene.links.keys().filter(|link| !scene.is_held(*link));
    let all = flown.flat_map(|link| {
        let seen = instants.iter();
        seen.filter_map(move |at| {
            let sample = acted_at(motion, link, *at, GAP_STEPS * step_s)?;
            Some(Flash {
                link,
                at: *at,
                world_from_link: pose(&sample),
                shows: Shows::Acted,
            })
        })
    });
    all.collect()
}
