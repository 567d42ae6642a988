//! Samples that err in time: which err together, and which are left out.
//!
//! A hand does not feel an impact, so that its errors go on through it. Near an impact it rounds the motion's kink, which is
//! no error of the process: samples there are left out.

use std::ops::Range;

use nalgebra::{Matrix3, Vector3};

use super::gravity;
use crate::estimate::problem::influence::{Acting, Influence, lift_is_free};
use crate::estimate::problem::weave::{Kink, Kinks, Weave, WovenArc, WovenHand, WovenSample};
use crate::estimate::problem::{Arc, INFORMED_MIN, Problem, Shows, View};
use crate::estimate::unknowns::point::Point;
use crate::estimate::wander::kink::{APART_S, Rounding, is_near_kinks, kink_s};
use crate::estimate::wander::likelihood::LikelyErrors;
use crate::estimate::wander::{Filter, Process};
use crate::physics::flow;

/// What is left of an influence that is forgotten.
const FORGOTTEN: f64 = 1e-9;

impl Problem {
    /// The same problem where samples err in time; those near impacts of a motion are left out where a hand rounds them. The tempo's prior is that of
    /// the hand itself. Trackers on one body are in one hand.
    pub fn woven(&self, errors: &LikelyErrors, kinks: Kinks, at: &Point, epochs_s: &[f64]) -> Self {
        let mut hands: Vec<WovenHand> = Vec::new();
        // Which error of one tracker goes with which of another depends on how late a clock is.
        let mut roles = self.roles.iter();
        let by_track = roles.any(|role| matches!(role.influence, Influence::ClockOffset));
        for (index, arc) in self.arcs.iter().enumerate() {
            let counted_s = self.counted_s(arc, at);
            for (view, of) in arc.views.iter().enumerate() {
                let is_of = |hand: &WovenHand| {
                    let mut units = hand.units.iter().zip(&of.units);
                    hand.mechanism == arc.mechanism
                        && !(by_track && hand.track != of.track)
                        && units.all(|(a, b)| a == b || a.is_infinite() || b.is_infinite())
                };
                let place = hands.iter().position(is_of).unwrap_or_else(|| {
                    hands.push(WovenHand {
                        mechanism: arc.mechanism,
                        track: of.track,
                        units: of.units,
                        arcs: Vec::new(),
                        parameters: Vec::new(),
                    });
                    hands.len() - 1
                });
                let hand = &mut hands[place];
                hand.units = [0, 1].map(|kind| hand.units[kind].min(of.units[kind]));
                if hand.arcs.last().is_none_or(|last| last.arc != index) {
                    hand.arcs.push(WovenArc {
                        arc: index,
                        acting: Vec::new(),
                        samples: Vec::new(),
                        moved: self.moved_by(arc),
                        remembered: 0,
                        is_levered: arc.views.iter().any(|view| view.shows == Shows::Point)
                            || arc.body.lift() != 0.0
                            || lift_is_free(&arc.acting),
                        is_carried: arc.body.support().is_some(),
                    });
                }
                let woven = hand.arcs.last_mut().expect("just added");
                let mount = self.mount_at(index, of.track, &at.parameters);
                let zero_s = at.node_times_s.first().copied().unwrap_or(0.0);
                let physical_s = |sample: usize| {
                    let stamped_s = of.samples[sample].stamped_s(&at.node_times_s, &at.parameters);
                    mount.time_s(stamped_s, zero_s)
                };
                let samples = (0..of.samples.len()).map(|sample| WovenSample {
                    view,
                    sample,
                    // All trackers of a hand by one clock, as far as it is known.
                    acted_s: match self.times_are_unknown() {
                        true => of.samples[sample].time_s(&self.nodes_acted_s),
                        false => physical_s(sample),
                    },
                    noise_variances: noise_variances(of, sample),
                    gains: [None; 2],
                });
                let is_sharp = kinks == Kinks::Sharp;
                let is_counted = |woven: &WovenSample| {
                    is_sharp || (counted_s[0]..=counted_s[1]).contains(&physical_s(woven.sample))
                };
                let mut counted: Vec<WovenSample> = samples.clone().filter(is_counted).collect();
                // Where there are few, a kink is no worse than nothing.
                let are_few = counted.len() < INFORMED_MIN;
                if are_few {
                    counted = samples.collect();
                }
                let is_near = are_few || is_near_kinks(length_s(arc, &at.event_times_s));
                let mut last_s = f64::NEG_INFINITY;
                counted.retain(|of| {
                    let is_next = is_sharp || of.acted_s >= last_s + APART_S;
                    if is_next {
                        last_s = of.acted_s;
                    }
                    is_next
                });
                // In an unknown tempo, flights would become short to lie where samples tell little.
                if is_near && !is_sharp && !self.times_are_unknown() {
                    self.round_kinks(&mut counted, index, of, at, epochs_s);
                }
                woven.samples.extend(counted);
            }
        }
        for hand in &mut hands {
            for woven in &mut hand.arcs {
                woven
                    .samples
                    .sort_by(|a, b| a.acted_s.total_cmp(&b.acted_s));
            }
            for (kind, process) in errors.processes.iter().enumerate() {
                self.filter(hand, kind, process);
            }
        }
        self.woven_as(&Weave {
            errors: *errors,
            hands,
        })
    }

