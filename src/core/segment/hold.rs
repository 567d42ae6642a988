//! The motions of the bodies in the hand, from their samples.

use super::cut::median_interval_s;
use super::error::SegmentError;
use super::smooth::{SAMPLES_MIN, smoothed};
use crate::motion::{Grip, Held, HeldMotion, InHand, Scene, Sketch, SupportPhase, TrackIndex};
use crate::physics::Sustained;

/// A collision is seen if samples before and after it are nearer than this \[s\].
const SEEN_S: f64 = 0.1;

/// Joined bodies hang from a hand that is seen at least so often \[s\].
const GAP_S: f64 = 0.1;

/// The motion of what is picked up is told from so long before on \[s\].
const PICKED_S: f64 = 0.1;

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
    grip(scene, sketch)
}

/// Sets the motions of what is in a hand for a while; where they were known, they count as often as before.
///
/// Fails as [`hold`] does.
pub fn grip(scene: &Scene, sketch: &mut Sketch) -> Result<(), SegmentError> {
    let known: Vec<Grip> = sketch
        .tracks
        .iter_mut()
        .flat_map(|track| std::mem::take(&mut track.grips))
        .collect();
    for (index, phase) in scene.phases.iter().enumerate() {
        let Some(hand) = phase.in_hand() else {
            continue;
        };
        if !scene.moves(scene.mechanism_of(phase.link)) {
            continue;
        }
        let hits = phase.events.into_iter();
        let hits = hits.filter(|event| scene.events[*event].kind.change().is_some());
        let hits: Vec<(usize, f64)> = hits.map(|event| (event, sketch.marks_s[event])).collect();
        let mut motion = match &scene.link_seen_by(hand.track).held {
            // The hand itself is tracked, and moves on.
            Some(held) => of_hand(scene, sketch, hand.track, held, hits)?,
            None => gripped(scene, sketch, hand, phase.events, &hits)?,
        };
        if !motion.is_finite() {
            return Err(SegmentError::HeldNotFinite {
                body: scene.links[phase.link].name.clone(),
            });
        }
        // How often it counts was found with flights that were cut otherwise.
        if let Some(known) = known.iter().find(|known| known.phase == index) {
            motion.counted = known.motion.counted;
        }
        let grips = &mut sketch.tracks[hand.track].grips;
        grips.push(Grip {
            phase: index,
            motion,
        });
    }
    Ok(())
}

/// What a body's own tracker shows of it while it is in a hand.
fn gripped(
    scene: &Scene,
    sketch: &Sketch,
    hand: &InHand,
    events: [usize; 2],
    hits: &[(usize, f64)],
) -> Result<HeldMotion, SegmentError> {
    let of = &sketch.tracks[hand.track];
    let interval_s = median_interval_s(of);
    // As beside a collision, a sample next to a change may belong to either side.
    let beside_s = events.map(|event| match scene.events[event].kind.change() {
        Some(_) => interval_s,
        None => 0.0,
    });
    // What is picked up lies still in the hand, too: its motion begins so smoothly that nothing tells when.
    let mechanism = scene.mechanism_seen_by(hand.track);
    let before = scene.phase_beside(mechanism, events[0], false);
    let lay = before.and_then(SupportPhase::on_surface);
    let is_picked_up = lay.is_some_and(|on| on.sustained == Sustained::Rest);
    let begun_s = if is_picked_up { -PICKED_S } else { beside_s[0] };
    let from_s = sketch.marks_s[events[0]] + begun_s;
    let until_s = sketch.marks_s[events[1]] - beside_s[1];
    let first = of.samples.partition_point(|of| of.acted_s < from_s);
    let last = of.samples.partition_point(|of| of.acted_s <= until_s);
    let samples = &of.samples[first..last.max(first)];
    if samples.len() < SAMPLES_MIN {
        return Err(SegmentError::HeldSamples {
            body: scene.link_seen_by(hand.track).name.clone(),
            samples: samples.len(),
            expected: SAMPLES_MIN,
        });
    }
    let tracker = Held::default();
    Ok(smoothed(
        samples,
        interval_s,
        &hand.link_from_tracker,
        &tracker,
        hits,
    ))
}

fn motion(
    scene: &Scene,
    sketch: &Sketch,
    track: TrackIndex,
    held: &Held,
) -> Result<HeldMotion, SegmentError> {
    let link = scene.tracks[track].link;
    let hits = (0..scene.events.len()).filter(|event| {
        let collision = scene.events[*event].kind.collision();
        collision.is_some_and(|collision| collision.links().any(|other| other == link))
    });
    let hits = hits.map(|event| (event, sketch.marks_s[event])).collect();
    of_hand(scene, sketch, track, held, hits)
}

/// How the tracker of a held body moves, which hits something, lets go of something or catches it at these events.
fn of_hand(
    scene: &Scene,
    sketch: &Sketch,
    track: TrackIndex,
    held: &Held,
    hits: Vec<(usize, f64)>,
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
    if scene.carries(scene.tracks[track].link) {
        check_gaps(scene, sketch, track)?;
    }
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
        &of.samples,
        median_interval_s(of),
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
