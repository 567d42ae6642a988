//! Motions of bodies in the hand from which joined ones may hang: what their trackers saw, smoothed, and no more.

use crate::estimate::outcome::held_motion::{Pace, in_time};
use crate::motion::held::{HeldEstimate, Knot};
use crate::motion::{Scene, Sketch};

/// The motion of every held body, from the beginning of what is estimated to its end \[s\] at least.
pub(super) fn hands(scene: &Scene, sketch: &Sketch, span_s: [f64; 2]) -> Vec<HeldEstimate> {
    let tracks = sketch.tracks.iter_enumerated();
    let held = tracks.filter_map(|(track, of)| {
        let motion = of.held.as_ref()?;
        let of_scene = &scene.tracks[track];
        let (mut knots, times) = in_time(
            track,
            of,
            motion,
            &of_scene.link_from_tracker,
            &Pace::STAMPS,
        );
        let mounted = crate::motion::held::Curve::new(knots.clone());
        let [first_s, last_s] = [0, knots.len() - 1].map(|at| knots[at].time_s);
        let at = |time_s: f64| Knot {
            time_s,
            driven: mounted.at(time_s),
        };
        if span_s[0] < first_s {
            knots.insert(0, at(span_s[0]));
        }
        if span_s[1] > last_s {
            knots.push(at(span_s[1]));
        }
        Some(HeldEstimate::new(of_scene.link, knots, Vec::new(), times))
    });
    held.collect()
}
