//! First guesses of flights that begin where a hand lets go, and of which little is seen: as the hand moved then.

use super::between::is_fitted;
use crate::motion::held::Mounted;
use crate::motion::{Guess, Scene, Segment, Sketch};
use crate::physics::{State, flow};

/// Sets the states of such flights at their epochs; `rates` are the physical times that pass in a second of the segments'.
pub(super) fn place(
    scene: &Scene,
    sketch: &Sketch,
    segments: &[Segment],
    rates: &[f64],
    guess: &mut Guess,
) {
    for (index, segment) in segments.iter().enumerate() {
        let Some(event) = segment.start_event.filter(|_| !is_fitted(segment)) else {
            continue;
        };
        if let Some(state) = let_go(scene, sketch, segment, event, rates[index]) {
            let arc = &mut guess.arcs[index];
            let body = &scene.body_between(segment.mechanism, segment.ends());
            let since_s = arc.epoch_s - guess.event_times_s[event];
            arc.state = flow::advance(body, &scene.gravity_m_s2, &state, since_s);
        }
    }
}

/// The state in which a hand lets go of a body at an event.
fn let_go(
    scene: &Scene,
    sketch: &Sketch,
    segment: &Segment,
    event: usize,
    rate: f64,
) -> Option<State> {
    let phase = scene.grip_beside(segment.mechanism, event, false)?;
    let hand = scene.phases[phase].in_hand()?;
    let motion = sketch.grip(phase)?;
    let mounted = Mounted::new(&motion.at(sketch.marks_s[event]), &hand.link_from_tracker);
    Some(mounted.driven.at_rate(1.0 / rate).state)
}
