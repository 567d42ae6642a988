//! First guesses of the rotation of flights of which no track shows it.
//!
//! Goals and the flights beside it say how a flight begins and ends; where neither does, it ends as the
//! nearest event that is known, and a point that touches a plane is turned as little as lets it reach it.
//! Between both ends it turns at a constant rate by the shortest way: the least motion.
//!
//! Where a rebound tells how fast the body turns ([`Rebound`]) that is tried too: the least motion may end
//! in another optimum, which misses what the centre's path shows of a twirl.

use std::f64::consts::{PI, TAU};

use nalgebra::{UnitQuaternion, Vector3};

use super::flights::{Flights, Known, nearest};
use super::rebound::{Rebound, ReboundSpin};
use crate::math::so3;
use crate::motion::{GoalTarget, Guess, MechanismIndex};

/// A way in which a body may turn that bounces. A hand's wander spoils what a rebound tells, so that there are
/// several.
#[derive(Clone, Copy, Debug)]
pub(super) struct Twirl {
    /// In which direction its point touches, about the normal from the nearest one \[rad\].
    heading_rad: f64,
    /// Whole turns of a flight between two known orientations beyond those nearest to what is told.
    turns: f64,
}

impl Twirl {
    /// All that are tried.
    pub(super) fn all() -> impl Iterator<Item = Self> {
        let turns = |heading_rad| [0.0, 1.0, -1.0].map(|turns| Self { heading_rad, turns });
        [0.0, PI].into_iter().flat_map(turns)
    }
}

/// What is known of a mechanism's rotation at events.
struct ToldTwirl {
    orientations: Known<UnitQuaternion<f64>>,
    spins: Known<ReboundSpin>,
}

impl Flights<'_> {
    /// Turns what is not seen to turn: as rebounds tell, else as little as may be. Returns whether rebounds
    /// tell something.
    pub(super) fn turn(
        &self,
        mechanism: MechanismIndex,
        is_turned: impl Fn(&usize) -> bool,
        twirl: Option<Twirl>,
        guess: &mut Guess,
    ) -> bool {
        let told = self.told(mechanism, &is_turned, twirl, guess);
        // Backwards: what a rebound leads to tells how fast the body came.
        for at in self.own.iter().rev().filter(|at| !is_turned(at)) {
            let [start_s, end_s] = self.ends_s(*at, guess);
            let lasts_s = (end_s - start_s).max(1e-3);
            let (from, turn) = self.turned(*at, lasts_s, &told, twirl, guess);
            let rate_rad_s = turn / lasts_s;
            let arc = &mut guess.arcs[*at];
            let since_s = arc.epoch_s - start_s;
            arc.state.orientation = from * so3::exp(&(rate_rad_s * since_s));
            arc.state.angular_velocity_rad_s = rate_rad_s;
        }
        !told.spins.is_empty()
    }

    fn told(
        &self,
        mechanism: MechanismIndex,
        is_turned: impl Fn(&usize) -> bool,
        twirl: Option<Twirl>,
        guess: &Guess,
    ) -> ToldTwirl {
        let mut orientations = self.at_goals(mechanism, |target| match target {
            GoalTarget::Pose { world_from_body } => Some(world_from_body.rotation),
            _ => None,
        });
        self.at_ends(&mut orientations, is_turned, guess, |state| {
            state.orientation
        });
        let events = self.own.iter().flat_map(|at| self.ends_of(*at)).flatten();
        let open = events.filter(|event| !orientations.contains_key(event));
        let mut touching = Known::new();
        let mut spins = Known::new();
        for event in open {
            let Some(rebound) = Rebound::of(self.scene, mechanism, event) else {
                continue;
            };
            let like = nearest(&orientations, Some(event)).unwrap_or_default();
            let [before, after] = self.beside(event, guess);
            let centre_m = before.or(after).expect("it ends a flight").position_m;
            let Some(twirl) = twirl else {
                touching.insert(event, rebound.touching(&centre_m, &like));
                continue;
            };
            let leaning = rebound.leaning(&centre_m, &like, twirl.heading_rad);
            touching.insert(event, leaning);
            let both = before.zip(after);
            let spin =
                both.and_then(|(before, after)| rebound.spin_rad_s(&leaning, [&before, &after]));
            spins.extend(spin.map(|spin| (event, spin)));
        }
        orientations.extend(touching);
        ToldTwirl {
            orientations,
            spins,
        }
    }

    /// The orientation at the beginning of a flight, and the turn until its end \[rad, body\].
    fn turned(
        &self,
        at: usize,
        lasts_s: f64,
        told: &ToldTwirl,
        twirl: Option<Twirl>,
        guess: &Guess,
    ) -> (UnitQuaternion<f64>, Vector3<f64>) {
        let [start, end] = self.ends_of(at);
        let of = |event: Option<usize>| told.orientations.get(&event?).copied();
        let left = start.and_then(|event| {
            let spin = told.spins.get(&event)?;
            Some(spin.mean_rad_s + spin.change_rad_s * 0.5)
        });
        let came = end.and_then(|event| {
            let spin = told.spins.get(&event)?;
            let after = self.beside(event, guess)[1]?;
            Some(after.orientation * after.angular_velocity_rad_s - spin.change_rad_s)
        });
        match (of(start), of(end), left, came) {
            (Some(from), None, Some(left), _) => (from, from.inverse() * left * lasts_s),
            (None, Some(to), _, Some(came)) => {
                let turn = to.inverse() * came * lasts_s;
                (to * so3::exp(&-turn), turn)
            }
            _ => {
                let orientations = &told.orientations;
                let from = nearest(orientations, start).or(nearest(orientations, end));
                let from = from.unwrap_or_default();
                let to = nearest(orientations, end).unwrap_or(from);
                let shortest = so3::log(&(from.inverse() * to));
                let left = left.map(|left| from.inverse() * left * lasts_s);
                let more = twirl.map_or(0.0, |twirl| twirl.turns);
                (from, wound(&shortest, &left.unwrap_or_default(), more))
            }
        }
    }
}

/// A turn with as many whole ones about its axis as lead nearest to another, and some more \[rad\].
fn wound(turn: &Vector3<f64>, to: &Vector3<f64>, more: f64) -> Vector3<f64> {
    let axis = turn.try_normalize(1e-6).or(to.try_normalize(1e-6));
    let axis = axis.unwrap_or_default();
    turn + axis * (TAU * (((to - turn).dot(&axis) / TAU).round() + more))
}
