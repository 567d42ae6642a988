//! How bodies lie at the end of their simulated motion, from its poses alone.

use nalgebra::{UnitQuaternion, Vector3};

use crate::motion::{Lie, Link, RestGoal, Scene, Settled};
use crate::physics::contact;

/// The last part of a motion, in which what rests does not move \[s\].
const STILL_S: f64 = 0.05;
/// Greatest turn in that part \[rad\], and greatest way as a share of the body's radius.
const STILL_RAD: f64 = 0.01;
const STILL_SHARE: f64 = 0.01;

/// How the links of the scene's goals at rest lie at the end of a motion, goal by goal.
pub fn lies(scene: &Scene, settled: &Settled) -> Vec<Lie> {
    let goals = scene.rest_goals.iter();
    goals.map(|goal| lie(scene, settled, goal)).collect()
}

/// Whether every goal at rest is met at the end of a motion.
pub fn is_met(scene: &Scene, settled: &Settled) -> bool {
    lies(scene, settled).iter().all(Lie::is_met)
}

fn lie(scene: &Scene, settled: &Settled, goal: &RestGoal) -> Lie {
    let link = &scene.links[goal.link];
    let poses = &settled.links[goal.link].poses;
    let Some(last) = poses.last() else {
        return Lie {
            angle_rad: f64::NAN,
            shown: "nothing".to_owned(),
            is_still: false,
            is_shown: false,
        };
    };
    let angle_rad = |axis: &Vector3<f64>| (last.rotation * axis).angle(&goal.direction);
    let back = (STILL_S / settled.interval_s).ceil() as usize;
    let before = &poses[poses.len().saturating_sub(back + 1)];
    let way_m = (last.translation.vector - before.translation.vector).norm();
    let is_still = settled.at_rest
        && poses.len() > back
        && last.rotation.angle_to(&before.rotation) <= STILL_RAD
        && way_m <= STILL_SHARE * link.shape.radius_m();
    let mut axes = vec![(goal.name.clone(), goal.axis)];
    axes.extend(named_axes(link));
    let nearest = axes
        .iter()
        .min_by(|a, b| angle_rad(&a.1).total_cmp(&angle_rad(&b.1)));
    let own_rad = angle_rad(&goal.axis);
    Lie {
        angle_rad: own_rad,
        shown: nearest.map_or_else(|| goal.name.clone(), |(name, _)| name.clone()),
        is_still,
        is_shown: own_rad <= goal.within_rad,
    }
}

/// The name of what points up of a link in an orientation: a declared face, `±x`, `±y` or `±z`.
pub fn up_name(link: &Link, orientation: &UnitQuaternion<f64>, up: &Vector3<f64>) -> String {
    let off = |axis: &Vector3<f64>| (orientation * axis).angle(up);
    let axes = named_axes(link).into_iter();
    let nearest = axes.min_by(|a, b| off(&a.1).total_cmp(&off(&b.1)));
    nearest.map_or_else(String::new, |(name, _)| name)
}

/// Declared faces and axes, those that come first before others.
fn named_axes(link: &Link) -> Vec<(String, Vector3<f64>)> {
    let faces = link.features.iter().filter_map(|feature| {
        let contact::Feature::Face { normal, .. } = feature.geometry else {
            return None;
        };
        Some((feature.name.clone(), normal))
    });
    let letters = ["x", "y", "z"].into_iter().enumerate();
    let along = letters.flat_map(|(axis, name)| {
        let along = Vector3::ith(axis, 1.0);
        [(format!("+{name}"), along), (format!("-{name}"), -along)]
    });
    faces.chain(along).collect()
}
