//! First guesses of what no track shows of a flight: its rotation ([`twirl`](super::twirl)), or its path.
//!
//! Goals and the flights beside it say where it begins and ends; where neither does, it ends as the nearest
//! event that is known. Between both ends it falls.

use std::iter;

use nalgebra::Vector3;

use super::between::is_fitted;
use super::flights::{Flights, nearest};
use super::readings::Readings;
use super::twirl::Twirl;
use crate::motion::{GoalTarget, Guess, MechanismIndex, Scene, Segment};

/// A guess with what is not seen of the fitted flights: the least motion, then, where rebounds tell how
/// fast a body turns, those.
pub(super) fn guesses(
    scene: &Scene,
    segments: &[Segment],
    readings: &[Readings],
    mut guess: Guess,
) -> Vec<Guess> {
    let is_placed = |at: &usize| !readings[*at].places.is_empty();
    let is_turned = |at: &usize| !readings[*at].turns.is_empty() || readings[*at].lever_m.is_some();
    let mut to_turn = Vec::new();
    for mechanism in scene.mechanisms.keys() {
        let own = (0..segments.len()).filter(|at| segments[*at].mechanism == mechanism);
        let own: Vec<usize> = own.filter(|at| is_fitted(&segments[*at])).collect();
        let flights = Flights {
            scene,
            segments,
            own,
        };
        if !flights.own.iter().all(is_placed) {
            flights.place(mechanism, is_placed, &mut guess);
        }
        if !flights.own.iter().all(is_turned) {
            to_turn.push((mechanism, flights));
        }
    }
    if to_turn.is_empty() {
        return vec![guess];
    }
    let turned = |twirl| {
        let mut guess = guess.clone();
        let mut is_told = false;
        for (mechanism, flights) in &to_turn {
            is_told |= flights.turn(*mechanism, is_turned, twirl, &mut guess);
        }
        (guess, is_told)
    };
    let (least, _) = turned(None);
    let told = Twirl::all().map(|twirl| turned(Some(twirl)));
    let told = told.take_while(|(_, is_told)| *is_told);
    iter::once(least)
        .chain(told.map(|(guess, _)| guess))
        .collect()
}

impl Flights<'_> {
    fn place(
        &self,
        mechanism: MechanismIndex,
        is_placed: impl Fn(&usize) -> bool,
        guess: &mut Guess,
    ) {
        let mut known = self.at_goals(mechanism, |target| match target {
            GoalTarget::Pose { world_from_body } => Some(world_from_body.translation.vector),
            _ => None,
        });
        self.at_ends(&mut known, &is_placed, guess, |state| state.position_m);
        let pull_m_s2 = self.pull_m_s2(mechanism);
        for at in self.own.iter().filter(|at| !is_placed(at)) {
            let [start, end] = self.ends_s(*at, guess);
            let [from_m, to_m] = self.ends_of(*at).map(|event| nearest(&known, event));
            let from_m = from_m.or(to_m).unwrap_or_default();
            let to_m = to_m.unwrap_or(from_m);
            let lasts_s = (end - start).max(1e-3);
            let arc = &mut guess.arcs[*at];
            let since_s = arc.epoch_s - start;
            let velocity_m_s = (to_m - from_m) / lasts_s - pull_m_s2 * (0.5 * lasts_s);
            arc.state.position_m =
                from_m + velocity_m_s * since_s + pull_m_s2 * (0.5 * since_s * since_s);
            arc.state.velocity_m_s = velocity_m_s + pull_m_s2 * since_s;
        }
    }

    fn pull_m_s2(&self, mechanism: MechanismIndex) -> Vector3<f64> {
        let body = self.scene.body_of(mechanism);
        body.pull_m_s2(&self.scene.gravity_m_s2)
    }
}
