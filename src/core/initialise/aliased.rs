//! Flights that turn so fast that samples may show another turn.
//!
//! At samples a time `d` apart a rotation at `ω` about an axis `a` looks like those at
//!
//! ```text
//! ω + (2π n/d) a,   n = −1, 1
//! ```
//!
//! the way in which a wheel in a film seems to turn backwards. Which of them it is bounces tell: the point must reach the plane, and
//! the change of the angular velocity is that by the impulse there ([`Rebound::off_m`]). So all flights of a body are turned together.

use std::f64::consts::TAU;

use super::between::is_fitted;
use super::flights::Flights;
use super::readings::Readings;
use super::rebound::Rebound;
use super::turn::{OrientationReading, TurnFit, descend};
use crate::math::so3;
use crate::motion::{ArcGuess, Guess, MechanismIndex, Scene, Segment};
use crate::physics::State;

/// Least angle from one sample to the next \[rad\]: from less, the other turns are by nearly a whole turn or more.
const LEAST_RAD: f64 = 0.4;
/// Root mean square angle \[rad\] beyond which a turn is none that samples may show.
const FAR_RMS_RAD: f64 = 0.35;
/// By how much a body may have turned at a bounce beyond what its time says \[rad\].
const LATE_RAD: [f64; 5] = [0.0, -0.3, 0.3, -0.6, 0.6];
/// How many times as far off as the best way, in squares, flights as they are may be before that is tried: slow turns are likelier.
const CLEARLY: f64 = 1.5;
/// Greatest number of ways for all flights that are compared.
const COMPARED_MOST: usize = 16;

/// A guess with all flights turned as bounces tell, where that is clearly another way, and as it is.
pub(super) fn guesses(
    scene: &Scene,
    segments: &[Segment],
    readings: &[Readings],
    guess: Guess,
) -> Vec<Guess> {
    let mut turned = guess.clone();
    for mechanism in scene.mechanisms.keys() {
        let own = (0..segments.len()).filter(|at| segments[*at].mechanism == mechanism);
        let flights = AliasedFlights {
            mechanism,
            flights: Flights {
                scene,
                segments,
                own: own.collect(),
            },
            readings,
        };
        flights.turn(&mut turned);
    }
    match turned == guess {
        true => vec![guess],
        false => vec![turned, guess],
    }
}

/// The flights of one mechanism, with what samples show of them.
struct AliasedFlights<'a> {
    mechanism: MechanismIndex,
    flights: Flights<'a>,
    readings: &'a [Readings],
}

/// A state that the samples of a flight may show.
struct AliasedTurn {
    /// How far they are off \[m²\].
    off_m2: f64,
    /// At the flight's epoch.
    state: State,
}

/// A way in which all flights turn.
struct AliasedWay {
    /// How far bounces and samples are off \[m²\].
    off_m2: f64,
    /// The states of the flights at their epochs.
    states: Vec<State>,
}