    /// The same problem where the samples err as those of another one that differs in its parameters alone.
    pub fn woven_as(&self, other: &Weave) -> Self {
        let mut weave = other.clone();
        for hand in &mut weave.hands {
            hand.parameters.clear();
            for woven in &mut hand.arcs {
                woven.acting = self.acting_on(&self.arcs[woven.arc]);
                let parameters = woven.acting.iter().map(|acting| acting.parameter);
                hand.parameters.extend(parameters);
            }
            hand.parameters.sort_unstable();
            hand.parameters.dedup();
        }
        let mut problem = self.clone();
        // What else is known counts once, beside samples that count as often as they tell something.
        for mark in &mut problem.marks {
            mark.sd_s *= mark.counted.sqrt();
            mark.counted = 1.0;
        }
        for view in problem.arcs.iter_mut().flat_map(|arc| &mut arc.views) {
            view.whitenings.clear();
            view.informations.clear();
        }
        for held in &mut problem.held {
            held.root /= held.motion.counted.sqrt();
            held.motion.counted = 1.0;
            let units = [self.position_unit_m, self.orientation_unit_rad];
            held.stray(&weave.errors.processes, units);
        }
        Self {
            weave: Some(weave),
            tempo_counts: 1.0,
            ..problem
        }
    }

    /// Finds how samples of a hand become independent in one kind, and for each of its flights the number of flights before it
    /// whose residuals still tell of its errors.
    fn filter(&self, hand: &mut WovenHand, kind: usize, process: &Process) {
        let mut filter = Filter::new(process);
        let scale = process.stationary().map_diagonal(f64::sqrt);
        let unscale = scale.map(|of| of.max(f64::MIN_POSITIVE).recip());
        // Of each flight before, by its place: what its end has become.
        let mut before: Vec<(usize, Matrix3<f64>)> = Vec::new();
        for (place, woven) in hand.arcs.iter_mut().enumerate() {
            let views = &self.arcs[woven.arc].views;
            let samples = woven.samples.iter_mut();
            for sample in samples.filter(|of| views[of.view].kinds()[kind]) {
                let gain = filter.next(&sample.instant(kind));
                sample.gains[kind] = Some(gain);
                for (first, left) in &mut before {
                    woven.remembered = woven.remembered.max(place - *first);
                    *left = gain.forgets() * *left;
                }
                before.retain(|(_, left)| relative(left, &scale, &unscale) > FORGOTTEN);
            }
            before.push((place, Matrix3::identity()));
        }
    }

    /// Nodes whose unknown times move a flight's samples: the first of all is the zero of time.
    fn moved_by(&self, arc: &Arc) -> Range<usize> {
        match arc.ends() {
            Some([first, last]) if self.times_are_unknown() => {
                first.node.max(1)..last.node + 1 + usize::from(last.share > 0.0)
            }
            _ => 0..0,
        }
    }

    /// Between which physical times samples of a flight count \[s\].
    fn counted_s(&self, arc: &Arc, at: &Point) -> [f64; 2] {
        let event_times_s = &at.event_times_s;
        let time_s = |event: Option<usize>| event.map(|event| event_times_s[event]);
        let (start_s, end_s) = (time_s(arc.start), time_s(arc.end));
        let kink_s = kink_s(length_s(arc, event_times_s));
        let is_kink = |event: Option<usize>| {
            let collisions = self.collisions.iter().map(|of| of.event);
            let mut kinks = collisions.chain(self.stickings.iter().map(|of| of.event));
            event.is_some_and(|event| kinks.any(|of| of == event))
        };
        let pressed_s = self.contact_s(arc.start, &at.parameters);
        let from_s = start_s
            .filter(|_| is_kink(arc.start))
            .map(|from_s| from_s + pressed_s);
        let to_s = end_s.filter(|_| is_kink(arc.end));
        [
            from_s.map_or(f64::NEG_INFINITY, |from_s| from_s + kink_s),
            to_s.map_or(f64::INFINITY, |to_s| to_s - kink_s),
        ]
    }

