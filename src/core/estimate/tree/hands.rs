//! Motions of bodies in the hand from which joined ones may hang: what their trackers saw, smoothed, and no more.

use crate::estimate::outcome::held_motion::{Pace, in_time, over};
use crate::motion::held::HeldEstimate;
use crate::motion::{Scene, Sketch};

/// The motion of every held body, from the beginning of what is estimated to its end \[s\] at least.
pub(super) fn hands(scene: &Scene, sketch: &Sketch, span_s: [f64; 2]) -> Vec<HeldEstimate> {
    let tracks = sketch.tracks.iter_enumerated();
    let held = tracks.filter_map(|(track, of)| {
        let motion = of.held.as_ref()?;
        let of_scene = &scene.tracks[track];
        let mount = &of_scene.link_from_tracker;
        let (knots, times) = in_time(track, &of.samples, motion, mount, &Pace::STAMPS);
        let knots = over(knots, span_s);
        Some(HeldEstimate::new(of_scene.link, knots, Vec::new(), times))
    });
    held.collect()
}
