//! Where a body tumbles: between the last flight of a toss and what it does on a surface then, it is knocked about by contacts
//! that follow each other too soon for flights to be seen between them.
//!
//! It is told of what flies as exactly as the tracker sees, for a hand that acts a flight falls nowhere.

use nalgebra::Vector3;

use super::carried::{runs, touches};
use super::local::LocalMotions;
use crate::math::Pose;
use crate::motion::{LinkIndex, Scene, Timing};
use crate::segment::smooth::SAMPLES_MIN;
use crate::segment::toss::{BETWEEN_SAMPLES, flights};

/// A tumble lasts so long \[s\] at least, and is smoothed between the samples next to both ends.
const LONG_S: f64 = 0.03;
const LONG_SAMPLES: usize = SAMPLES_MIN + 2;
/// What stays then begins so soon after the last contact that is no part of it \[s\].
const BESIDE_S: f64 = 0.1;
/// It touches something in this share of the samples.
const TOUCHING: f64 = 0.5;

/// When a body tumbles \[s\]; `stays_s` are the times in which another thing is known of it, none of them in a tumble.
pub(super) fn tumbling(
    scene: &Scene,
    link: LinkIndex,
    motions: &LocalMotions,
    stays_s: &[[f64; 2]],
) -> impl Iterator<Item = [f64; 2]> + use<> {
    let mut found = Vec::new();
    let pull = scene.links[link].body.pull_m_s2(&scene.gravity_m_s2);
    let size = pull.norm();
    if scene.timing == Timing::Known && size > 0.0 {
        let poses = &motions.poses;
        let is_stay = |at: usize| {
            let mut stays = stays_s.iter();
            stays.any(|of| of[0] <= poses[at].0 && poses[at].0 <= of[1])
        };
        let gaps = runs(poses.len(), |at| !is_stay(at));
        found.extend(gaps.filter_map(|gap| {
            let of_gap = &poses[gap.clone()];
            let first = fallen(scene, link, of_gap, &pull)?;
            let until_s = poses[gap.end - 1].0;
            let mut begins_s = stays_s.iter().map(|of| of[0]);
            let stay_s = begins_s.find(|from_s| (0.0..=BESIDE_S).contains(&(from_s - until_s)));
            let span_s = [of_gap.get(first)?.0, stay_s.unwrap_or(until_s)];
            let rest = of_gap.get(first..)?;
            let touched = touches(scene, link, rest, motions.noise_m);
            let touching = touched.iter().filter(|touches| **touches).count();
            let is_long = span_s[1] - span_s[0] >= LONG_S && rest.len() >= LONG_SAMPLES;
            let is_told = is_long && touching as f64 >= TOUCHING * rest.len() as f64;
            is_told.then_some(span_s)
        }));
    }
    found.into_iter()
}

/// Where the flights of a toss end of which poses begin with one (index): after as many of them as the body has collisions, and one
/// more. Where the last one is not seen, it is as long as is not. `None` where the poses begin with none.
fn fallen(
    scene: &Scene,
    link: LinkIndex,
    poses: &[(f64, Pose)],
    pull: &Vector3<f64>,
) -> Option<usize> {
    let times_s: Vec<f64> = poses.iter().map(|of| of.0).collect();
    let points: Vec<Vector3<f64>> = poses.iter().map(|of| of.1.translation.vector).collect();
    let mut end = None;
    let mechanism = scene.mechanism_of(link);
    let hits = (0..scene.events.len()).filter(|event| {
        let hit = scene.events[*event].kind.collision().is_some();
        hit && scene.concerns(*event, mechanism)
    });
    let mut left = hits.count() + 1;
    for fall in flights(&times_s, &points, pull) {
        let follows = end.is_none_or(|end| fall.samples.start <= end + BETWEEN_SAMPLES);
        if !follows || left == 0 {
            break;
        }
        end = Some(fall.samples.end);
        left -= 1;
    }
    let unseen = if left > 0 { BETWEEN_SAMPLES } else { 0 };
    Some(end? - 1 + unseen)
}