impl AliasedFlights<'_> {
    /// Turns the flights as bounces tell best, where that is clearly better than as they are.
    fn turn(&self, guess: &mut Guess) {
        let own = self.flights.own.iter().enumerate();
        let shown = own.map(|(place, at)| {
            let is_told = self
                .rebound(place)
                .or_else(|| self.rebound(place + 1))
                .is_some();
            match is_told {
                true => self.shown(*at, guess),
                false => vec![AliasedTurn {
                    off_m2: 0.0,
                    state: guess.arcs[*at].state,
                }],
            }
        });
        let mut shown: Vec<Vec<AliasedTurn>> = shown.collect();
        if shown.iter().all(|of_flight| of_flight.len() == 1) {
            return;
        }
        let best = self.ways(guess, &shown).swap_remove(0);
        shown.iter_mut().for_each(|of_flight| of_flight.truncate(1));
        let plain = self.ways(guess, &shown).swap_remove(0);
        if best.off_m2 * CLEARLY < plain.off_m2 {
            for (at, state) in self.flights.own.iter().zip(&best.states) {
                guess.arcs[*at].state = *state;
            }
        }
    }

    /// The ways that are compared, the best first.
    fn ways(&self, guess: &Guess, shown: &[Vec<AliasedTurn>]) -> Vec<AliasedWay> {
        let mut ways = vec![AliasedWay {
            off_m2: 0.0,
            states: Vec::new(),
        }];
        for (place, of_flight) in shown.iter().enumerate() {
            let rebound = self.rebound(place);
            let further = ways.iter().flat_map(|way| {
                of_flight.iter().map(|shown| {
                    let rebound = rebound.as_ref().zip(way.states.last());
                    let off_m2 = rebound.map(|((event, rebound), before)| {
                        let states = [before, &shown.state];
                        self.off_m2(place, guess.event_times_s[*event], rebound, guess, states)
                    });
                    AliasedWay {
                        off_m2: way.off_m2 + shown.off_m2 + off_m2.unwrap_or(0.0),
                        states: way.states.iter().copied().chain([shown.state]).collect(),
                    }
                })
            });
            ways = further.collect();
            ways.sort_by(|a, b| a.off_m2.total_cmp(&b.off_m2));
            ways.truncate(COMPARED_MOST);
        }
        ways
    }

    /// The bounce between a flight and the one before it, and its event.
    fn rebound(&self, place: usize) -> Option<(usize, Rebound<'_>)> {
        let Flights {
            scene,
            segments,
            own,
        } = &self.flights;
        let before = own[place.checked_sub(1)?];
        let pair = [before, *own.get(place)?].map(|at| &segments[at]);
        let event = pair[1].start_event?;
        let is_told = pair[0].end_event == Some(event) && pair.iter().all(|of| is_fitted(of));
        let rebound = Rebound::of(scene, self.mechanism, event)?;
        is_told.then_some((event, rebound))
    }

    /// How far a flight and the one before it, with such states, are off at a bounce between them \[m²\], at the best moment near
    /// the time at which it is thought to be.
    fn off_m2(
        &self,
        place: usize,
        time_s: f64,
        rebound: &Rebound,
        guess: &Guess,
        states: [&State; 2],
    ) -> f64 {
        let own = [place - 1, place].map(|place| self.flights.own[place]);
        let at = |time_s: f64| {
            [0, 1].map(|side| {
                let arc = &guess.arcs[own[side]];
                let arc = ArcGuess {
                    epoch_s: arc.epoch_s,
                    state: *states[side],
                    sample_times_s: Vec::new(),
                };
                self.flights.advanced(&arc, own[side], time_s)
            })
        };
        let spins = states.map(|state| state.angular_velocity_rad_s.norm());
        let spin_rad_s = (0.5 * (spins[0] + spins[1])).max(f64::MIN_POSITIVE);
        let moments = LATE_RAD.map(|late_rad| time_s + late_rad / spin_rad_s);
        let off_m2 = moments.map(|time_s| rebound.off_m(&at(time_s)).norm_squared());
        off_m2.into_iter().fold(f64::INFINITY, f64::min)
    }

    /// What a flight's samples may show, its state of the guess first.
    fn shown(&self, at: usize, guess: &Guess) -> Vec<AliasedTurn> {
        let Flights {
            scene, segments, ..
        } = &self.flights;
        let segment = &segments[at];
        let (arc, readings) = (&guess.arcs[at], &self.readings[at]);
        let state = arc.state;
        let plain = |off_m2| AliasedTurn { off_m2, state };
        let is_free = scene
            .phase_between(segment.mechanism, segment.ends())
            .is_none();
        let is_whole = readings.pointed.is_none() && readings.lever_m.is_none();
        let spin_rad_s = state.angular_velocity_rad_s.norm();
        let is_fast = |apart_s: &f64| spin_rad_s * apart_s >= LEAST_RAD;
        let apart_s = apart_s(readings).filter(is_fast);
        let is_flight = is_fitted(segment) && is_free && is_whole;
        let Some(apart_s) = apart_s.filter(|_| is_flight) else {
            return vec![plain(0.0)];
        };
        let body = scene.body_of(segment.mechanism);
        let turns = readings.turns.iter();
        let turns: Vec<OrientationReading> = turns
            .map(|(acted_s, turn)| (acted_s - arc.epoch_s, *turn))
            .collect();
        let axis = state.angular_velocity_rad_s / spin_rad_s;
        let [as_it_is, others @ ..] = [0.0, -1.0, 1.0].map(|more| {
            let more_rad_s = axis * (more * TAU / apart_s);
            // As it is at the first sample.
            let turned = so3::exp(&(more_rad_s * -turns[0].0));
            let from = TurnFit {
                orientation: state.orientation * turned,
                angular_velocity_rad_s: state.angular_velocity_rad_s + more_rad_s,
                square_rad2: f64::INFINITY,
                iterations: 0,
            };
            descend(body, &turns, from)
        });
        let count = turns.len() as f64;
        let arm_m2 = body.gyration_m2().mean();
        let off_m2 = |fit: &TurnFit| arm_m2 * fit.square_rad2 / count;
        let far_rad2 = count * FAR_RMS_RAD * FAR_RMS_RAD;
        let near = others.iter().filter(|fit| fit.square_rad2 <= far_rad2);
        let turned = near.map(|fit| AliasedTurn {
            off_m2: off_m2(fit),
            state: State {
                orientation: fit.orientation,
                angular_velocity_rad_s: fit.angular_velocity_rad_s,
                ..state
            },
        });
        [plain(off_m2(&as_it_is))]
            .into_iter()
            .chain(turned)
            .collect()
    }
}

/// The middle one of the times between samples of orientations \[s\].
fn apart_s(readings: &Readings) -> Option<f64> {
    let pairs = readings.turns.windows(2);
    let mut apart_s: Vec<f64> = pairs.map(|pair| pair[1].0 - pair[0].0).collect();
    apart_s.sort_by(f64::total_cmp);
    let middle_s = apart_s.get(apart_s.len() / 2).copied();
    middle_s.filter(|middle_s| *middle_s > 0.0)
}
