//! Flights of one mechanism, followed from collision to collision.

use std::cmp::Ordering;

use nalgebra::{SVector, Vector3};

use super::flown::{KeyPose, KeyedFlight, Parts, keys, parts};
use super::turns;
use crate::initialise::ballistic::{self, Place};
use crate::initialise::turn::OrientationReading;
use crate::math::so3;
use crate::motion::{MechanismIndex, Observer, Partner, Scene, Segment, Sketch, Timing};
use crate::physics::State;
use crate::physics::contact::Frame;
use crate::physics::impact::{ContactSet, Law, Side};
use crate::physics::state::DIMENSION;

/// Greatest number of ways that are followed.
const WAYS: usize = 64;
/// Longest time from a keyframe to a collision where no clock tells \[s\].
const REACH_S: f64 = 1.5;
/// Contacts are looked for at this spacing \[s\], or at a finer one where the body turns by more
/// than this in between \[rad\].
const SCAN_S: f64 = 0.01;
const SCAN_RAD: f64 = 0.15;
/// Greatest number of steps to a contact's time.
const REFINEMENTS: usize = 40;
/// Sum of squares, in tolerances, below which keyframes are met.
pub(super) const MET: f64 = 1e-9;
/// Differences at a collision that cost as much as one another: of places \[m\], orientations
/// \[rad\], velocities [m/s], angular velocities [rad/s].
const TOLERANCES: [f64; 4] = [0.02, 0.2, 0.3, 3.0];

/// What happens where two flights meet.
#[derive(Clone, Debug)]
struct Hit {
    contacts: ContactSet,
    law: Law,
}

impl Hit {
    /// Gap of the first contact \[m\].
    fn gap_m(&self, state: &State) -> Option<f64> {
        let contact = self.contacts.as_slice().first()?;
        let touch = contact.touch(&Frame::of(state), &Frame::world()).ok()?;
        Some(touch.gap_m)
    }
}

/// The flights of one mechanism, with their keyframes.
pub(super) struct KeyedCourse<'a> {
    pub(super) scene: &'a Scene,
    pub(super) mechanism: MechanismIndex,
    /// Keyframes of each flight.
    pub(super) samples: Vec<Vec<KeyPose>>,
    /// What else is seen of each flight.
    parts: Vec<Parts>,
    /// Between each flight and the next: what is known of the collision, and its mark \[s\].
    hits: Vec<(Option<Hit>, f64)>,
}

/// A motion through the first flights of a course.
#[derive(Clone, Debug)]
pub(super) struct Way {
    /// Flights on their own clocks.
    pub(super) flights: Vec<KeyedFlight>,
    /// What their clocks are behind the time line \[s\].
    pub(super) offsets_s: Vec<f64>,
    /// Ends of all flights but the last, on the time line \[s\].
    pub(super) ends_s: Vec<f64>,
    /// Sum of squared differences, in tolerances.
    pub(super) cost: f64,
}

/// The end of a flight at a collision.
struct TouchArrival {
    /// On the time line \[s\].
    time_s: f64,
    before: State,
    /// After the impact, if it is known.
    after: Option<State>,
    cost: f64,
}

impl<'a> KeyedCourse<'a> {
    pub(super) fn new(
        scene: &'a Scene,
        sketch: &'a Sketch,
        mechanism: MechanismIndex,
        own: &[usize],
        segments: &[Segment],
    ) -> Self {
        let hit = |event: usize| {
            let collision = scene.events[event].kind.collision()?;
            // What is left open is known where only one thing can touch.
            let candidates = if scene.is_open(event) {
                scene.candidates(event)
            } else {
                vec![collision.contacts.clone()]
            };
            let [touching] = candidates.as_slice() else {
                return None;
            };
            let contacts = scene.contact_set_of(event, touching).ok()??;
            (collision.partner == Partner::World).then_some(Hit {
                contacts,
                law: scene.impact_law(collision),
            })
        };
        let joints = own
            .windows(2)
            .filter_map(|pair| segments[pair[0]].end_event);
        Self {
            scene,
            mechanism,
            samples: own
                .iter()
                .map(|index| keys(sketch, &segments[*index]).expect("flights of keyframes"))
                .collect(),
            parts: own
                .iter()
                .map(|index| parts(scene, sketch, &segments[*index]))
                .collect(),
            hits: joints
                .map(|event| (hit(event), sketch.marks_s[event]))
                .collect(),
        }
    }

