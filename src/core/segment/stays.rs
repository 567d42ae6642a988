//! What a stream shows of bodies that do not fly: that they rest, slide or roll on surfaces, go with others, are in a hand, or tumble.
//!
//! Everything is told by the geometry and by velocities against their noise; nothing is estimated. Where the tempo is unknown,
//! slow is no sign of a rest in the air, nor gravity of a hand: what is on a surface and what goes with another is told alone.

mod carried;
mod local;
mod parts;
mod said;
mod surface;
mod tumbling;

use typed_index_collections::TiVec;

use self::carried::{Carrying, in_hand, together};
use self::local::LocalMotions;
use self::parts::parts;
pub use self::said::said;
use self::surface::{LONG_S, footings, stays};
use self::tumbling::tumbling;
use crate::motion::{
    LinkIndex, Mechanism, Scene, SeenMotion, SeenPhase, Sketch, Stamp, Timing, TrackIndex,
};
use crate::physics::Sustained;

/// An end of the time that is looked at is met so nearly \[s\].
const AT_END_S: f64 = 0.03;

/// What is carried has been taken, or is let go, so long before or after it is seen to be at most \[s\].
const MET_S: f64 = 0.3;

/// A stretch of a body, in acted time \[s\].
struct ToldStretch {
    motion: SeenMotion,
    span_s: [f64; 2],
}

/// What bodies do that do not fly, body by body in order of time, between two stamps: those that move by themselves and of which a
/// tracker shows poses. Stretches are 0.15 s long at least, parts of one on a surface 0.06 s.
pub fn seen_phases(scene: &Scene, sketch: &Sketch, between: [Stamp; 2]) -> Vec<SeenPhase> {
    if scene.timing == Timing::Edited {
        return Vec::new();
    }
    let motions: TiVec<TrackIndex, Option<LocalMotions>> = sketch
        .tracks
        .iter()
        .map(|track| LocalMotions::of(&track.samples))
        .collect();
    let ends_s = between.map(|of| of.seconds_since(sketch.origin));
    let mut found = Vec::new();
    for (track, own) in motions.iter_enumerated() {
        let (Some(own), link) = (own, scene.tracks[track].link) else {
            continue;
        };
        let mechanism = scene.mechanism_of(link);
        let is_alone = matches!(scene.mechanisms[mechanism], Mechanism::Free(_));
        // Of several trackers the first tells.
        let mut tracks = scene.tracks_of(mechanism);
        if !is_alone || scene.is_held(link) || tracks.next() != Some(track) {
            continue;
        }
        for told in of_link(scene, link, own, &motions) {
            let span_s = [told.span_s[0].max(ends_s[0]), told.span_s[1].min(ends_s[1])];
            let long_s = told.span_s[1] - told.span_s[0];
            if span_s[1] - span_s[0] < LONG_S.min(0.9 * long_s) {
                continue;
            }
            let is_at_end = [
                span_s[0] - ends_s[0] <= AT_END_S,
                ends_s[1] - span_s[1] <= AT_END_S,
            ];
            let stamp = |end: usize| match is_at_end[end] {
                true => between[end],
                false => sketch.origin.after(span_s[end]),
            };
            found.push(SeenPhase {
                link,
                motion: told.motion,
                from: stamp(0),
                until: stamp(1),
                is_at_end,
            });
        }
    }
    found
}

/// What a body does, in order of time.
fn of_link(
    scene: &Scene,
    link: LinkIndex,
    own: &LocalMotions,
    motions: &TiVec<TrackIndex, Option<LocalMotions>>,
) -> Vec<ToldStretch> {
    let footings = footings(scene, link);
    let mut told: Vec<ToldStretch> = Vec::new();
    for stay in stays(scene, link, &footings, own) {
        let footing = &footings[stay.footing];
        let each = parts(scene, &scene.links[link], footing, own, &stay).into_iter();
        told.extend(each.map(|part| ToldStretch {
            motion: SeenMotion::On(part.on),
            span_s: part.span_s,
        }));
    }
    let is_rest = |of: &ToldStretch| matches!(of.motion, SeenMotion::On(on) if on.sustained == Sustained::Rest);
    let rests_s: Vec<[f64; 2]> = told
        .iter()
        .filter(|of| is_rest(of))
        .map(|of| of.span_s)
        .collect();
    for (track, other) in motions.iter_enumerated() {
        let (Some(other), with) = (other, scene.tracks[track].link) else {
            continue;
        };
        let carries = scene.is_held(with)
            || scene.links[with].body.mass_kg() > scene.links[link].body.mass_kg();
        if with == link || scene.are_joined(with, link) || !carries {
            continue;
        }
        for span_s in together(own, other) {
            for span_s in without(span_s, &rests_s) {
                // What it does on a surface meanwhile is the other's doing.
                told.retain(|of| {
                    of.span_s[1] <= span_s[0] || span_s[1] <= of.span_s[0] || is_rest(of)
                });
                told.push(ToldStretch {
                    motion: SeenMotion::With(with),
                    span_s,
                });
            }
        }
    }
    let known_s: Vec<[f64; 2]> = told.iter().map(|of| of.span_s).collect();
    for (carrying, span_s) in in_hand(scene, link, own, &known_s, &rests_s) {
        let motion = match carrying {
            Carrying::Hand => SeenMotion::InHand,
            Carrying::Still => SeenMotion::Still,
        };
        told.push(ToldStretch { motion, span_s });
    }
    let stays_s: Vec<[f64; 2]> = told.iter().map(|of| of.span_s).collect();
    told.extend(
        tumbling(scene, link, own, &stays_s).map(|span_s| ToldStretch {
            motion: SeenMotion::Tumble,
            span_s,
        }),
    );
    told.sort_by(|a, b| a.span_s[0].total_cmp(&b.span_s[0]));
    // What follows within a moment follows at once.
    for at in 1..told.len() {
        let between_s = told[at].span_s[0] - told[at - 1].span_s[1];
        if between_s.abs() <= MET_S && is_carried(&told[at - 1]) != is_carried(&told[at]) {
            let met_s = match is_carried(&told[at]) {
                true => told[at - 1].span_s[1],
                false => told[at].span_s[0],
            };
            told[at].span_s[0] = met_s;
            told[at - 1].span_s[1] = met_s;
        }
    }
    told
}

/// Whether a hand, or another body, carries it.
fn is_carried(of: &ToldStretch) -> bool {
    matches!(of.motion, SeenMotion::With(_) | SeenMotion::InHand)
}

/// What is left of a time without others, where it is long \[s\].
fn without(span_s: [f64; 2], others_s: &[[f64; 2]]) -> Vec<[f64; 2]> {
    let mut left = vec![span_s];
    for other in others_s {
        let parts = left.into_iter().flat_map(|of| {
            let before = [of[0], of[1].min(other[0])];
            let after = [of[0].max(other[1]), of[1]];
            match of[1] <= other[0] || other[1] <= of[0] {
                true => vec![of],
                false => vec![before, after],
            }
        });
        left = parts.filter(|of| of[1] - of[0] >= LONG_S).collect();
    }
    left
}
