//! Heights of surfaces: how far from its surface a body is when it bounces.

use nalgebra::{Quaternion, UnitQuaternion, Vector3};

use super::facts::Facts;
use crate::math::Pose;
use crate::motion::{Collision, LinkIndex, Partner, Remedy, Scene, Stamp, TakeEvent};
use crate::physics::contact;

/// Least height that is looked into, in the scene's weights: a hand strays by two, for a whole motion.
const LEAST: f64 = 4.0;
/// Farthest that a bounce is from its mark \[ns\].
const REACH_NS: u64 = 150_000_000;
/// Samples of the lines before and after a bounce.
const LINE: usize = 3;
/// Farthest that these lines meet from the lowest sample \[m\].
const MEETS_M: f64 = 0.05;

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
            higher_m: normal * higher_m,
            point_m: point_m + normal * higher_m,
        });
        let has_more = scene.surfaces.len() + scene.obstacles.len() + scene.goals.len() > 1;
        remedies.extend(has_more.then(|| Remedy::Origin {
            higher_m: normal * higher_m,
        }));
    }
    remedies
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
    let bounces = scene.events.iter().zip(&marks).filter_map(|(event, mark)| {
        let collision = event.kind.collision()?;
        (collision.partner == Partner::World).then_some((collision, *mark))
    });
    bounces
        .filter_map(|(collision, mark)| {
            let reach_ns = marks.iter().map(|other| other.0.abs_diff(mark.0));
            let reach_ns = reach_ns
                .filter(|apart_ns| *apart_ns > 0)
                .min()
                .unwrap_or(u64::MAX)
                / 2;
            at_bounce(scene, events, collision, mark, reach_ns.min(REACH_NS))
        })
        .collect()
}

/// The plane that is touched, with the height over it at which a body turns back: its samples about the mark
/// come down, and go up again. Their lines meet between two of them.
fn at_bounce(
    scene: &Scene,
    events: &[TakeEvent],
    collision: &Collision,
    mark: Stamp,
    reach_ns: u64,
) -> Option<(usize, f64)> {
    let mut heights: Vec<(f64, usize, f64)> = poses(scene, events, collision.link)
        .filter(|(stamp, _)| stamp.0.abs_diff(mark.0) <= reach_ns)
        .filter_map(|(stamp, pose)| {
            let (surface, height_m) = over_planes(scene, collision, &pose)?;
            Some((
                stamp.0.wrapping_sub(mark.0) as f64 * 1e-9,
                surface,
                height_m,
            ))
        })
        .collect();
    heights.sort_by(|a, b| a.0.total_cmp(&b.0));
    let lowest = (0..heights.len()).min_by(|a, b| heights[*a].2.total_cmp(&heights[*b].2))?;
    let (time_s, surface, height_m) = heights[lowest];
    let line = |of: &[(f64, usize, f64)]| -> Option<(f64, f64)> {
        let count = of.len() as f64;
        let mean_s = of.iter().map(|(s, ..)| s).sum::<f64>() / count;
        let mean_m = of.iter().map(|(.., h)| h).sum::<f64>() / count;
        let square_s2: f64 = of.iter().map(|(s, ..)| (s - mean_s).powi(2)).sum();
        let slope = of.iter().map(|(s, _, h)| (s - mean_s) * h).sum::<f64>() / square_s2;
        slope
            .is_finite()
            .then_some((mean_m - slope * (mean_s - time_s), slope))
    };
    let before = lowest
        .checked_sub(LINE)
        .and_then(|from| heights.get(from..lowest));
    let after = heights.get(lowest + 1..lowest + 1 + LINE);
    let (down, up) = (before.and_then(&line), after.and_then(&line));
    let meets = down.zip(up).map(|((from, falls), (to, rises))| {
        let at_s = (to - from) / (falls - rises);
        from + falls * at_s
    });
    // The lines meet below the lowest sample, by less than a sample's way.
    let meets = meets.filter(|m| m.is_finite() && (height_m - m).abs() < MEETS_M);
    Some((surface, meets.unwrap_or(height_m)))
}

/// The nearest plane with the height of the nearest part over it.
pub(super) fn over_planes(
    scene: &Scene,
    collision: &Collision,
    pose: &Pose,
) -> Option<(usize, f64)> {
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

/// Poses of a link by its readings.
fn poses(
    scene: &Scene,
    events: &[TakeEvent],
    link: LinkIndex,
) -> impl Iterator<Item = (Stamp, Pose)> {
    events.iter().filter_map(move |event| {
        let TakeEvent::Pose { track, sample, .. } = event else {
            return None;
        };
        let seen = scene.tracks.get(*track).filter(|seen| seen.link == link)?;
        let [x, y, z, w] = sample.quaternion_xyzw;
        let turn = UnitQuaternion::try_new(Quaternion::new(w, x, y, z), 0.5)?;
        let world_from_tracker = Pose::from_parts(sample.position_m.into(), turn);
        Some((
            sample.stamp,
            world_from_tracker * seen.link_from_tracker.inverse(),
        ))
    })
}