    /// The best motions through all flights; none where a flight's keyframes and its neighbours
    /// lead to none.
    pub(super) fn ways(&self, most: usize, observer: &mut dyn Observer) -> Vec<Way> {
        let begins = |flown: KeyedFlight| Way {
            flights: vec![flown],
            offsets_s: vec![0.0],
            ends_s: Vec::new(),
            cost: 0.0,
        };
        let mut ways: Vec<Way> = match self.samples[0].len() {
            0 => return Vec::new(),
            1 => vec![begins(self.begun(&SVector::zeros()))],
            _ => self.alone(0).into_iter().map(begins).collect(),
        };
        for next in 1..self.samples.len() {
            let alone = self.alone(next);
            ways = ways
                .iter()
                .flat_map(|way| self.continued(way, &alone))
                .collect();
            ways.sort_by(Way::order);
            // Without time for more the best one alone goes on.
            ways.truncate(if observer.should_stop() { 1 } else { WAYS });
        }
        ways.truncate(most);
        ways
    }

    /// The first flight, from its first keyframe with these velocities.
    pub(super) fn begun(&self, velocities: &SVector<f64, 6>) -> KeyedFlight {
        let sample = &self.samples[0][0];
        KeyedFlight {
            epoch_s: sample.acted_s,
            state: State {
                position_m: sample.position_m,
                orientation: sample.orientation,
                velocity_m_s: velocities.fixed_rows::<3>(0).into(),
                angular_velocity_rad_s: velocities.fixed_rows::<3>(3).into(),
            },
        }
    }

    fn is_edited(&self) -> bool {
        self.scene.timing == Timing::Edited
    }

    pub(super) fn is_known(&self) -> bool {
        self.hits.iter().all(|(hit, _)| hit.is_some())
    }

    /// Number of numbers that the keyframes give.
    pub(super) fn numbers(&self) -> usize {
        let samples = self.samples.iter().map(|samples| samples.len());
        6 * samples.sum::<usize>()
    }

    /// Number of unknowns that impacts leave: the first state, and a clock of each later flight
    /// where no common one tells.
    pub(super) fn unknowns(&self) -> usize {
        let clocks = if self.is_edited() { self.hits.len() } else { 0 };
        DIMENSION + clocks
    }

    /// Times from the first keyframe to the first collision to try \[s\]: to its mark, or `otherwise`
    /// where no clock tells.
    pub(super) fn until_s(&self, otherwise: &[f64]) -> Vec<f64> {
        match (self.hits.first(), self.samples[0].last()) {
            (Some((_, mark_s)), Some(last)) if !self.is_edited() => vec![mark_s - last.acted_s],
            _ => otherwise.to_vec(),
        }
    }

    /// Time between the first keyframe and the next \[s\], where a clock tells.
    pub(super) fn between_s(&self) -> Option<f64> {
        let mut all = self.samples.iter().flat_map(|flight| flight.iter());
        let (first, next) = (all.next()?, all.next()?);
        (!self.is_edited()).then_some(next.acted_s - first.acted_s)
    }

    /// Gap of the first collision's contact in a flight at a time on its clock \[m\].
    pub(super) fn gap_m(&self, flown: &KeyedFlight, time_s: f64) -> Option<f64> {
        let hit = self.hits.first()?.0.as_ref()?;
        let state = flown.at(self.scene, self.mechanism, time_s);
        hit.gap_m(&state)
    }

    /// Flights through the keyframes of one, if there are two or more.
    fn alone(&self, flight: usize) -> Vec<KeyedFlight> {
        let samples = self.samples[flight].as_slice();
        let [first, .., last] = samples else {
            return Vec::new();
        };
        let body = self.scene.body_of(self.mechanism);
        let epoch_s = 0.5 * (first.acted_s + last.acted_s);
        let pull_m_s2 = body.pull_m_s2(&self.scene.gravity_m_s2);
        let parts = &self.parts[flight];
        let mut places: Vec<Place> = samples
            .iter()
            .map(|key| (key.acted_s, key.position_m))
            .chain(parts.places.iter().copied())
            .collect();
        places.sort_by(|a, b| a.0.total_cmp(&b.0));
        let fall = ballistic::fit(&places, epoch_s, &pull_m_s2, Some(1.0));
        let mut readings: Vec<OrientationReading> = samples
            .iter()
            .map(|key| (key.acted_s, key.orientation))
            .chain(parts.turns.iter().copied())
            .map(|(acted_s, turn)| (acted_s - epoch_s, turn))
            .collect();
        readings.sort_by(|a, b| a.0.total_cmp(&b.0));
        let turns = turns::turns(body, &readings).into_iter();
        turns
            .map(|turn| KeyedFlight {
                epoch_s,
                state: State {
                    position_m: fall.position_m,
                    orientation: turn.orientation,
                    velocity_m_s: fall.acted_velocity_m_s,
                    angular_velocity_rad_s: turn.angular_velocity_rad_s,
                },
            })
            .collect()
    }

