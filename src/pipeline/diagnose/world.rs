//! Heights of surfaces: how far from its surface a body is when it bounces.

use nalgebra::{Point3, Quaternion, UnitQuaternion, Vector3};

use super::facts::Facts;
use super::motion::Motion;
use crate::math::Pose;
use crate::motion::{
    Collision, LinkIndex, Partner, PoseSample, Remedy, Scene, Stamp, TakeEvent, TrackIndex,
};
use crate::physics::contact;

/// Least height that is looked into, in the scene's weights.
const LEAST: f64 = 0.5;

/// Other heights of the planes that bodies bounce off, and of everything where there is more.
pub(super) fn remedies(facts: &Facts) -> Vec<Remedy> {
    let scene = facts.scene.with_marks(marks(facts.events).len());
    let heights = heights(&scene, facts.events);
    let mut remedies = Vec::new();
    for surface in 0..scene.surfaces.len() {
        let contact::Feature::Face { point_m, normal } = scene.surfaces[surface].geometry else {
            continue;
        };
        let of = heights.iter().filter(|(of, _)| *of == surface);
        let mut heights_m: Vec<f64> = of.map(|(_, height_m)| *height_m).collect();
        if heights_m.is_empty() {
            continue;
        }
        let middle = heights_m.len() / 2;
        let higher_m = *heights_m.select_nth_unstable_by(middle, f64::total_cmp).1;
        if higher_m.abs() < LEAST * scene.weights.position_m {
            continue;
        }
        remedies.push(Remedy::Surface {
            surface,
            higher_m,
            point_m: point_m + normal * higher_m,
        });
        let has_more = scene.surfaces.len() + scene.obstacles.len() + scene.goals.len() > 1;
        remedies.extend(has_more.then(|| Remedy::Origin {
            higher_m: normal * higher_m,
        }));
    }
    remedies
}

/// The height with which a motion's samples are, on the average, on neither side of it.
pub(super) fn refined(remedy: &Remedy, motion: &Motion) -> Option<Remedy> {
    let _ = motion;
    match remedy {
        Remedy::Surface { .. } | Remedy::Origin { .. } => None,
        _ => None,
    }
}

fn marks(events: &[TakeEvent]) -> Vec<Stamp> {
    let marks = events.iter().filter_map(|event| match event {
        TakeEvent::Mark(mark) => Some(mark.stamp),
        TakeEvent::Pose { .. } => None,
    });
    let mut marks: Vec<Stamp> = marks.collect();
    marks.sort_unstable();
    marks
}

/// Height of a body's part over the plane that it should touch, at each of its bounces.
fn heights(scene: &Scene, events: &[TakeEvent]) -> Vec<(usize, f64)> {
    let marks = marks(events);
    if marks.len() != scene.events.len() {
        return Vec::new();
    }
    let bounces = scene.events.iter().zip(marks).filter_map(|(event, mark)| {
        let collision = event.kind.collision()?;
        (collision.partner == Partner::World).then_some((collision, mark))
    });
    bounces
        .flat_map(|(collision, mark)| {
            let pose = pose_at(scene, events, collision.link, mark);
            pose.map(|pose| over_planes(scene, collision, &pose))
                .unwrap_or_default()
        })
        .collect()
}

/// The nearest plane with the height of the nearest part over it.
fn over_planes(scene: &Scene, collision: &Collision, pose: &Pose) -> Option<(usize, f64)> {
    let features = &scene.links[collision.link].features;
    let heights = collision.contacts.iter().flat_map(|touching| {
        let surfaces = match touching.other {
            Some(surface) => surface..surface + 1,
            None => 0..scene.surfaces.len(),
        };
        surfaces.filter_map(move |surface| {
            let contact::Feature::Face { point_m, normal } = scene.surfaces[surface].geometry
            else {
                return None;
            };
            let named = touching.feature.map(|feature| feature..feature + 1);
            let features = &features[named.unwrap_or(0..features.len())];
            let heights = features.iter().map(|feature| {
                let lowest_m = lowest_m(&feature.geometry.placed(pose), &normal);
                lowest_m - normal.dot(&point_m)
            });
            Some((surface, heights.fold(f64::INFINITY, f64::min)))
        })
    });
    heights
        .filter(|(_, height_m)| height_m.is_finite())
        .min_by(|a, b| a.1.abs().total_cmp(&b.1.abs()))
}

/// Least coordinate of a part along a direction \[m\].
fn lowest_m(part: &contact::Feature, up: &Vector3<f64>) -> f64 {
    match part {
        contact::Feature::Point { point_m, radius_m }
        | contact::Feature::Line {
            point_m, radius_m, ..
        } => up.dot(point_m) - radius_m,
        contact::Feature::Rim {
            centre_m,
            axis,
            radius_m,
        } => up.dot(centre_m) - radius_m * up.cross(axis).norm(),
        contact::Feature::Face { point_m, .. } => up.dot(point_m),
    }
}

/// Pose of a link by the reading nearest in time.
fn pose_at(scene: &Scene, events: &[TakeEvent], link: LinkIndex, stamp: Stamp) -> Option<Pose> {
    let readings = events.iter().filter_map(|event| match event {
        TakeEvent::Pose { track, sample, .. } => Some((*track, sample)),
        TakeEvent::Mark(_) => None,
    });
    let of_link =
        readings.filter(|(track, _)| scene.tracks.get(*track).is_some_and(|t| t.link == link));
    let apart = |sample: &PoseSample| sample.stamp.0.abs_diff(stamp.0);
    let (track, sample): (TrackIndex, &PoseSample) =
        of_link.min_by_key(|(_, sample)| apart(sample))?;
    let [x, y, z, w] = sample.quaternion_xyzw;
    let turn = UnitQuaternion::try_new(Quaternion::new(w, x, y, z), 0.5)?;
    let world_from_tracker = Pose::from_parts(Point3::from(sample.position_m).coords.into(), turn);
    Some(world_from_tracker * scene.tracks[track].link_from_tracker.inverse())
}
