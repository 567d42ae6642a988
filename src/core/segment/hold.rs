//! The motions of the bodies in the hand, from their samples.

use super::error::SegmentError;
use super::smooth::{SAMPLES_MIN, smoothed};
use crate::motion::{Held, HeldMotion, Scene, Sketch, TrackIndex};

/// A collision is seen if samples before and after it are nearer than this \[s\].
const SEEN_S: f64 = 0.1;

/// Joined bodies hang from a hand that is seen at least so often \[s\].
const GAP_S: f64 = 0.1;

/// Sets the motions of the bodies in the hand from their samples.
///
/// Fails where a body has too few samples, none near one of its collisions, a gap where joined bodies hang from it, or such that no number is
/// large enough for their motion.
pub fn hold(scene: &Scene, sketch: &mut Sketch) -> Result<(), SegmentError> {
    for track in scene.tracks.keys() {
        if let Some(held) = &scene.link_seen_by(track).held {
            let motion = motion(scene, sketch, track, held)?;
            if !motion.is_finite() {
                return Err(SegmentError::HeldNotFinite {
                    body: scene.link_seen_by(track).name.clone(),
                });
            }
            sketch.tracks[track].held = Some(motion);
        }
    }
    Ok(())
}

fn motion(
    scene: &Scene,
    sketch: &Sketch,
    track: TrackIndex,
    held: &Held,
) -> Result<HeldMotion, SegmentError> {
    let of = &sketch.tracks[track];
    let body = || scene.link_seen_by(track).name.clone();
    if of.samples.len() < SAMPLES_MIN {
        return Err(SegmentError::HeldSamples {
            body: body(),
            samples: of.samples.len(),
            expected: SAMPLES_MIN,
        });
    }
    let link = scene.tracks[track].link;
    if scene.carries(link) {
        check_gaps(scene, sketch, track)?;
    }
    let hits = (0..scene.events.len()).filter(|event| {
        let collision = scene.events[*event].kind.collision();
        collision.is_some_and(|collision| collision.links().any(|other| other == link))
    });
    let hits: Vec<(usize, f64)> = hits.map(|event| (event, sketch.marks_s[event])).collect();
    for (event, time_s) in &hits {
        let after = of.samples.partition_point(|s| s.acted_s <= *time_s);
        let before_s = after
            .checked_sub(1)
            .map(|at| time_s - of.samples[at].acted_s);
        let after_s = of.samples.get(after).map(|s| s.acted_s - time_s);
        let is_seen = |apart_s: Option<f64>| apart_s.is_some_and(|apart_s| apart_s <= SEEN_S);
        // One at the last sample is seen from before.
        let is_last = before_s == Some(0.0);
        if !(is_seen(before_s) && (is_seen(after_s) || is_last)) {
            return Err(SegmentError::HeldUnseen {
                body: body(),
                event: scene.events[*event].name.clone(),
                time_s: *time_s,
                before_s,
                after_s,
                within_s: SEEN_S,
            });
        }
    }
    Ok(smoothed(
        of,
        &scene.tracks[track].link_from_tracker,
        held,
        &hits,
    ))
}

/// Fails where the samples of a track do not cover the motion of a scene with joined bodies.
fn check_gaps(scene: &Scene, sketch: &Sketch, track: TrackIndex) -> Result<(), SegmentError> {
    let [begin_s, end_s] = sketch.whole_span_s(scene);
    let seen_s = sketch.tracks[track].samples.iter().map(|of| of.acted_s);
    let seen_s = seen_s.filter(|time_s| (begin_s..=end_s).contains(time_s));
    let mut before_s = begin_s;
    for time_s in seen_s.chain([end_s]) {
        if time_s - before_s > GAP_S {
            return Err(SegmentError::HeldGap {
                body: scene.link_seen_by(track).name.clone(),
                from_s: before_s,
                to_s: time_s,
                within_s: GAP_S,
            });
        }
        before_s = time_s;
    }
    Ok(())
}