    /// A way with one more flight: every one through its own keyframes (`alone`), or that into
    /// which the collision leads.
    fn continued(&self, way: &Way, alone: &[KeyedFlight]) -> Vec<Way> {
        let next = way.flights.len();
        if alone.is_empty() {
            return vec![self.handed_on(way)];
        }
        let arrival = self.arrival(way);
        let joined = alone.iter().filter_map(|flown| {
            let met;
            let arrival = match &arrival {
                Some(arrival) => arrival,
                None => {
                    met = self.meeting(way, flown);
                    &met
                }
            };
            let begin_s = if self.is_edited() {
                let first_s = self.samples[next].first()?.acted_s;
                let at = |s: f64| flown.at(self.scene, self.mechanism, first_s - s);
                let off = |s: f64| at(s).position_m - arrival.before.position_m;
                first_s - least(off, REACH_S)
            } else {
                arrival.time_s
            };
            let begun = flown.at(self.scene, self.mechanism, begin_s);
            let to = arrival.after.as_ref().unwrap_or(&arrival.before);
            let off = begun.minus(to);
            let parts = if arrival.after.is_some() { 4 } else { 2 };
            let cost = (0..parts).map(|part| {
                let size = off.fixed_rows::<3>(3 * part).norm() / TOLERANCES[part];
                size * size
            });
            let cost = arrival.cost + cost.sum::<f64>();
            Some(way.with(*flown, arrival.time_s - begin_s, arrival.time_s, cost))
        });
        joined.collect()
    }

    /// The way with the flight into which the impact leads; straight on where that is unknown.
    pub(super) fn handed_on(&self, way: &Way) -> Way {
        let arrival = self.arrival(way).unwrap_or_else(|| self.at_the_mark(way));
        let after = arrival.after.unwrap_or(arrival.before);
        let samples = &self.samples[way.flights.len()];
        let left = KeyedFlight {
            state: after,
            epoch_s: 0.0,
        };
        let at = |s: f64| left.at(self.scene, self.mechanism, s);
        let (since_s, offset_s) = match samples.first() {
            Some(sample) if self.is_edited() => {
                let since_s = least(|s| self.off(sample, &at(s)), REACH_S);
                (since_s, arrival.time_s + since_s - sample.acted_s)
            }
            Some(sample) => (sample.acted_s - arrival.time_s, 0.0),
            None => (0.0, 0.0),
        };
        let flown = KeyedFlight {
            state: at(since_s),
            epoch_s: arrival.time_s + since_s - offset_s,
        };
        let off = samples.iter().map(|sample| {
            let then = flown.at(self.scene, self.mechanism, sample.acted_s);
            self.off(sample, &then).norm_squared()
        });
        let cost = arrival.cost + off.sum::<f64>();
        way.with(flown, offset_s, arrival.time_s, cost)
    }

    /// The last flight of a way at its mark, or, where no clock tells, at its last keyframe.
    fn at_the_mark(&self, way: &Way) -> TouchArrival {
        let (flown, offset_s) = way.last();
        let (from_s, to_s) = self.window_s(way);
        let mark_s = self.hits[way.flights.len() - 1].1;
        let time_s = if self.is_edited() {
            from_s
        } else {
            mark_s.clamp(from_s, to_s)
        };
        TouchArrival {
            time_s: time_s + offset_s,
            before: flown.at(self.scene, self.mechanism, time_s),
            after: None,
            cost: 0.0,
        }
    }

    /// Difference of a state from a keyframe, in tolerances.
    pub(super) fn off(&self, sample: &KeyPose, state: &State) -> SVector<f64, 6> {
        let shift = (state.position_m - sample.position_m) / TOLERANCES[0];
        let turn = sample.orientation.inverse() * state.orientation;
        let turn = so3::log(&turn) / TOLERANCES[1];
        SVector::from([shift.x, shift.y, shift.z, turn.x, turn.y, turn.z])
    }