    /// Adds how a hand rounds the kinks at the ends of a flight to the noise of samples of one of its views.
    fn round_kinks(
        &self,
        samples: &mut [WovenSample],
        index: usize,
        view: &View,
        at: &Point,
        epochs_s: &[f64],
    ) {
        let [Some(first), Some(last)] = [samples.first(), samples.last()] else {
            return;
        };
        // One sample has no other like it.
        let apart_s = match samples.len() {
            1 => f64::INFINITY,
            count => (last.acted_s - first.acted_s) / (count - 1) as f64,
        };
        let rounding = Rounding::new(apart_s);
        for kink in self.kinks(|arc| arc == index, at, epochs_s) {
            for sample in &mut *samples {
                for kind in (0..2).filter(|kind| view.kinds()[*kind]) {
                    let jump_per_s = kink.jumps[kind].norm() / view.units[kind];
                    let since_s = sample.acted_s - kink.time_s;
                    sample.noise_variances[kind] += rounding.variance(since_s, jump_per_s);
                }
            }
        }
    }

    /// Impacts at the ends of some flights, and where bodies stick together.
    pub(in crate::estimate) fn kinks(
        &self,
        is_own: impl Fn(usize) -> bool,
        at: &Point,
        epochs_s: &[f64],
    ) -> Vec<Kink> {
        let gravity_m_s2 = self.gravity(&at.parameters);
        let velocities = |arc: usize, time_s: f64| {
            let body = self.body_of(arc);
            let state = flow::advance(body, &gravity_m_s2, &at.arcs[arc], time_s - epochs_s[arc]);
            [state.velocity_m_s, state.angular_velocity_rad_s]
        };
        let hit = self.collisions.iter();
        let hit = hit.map(|of| (of.event, of.sides.as_slice()));
        let stuck = self.stickings.iter();
        let stuck = stuck.map(|of| (of.event, of.sides.as_slice()));
        let sides = hit.chain(stuck).flat_map(|(event, sides)| {
            let sides = sides.iter();
            sides.map(move |pair| (at.event_times_s[event], pair))
        });
        let own = sides.filter(|(_, pair)| is_own(pair.before) || is_own(pair.after));
        let kinks = own.map(|(time_s, pair)| {
            let (before, after) = (
                velocities(pair.before, time_s),
                velocities(pair.after, time_s),
            );
            Kink {
                time_s,
                jumps: [0, 1].map(|kind| after[kind] - before[kind]),
            }
        });
        kinks.collect()
    }

    /// Parameters that act on a flight, with free gravity where it is a plain parabola, too.
    fn acting_on(&self, arc: &Arc) -> Vec<Acting> {
        if !arc.acting.is_empty() {
            return arc.acting.clone();
        }
        gravity(&self.gravity_parameters).collect()
    }
}

/// How long a flight between two events is \[s\]; infinite where it is between none.
fn length_s(arc: &Arc, event_times_s: &[f64]) -> f64 {
    match (arc.start, arc.end) {
        (Some(start), Some(end)) => event_times_s[end] - event_times_s[start],
        _ => f64::INFINITY,
    }
}

/// Variances of a sample's noise along an axis as its message says, in units of residuals.
fn noise_variances(view: &View, sample: usize) -> [f64; 2] {
    let Some(information) = view.informations.get(sample) else {
        return [0.0; 2];
    };
    let seen = view.kinds();
    let mut covariance = *information;
    for kind in (0..2).filter(|kind| !seen[*kind]) {
        for at in 3 * kind..3 * kind + 3 {
            covariance[(at, at)] = 1.0;
        }
    }
    let covariance = covariance.try_inverse().unwrap_or_default();
    [0, 1].map(|kind| {
        let own = covariance.fixed_view::<3, 3>(3 * kind, 3 * kind);
        match seen[kind] {
            true => own.trace() / 3.0 / view.units[kind].powi(2),
            false => 0.0,
        }
    })
}

/// The greatest entry of a matrix, in standard deviations of the process.
fn relative(matrix: &Matrix3<f64>, scale: &Vector3<f64>, unscale: &Vector3<f64>) -> f64 {
    (Matrix3::from_diagonal(unscale) * matrix * Matrix3::from_diagonal(scale)).amax()
}