    /// Where the last flight of a way meets another on its own clock; physical times, or no known
    /// contact.
    fn meeting(&self, way: &Way, next: &KeyedFlight) -> TouchArrival {
        let (flown, offset_s) = way.last();
        let (from_s, to_s) = self.window_s(way);
        let at = |s: f64| flown.at(self.scene, self.mechanism, from_s + s);
        let since_s = if self.is_edited() {
            let first = self.samples[way.flights.len()].first();
            let first_s = first.map_or(next.epoch_s, |key| key.acted_s);
            let before = |s: f64| next.at(self.scene, self.mechanism, first_s - s);
            crossing(at, before, REACH_S)[0]
        } else {
            let off = |s: f64| {
                let there = next.at(self.scene, self.mechanism, from_s + s);
                there.position_m - at(s).position_m
            };
            least(off, to_s - from_s)
        };
        TouchArrival {
            time_s: from_s + since_s + offset_s,
            before: at(since_s),
            after: None,
            cost: 0.0,
        }
    }

    /// The end of the last flight of a way, where the contact is known.
    fn arrival(&self, way: &Way) -> Option<TouchArrival> {
        let hit = self.hits[way.flights.len() - 1].0.as_ref()?;
        let (flown, offset_s) = way.last();
        let (from_s, to_s) = self.window_s(way);
        let at = |time_s: f64| flown.at(self.scene, self.mechanism, time_s);
        let (time_s, gap_m) = self.touch(hit, &at, &flown, from_s, to_s)?;
        let before = at(time_s);
        let body = self.scene.body_of(self.mechanism);
        let side = Side {
            body,
            state: &before,
        };
        let impact = hit.contacts.impact(&side, None, &hit.law).ok()?;
        let mut cost = (gap_m / TOLERANCES[0]).powi(2);
        // What recedes does not bounce.
        let contacts = hit.contacts.as_slice().len();
        for speed_m_s in &impact.speeds_m_s[..contacts] {
            cost += (speed_m_s.max(0.0) / TOLERANCES[2]).powi(2);
        }
        let after = State {
            velocity_m_s: impact.after[0].velocity_m_s,
            angular_velocity_rad_s: impact.after[0].angular_velocity_rad_s,
            ..before
        };
        Some(TouchArrival {
            time_s: time_s + offset_s,
            before,
            after: after.is_finite().then_some(after),
            cost,
        })
    }

    /// From the last keyframe of the last flight of a way to the first one after it, on the flight's
    /// own clock \[s\].
    fn window_s(&self, way: &Way) -> (f64, f64) {
        let flight = way.flights.len() - 1;
        let (_, offset_s) = way.last();
        let from_s = match self.samples[flight].last() {
            Some(sample) => sample.acted_s,
            None => way.ends_s.last().copied().unwrap_or(0.0) - offset_s,
        };
        if self.is_edited() {
            return (from_s, from_s + REACH_S);
        }
        let mut after = self.samples[flight + 1..].iter();
        let next = after.find_map(|samples| samples.first());
        let to_s = next.map_or(self.hits[flight].1 + REACH_S, |sample| sample.acted_s);
        (from_s, to_s.max(from_s))
    }

    /// The first time at which a gap closes, with what is left of it; where it does not, that at
    /// which it is least.
    fn touch(
        &self,
        hit: &Hit,
        at: &impl Fn(f64) -> State,
        flown: &KeyedFlight,
        from_s: f64,
        to_s: f64,
    ) -> Option<(f64, f64)> {
        let gap_m = |time_s: f64| hit.gap_m(&at(time_s));
        let turning_s = SCAN_RAD / flown.state.angular_velocity_rad_s.norm();
        let steps = ((to_s - from_s) / SCAN_S.min(turning_s))
            .ceil()
            .clamp(1.0, 400.0);
        let step_s = (to_s - from_s) / steps;
        let mut open: Option<(f64, f64)> = None;
        let mut least: Option<(f64, f64)> = None;
        for step in 0..=steps as usize {
            let time_s = from_s + step as f64 * step_s;
            let gap = gap_m(time_s)?;
            if let Some(open) = open
                && gap <= 0.0
            {
                return illinois(gap_m, open, (time_s, gap));
            }
            if gap > 0.0 {
                open = Some((time_s, gap));
            }
            if least.is_none_or(|(_, known)| gap.abs() < known.abs()) {
                least = Some((time_s, gap));
            }
        }
        least
    }
}

impl Way {
    /// The better first: of several that meet all keyframes, the one that turns least.
    pub(super) fn order(&self, other: &Self) -> Ordering {
        let speed_rad_s = |way: &Self| -> f64 {
            let flights = way.flights.iter();
            let speeds = flights.map(|flown| flown.state.angular_velocity_rad_s.norm());
            speeds.sum()
        };
        let by_cost = self.cost.max(MET).total_cmp(&other.cost.max(MET));
        by_cost.then(speed_rad_s(self).total_cmp(&speed_rad_s(other)))
    }

    pub(super) fn last(&self) -> (KeyedFlight, f64) {
        let last = self.flights.len() - 1;
        (self.flights[last], self.offsets_s[last])
    }

    fn with(&self, flown: KeyedFlight, offset_s: f64, end_s: f64, cost: f64) -> Self {
        let mut way = self.clone();
        way.flights.push(flown);
        way.offsets_s.push(offset_s);
        way.ends_s.push(end_s);
        way.cost += cost;
        way
    }
}

/// Regula falsi in the manner of Illinois, between times with an open and a closed gap.
fn illinois(
    gap_m: impl Fn(f64) -> Option<f64>,
    mut open: (f64, f64),
    mut closed: (f64, f64),
) -> Option<(f64, f64)> {
    let mut best = if open.1 < -closed.1 { open } else { closed };
    for _ in 0..REFINEMENTS {
        let time_s = (open.0 * closed.1 - closed.0 * open.1) / (closed.1 - open.1);
        if !time_s.is_finite() {
            break;
        }
        let gap = gap_m(time_s)?;
        if gap.abs() < best.1.abs() {
            best = (time_s, gap);
        }
        if gap.abs() < 1e-13 {
            break;
        }
        // The end that stays counts half.
        if gap > 0.0 {
            open = (time_s, gap);
            closed.1 *= 0.5;
        } else {
            closed = (time_s, gap);
            open.1 *= 0.5;
        }
    }
    Some(best)
}

/// Where the square of a function of a time from 0 to `reach_s` is least: on a grid, then by steps of
/// Gauss and Newton.
fn least<const N: usize>(of: impl Fn(f64) -> SVector<f64, N>, reach_s: f64) -> f64 {
    const GRID: usize = 100;
    const STEPS: usize = 6;
    const NUDGE_S: f64 = 1e-6;
    let step_s = reach_s / GRID as f64;
    let on_grid = (0..=GRID).map(|step| step as f64 * step_s);
    let tried = on_grid.map(|s| (of(s).norm_squared(), s));
    let best = tried.min_by(|a, b| a.0.total_cmp(&b.0));
    let Some((_, mut best_s)) = best else {
        return 0.0;
    };
    let (from_s, to_s) = ((best_s - step_s).max(0.0), (best_s + step_s).min(reach_s));
    for _ in 0..STEPS {
        let off = of(best_s);
        let slope = (of(best_s + NUDGE_S) - off) / NUDGE_S;
        let step_s = off.dot(&slope) / slope.norm_squared();
        if !step_s.is_finite() || step_s.abs() < 1e-15 {
            break;
        }
        best_s = (best_s - step_s).clamp(from_s, to_s);
    }
    best_s
}

/// How long after the beginning of one flight and how long before that of another their centres of
/// mass are nearest: on a grid, then by steps of Gauss and Newton. Of two ways the sooner.
fn crossing(one: impl Fn(f64) -> State, other: impl Fn(f64) -> State, reach_s: f64) -> [f64; 2] {
    const GRID: usize = 40;
    const STEPS: usize = 10;
    let times_s = || (0..=GRID).map(|step| reach_s * step as f64 / GRID as f64);
    let others: Vec<(f64, Vector3<f64>)> = times_s().map(|s| (s, other(s).position_m)).collect();
    let mut best = (f64::INFINITY, [0.0; 2]);
    for s in times_s() {
        let place_m = one(s).position_m;
        for (other_s, other_m) in &others {
            let off = (place_m - other_m).norm_squared();
            if off < best.0 {
                best = (off, [s, *other_s]);
            }
        }
    }
    let [mut s, mut other_s] = best.1;
    for _ in 0..STEPS {
        let (a, b) = (one(s), other(other_s));
        let off = a.position_m - b.position_m;
        // The other's time runs backwards.
        let by = nalgebra::Matrix3x2::from_columns(&[a.velocity_m_s, b.velocity_m_s]);
        let Some(square) = (by.transpose() * by).try_inverse() else {
            break;
        };
        let step = square * (by.transpose() * off);
        s = (s - step.x).clamp(0.0, reach_s);
        other_s = (other_s - step.y).clamp(0.0, reach_s);
    }
    [s, other_s]
}

/// Up, as seen by a mechanism.
pub(super) fn up(scene: &Scene) -> Vector3<f64> {
    let gravity = scene.gravity_m_s2.try_normalize(1e-9);
    gravity.map_or_else(Vector3::z, |down| -down)
}
