//! Two solids stay out of each other: the least distance of a pair of features over a short time, `min_t φ(t) ≥ φ_least`.
//!
//! With the moment `t*` of the least distance, the envelope theorem says that it does not matter how `t*` moves:
//!
//! ```text
//! φ'(t*) = 0:                         δφ = φ_q δq
//! φ₁(t*) = φ₂(t*), φ₁' < 0 < φ₂':     δφ = λ₁ φ₁_q δq + λ₂ φ₂_q δq,   λ₁ = φ₂'/(φ₂' − φ₁'),  λ₂ = 1 − λ₁
//! t* = τ, the end of the flight:      δφ = φ_q δq + φ' δτ
//! ```
//!
//! The second is where the distance passes from one pair of features to the next; it is the greater of both.

use nalgebra::{RowSVector, Vector3};

use super::kind::{At, Constraint, Filled};
use super::quantity::ByState;
use super::reached::Reached;
use crate::estimate::problem::clearance::{Clearance, ClearanceTouches, FlightEnd, KeptFrom};
use crate::estimate::problem::{Problem, unit};
use crate::estimate::unknowns::layout::Layout;
use crate::motion::Gap;
use crate::optimise::block::{Block, BlockPattern};
use crate::physics::contact::{Contact, Frame};
use crate::physics::state::{DIMENSION, StateTangent, part};

/// Intervals among whose ends the least distance is looked for first.
const INTERVALS: usize = 8;
/// Greatest number of steps to a root, and the share of an interval that is a root's error.
const ROOT_STEPS: usize = 60;
const ROOT_ERROR: f64 = 1e-13;

impl Constraint for Clearance {
    /// Columns: the states of its arcs, the times of free events at which its flights end, parameters.
    fn patterns(&self, _: &Problem, layout: &Layout) -> [BlockPattern; 2] {
        let states = self.arcs.iter().flat_map(|arc| layout.state(*arc));
        let times = self.end_times();
        let times = times.filter_map(|(_, time, _)| time.unknown(layout));
        let parameters = self.acting.iter().map(|of| layout.parameters[of.parameter]);
        let columns = states.chain(times).chain(parameters).collect();
        [BlockPattern::dense(1, columns), BlockPattern::default()]
    }

    /// Where features have no distance the row is NaN.
    fn fill(&self, at: &mut At, [(pattern, block), _]: [Filled; 2]) {
        block.reset(pattern);
        if self.filled(at, (pattern, &mut *block)).is_none() {
            block.spoil();
        }
    }

    fn gap(&self, _: &Problem, [block, _]: [&Block; 2]) -> Gap {
        Gap {
            position_m: block.largest(0..1) * unit::POSITION_M,
            ..Gap::default()
        }
    }

    fn is_curved(&self) -> bool {
        true
    }
}

/// A time on which the end of a flight depends.
#[derive(Clone, Copy)]
enum EndTime {
    Event(usize),
    Node(usize),
}

impl EndTime {
    /// Where it is among the unknowns, if it is one: the first node is not.
    fn unknown(self, layout: &Layout) -> Option<usize> {
        match self {
            EndTime::Event(event) => layout.events[event],
            EndTime::Node(node) => layout.nodes.get(node).copied().flatten(),
        }
    }

    fn is_unknown(self, problem: &Problem) -> bool {
        match self {
            EndTime::Event(event) => problem.event_is_free[event],
            EndTime::Node(node) => {
                problem.times_are_unknown() && (1..problem.nodes_acted_s.len()).contains(&node)
            }
        }
    }
}

/// When a clearance is least, and how.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(in crate::estimate) struct LeastMoment {
    /// \[s\].
    pub(in crate::estimate) time_s: f64,
    /// Share of each pair of features in the derivative.
    shares: [f64; 2],
    /// The end of the flights at which it is, if it is there.
    end: Option<usize>,
}

/// The distance of a pair of features at a time.
struct FeatureGap {
    gap_m: f64,
    /// [m/s].
    rate_m_s: f64,
    /// By the poses of both.
    by: RowSVector<f64, 12>,
}

impl Clearance {
    /// The unknown times on which each end of its flights depends, with by how much.
    fn end_times(&self) -> impl Iterator<Item = (usize, EndTime, f64)> {
        let ends = self.ends.iter().enumerate();
        ends.flat_map(|(side, end)| {
            let parts = match *end {
                FlightEnd::Event(event) => vec![(EndTime::Event(event), 1.0)],
                FlightEnd::Node(node, share) => vec![
                    (EndTime::Node(node), 1.0 - share),
                    (EndTime::Node(node + 1), share),
                ],
                FlightEnd::At(_) => Vec::new(),
            };
            let parts = parts.into_iter().filter(|(_, share)| *share != 0.0);
            parts.map(move |(time, share)| (side, time, share))
        })
    }

    fn contacts(&self) -> &[Contact] {
        match &self.touches {
            ClearanceTouches::One(contact) => std::slice::from_ref(contact),
            ClearanceTouches::Switching(both) => both.as_slice(),
        }
    }

    fn filled(&self, at: &At, (pattern, block): Filled) -> Option<()> {
        let point = at.point;
        let gravity_m_s2 = at.problem.gravity(&point.parameters);
        let least = self.least(at)?;
        let reached = self.reached(at, &gravity_m_s2, least.time_s)?;
        let (mut gap_m, mut rate_m_s) = (0.0, 0.0);
        let mut by = RowSVector::<f64, 12>::zeros();
        for (contact, share) in self.contacts().iter().zip(least.shares) {
            if share != 0.0 {
                let of = self.gap(contact, &reached, least.time_s)?;
                gap_m += share * of.gap_m;
                rate_m_s += share * of.rate_m_s;
                by += of.by * share;
            }
        }
        block.values[0] = gap_m / unit::POSITION_M;
        block.bounds[0] = (self.least_m / unit::POSITION_M, f64::INFINITY);
        let entries = block.derivatives_mut(pattern, 0);
        let (by_state, rest) = entries.split_at_mut(DIMENSION * reached.len());
        let sides: Vec<ByState> = (0..reached.len()).map(|side| of_pose(&by, side)).collect();
        let states = by_state
            .chunks_exact_mut(DIMENSION)
            .zip(&reached)
            .zip(&sides);
        for ((entries, reached), by) in states {
            let chained = reached.chain(by).row(0) / unit::POSITION_M;
            for (entry, by) in entries.iter_mut().zip(chained.iter()) {
                *entry = *by;
            }
        }
        let times = self.end_times();
        let times = times.filter(|(_, time, _)| time.is_unknown(at.problem));
        let times = times.map(|(side, _, share)| {
            let is_there = least.end == Some(side);
            if is_there { share * rate_m_s } else { 0.0 }
        });
        let parameters = self.acting.iter().map(|of| {
            let value = point.parameters[of.parameter];
            let each = of.on.iter().filter_map(|(side, influence)| {
                let side = (*side)?;
                Some(reached[side].by(&sides[side], *influence, value).x)
            });
            each.sum::<f64>()
        });
        for (entry, by) in rest.iter_mut().zip(times.chain(parameters)) {
            *entry = by / unit::POSITION_M;
        }
        Some(())
    }

    fn reached<'g>(
        &self,
        at: &At,
        gravity_m_s2: &'g Vector3<f64>,
        time_s: f64,
    ) -> Option<Vec<Reached<'g>>> {
        let arcs = self.arcs.iter();
        arcs.map(|arc| Reached::new(at, *arc, gravity_m_s2, time_s))
            .collect()
    }

    /// The distance of a pair of features.
    fn gap(&self, contact: &Contact, reached: &[Reached], time_s: f64) -> Option<FeatureGap> {
        let end = |side: usize| reached[side].end();
        let (frame, rate) = match &self.from {
            KeptFrom::Still(frame) => (*frame, StateTangent::zeros()),
            KeptFrom::Flying => (Frame::of(&end(1).state), end(1).rate),
            KeptFrom::Held(held) => {
                let state = held.state(time_s);
                let mut rate = StateTangent::zeros();
                rate.fixed_rows_mut::<3>(part::POSITION)
                    .copy_from(&state.velocity_m_s);
                rate.fixed_rows_mut::<3>(part::ORIENTATION)
                    .copy_from(&state.angular_velocity_rad_s);
                (Frame::of(&state), rate)
            }
        };
        let (touch, derivative) = contact
            .touch_derivative(&Frame::of(&end(0).state), &frame)
            .ok()?;
        let along = |side: usize, rate: &StateTangent| {
            let by = derivative.gap.fixed_columns::<6>(6 * side);
            (by * rate.fixed_rows::<6>(part::POSITION))[0]
        };
        Some(FeatureGap {
            gap_m: touch.gap_m,
            rate_m_s: along(0, &end(0).rate) + along(1, &rate),
            by: derivative.gap,
        })
    }

    /// When its features are nearest; `None` where they have no distance.
    pub(in crate::estimate) fn least(&self, at: &At) -> Option<LeastMoment> {
        let end_s = |end: &FlightEnd| match end {
            FlightEnd::Event(event) => at.event_time_s(*event),
            FlightEnd::Node(node, share) => {
                let times_s = &at.point.node_times_s;
                let next_s = times_s.get(node + 1).copied().unwrap_or(times_s[*node]);
                times_s[*node] + share * (next_s - times_s[*node])
            }
            FlightEnd::At(time_s) => *time_s,
        };
        let [start_s, end_s] = [end_s(&self.ends[0]), end_s(&self.ends[1])];
        let gravity_m_s2 = at.problem.gravity(&at.point.parameters);
        let search = LeastSearch {
            clearance: self,
            at,
            gravity_m_s2: &gravity_m_s2,
            ends_s: [start_s, end_s.max(start_s)],
        };
        // A step that is tried may lead to times that are none: what follows of them is none either.
        let clamped = |time_s: f64| time_s.max(start_s).min(end_s.max(start_s));
        let [from_s, to_s] = [
            clamped(self.around_s - self.reach_s),
            clamped(self.around_s + self.reach_s),
        ];
        match &self.touches {
            ClearanceTouches::One(_) => search.of_one(0, [from_s, to_s]),
            ClearanceTouches::Switching(_) => search.of_two([from_s, to_s]),
        }
    }
}

/// The first row of derivatives by states for one by the poses of a side.
fn of_pose(by: &RowSVector<f64, 12>, side: usize) -> ByState {
    let mut all = ByState::zeros();
    all.fixed_view_mut::<1, 6>(0, part::POSITION)
        .copy_from(&by.fixed_columns::<6>(6 * side));
    all
}

/// The search for the moment of the least distance.
struct LeastSearch<'a> {
    clearance: &'a Clearance,
    at: &'a At<'a>,
    gravity_m_s2: &'a Vector3<f64>,
    /// Start and end of the flights \[s\].
    ends_s: [f64; 2],
}

impl LeastSearch<'_> {
    /// Distance of a pair of features and its rate.
    fn gap(&self, contact: usize, time_s: f64) -> Option<FeatureGap> {
        let reached = self.clearance.reached(self.at, self.gravity_m_s2, time_s)?;
        let contact = &self.clearance.contacts()[contact];
        self.clearance.gap(contact, &reached, time_s)
    }

    fn at(&self, contact: usize, time_s: f64) -> LeastMoment {
        let mut shares = [0.0; 2];
        shares[contact] = 1.0;
        LeastMoment {
            time_s,
            shares,
            end: (0..2).find(|side| self.ends_s[*side] == time_s),
        }
    }

    /// Where one pair of features is nearest within a time.
    fn of_one(&self, contact: usize, [from_s, to_s]: [f64; 2]) -> Option<LeastMoment> {
        let step_s = (to_s - from_s) / INTERVALS as f64;
        let times_s = (0..=INTERVALS).map(|at| match at {
            INTERVALS => to_s,
            _ => from_s + at as f64 * step_s,
        });
        let times_s: Vec<f64> = times_s.collect();
        let mut gaps_m = Vec::new();
        for time_s in &times_s {
            gaps_m.push(self.gap(contact, *time_s)?.gap_m);
        }
        let least = (0..gaps_m.len()).min_by(|a, b| gaps_m[*a].total_cmp(&gaps_m[*b]))?;
        let slope = |time_s: f64| Some(self.gap(contact, time_s)?.rate_m_s);
        let middle_s = times_s[least];
        let here = slope(middle_s)?;
        let other = if here > 0.0 {
            least.checked_sub(1)
        } else {
            (least < INTERVALS).then_some(least + 1)
        };
        let Some(other) = other else {
            return Some(self.at(contact, middle_s));
        };
        let time_s = root([middle_s, times_s[other]], slope)?;
        Some(self.at(contact, time_s))
    }

    /// Where the greater distance of two pairs is least, the first before they are as far and the second after.
    fn of_two(&self, [from_s, to_s]: [f64; 2]) -> Option<LeastMoment> {
        let ahead = |time_s: f64| Some(self.gap(0, time_s)?.gap_m - self.gap(1, time_s)?.gap_m);
        match (ahead(from_s)? > 0.0, ahead(to_s)? > 0.0) {
            (true, true) => return self.of_one(0, [from_s, to_s]),
            (false, false) => return self.of_one(1, [from_s, to_s]),
            (false, true) => {
                // In the other order.
                let nearer =
                    |contact: usize| Some(self.gap(contact, self.clearance.around_s)?.gap_m);
                let greater = usize::from(nearer(1)? > nearer(0)?);
                return self.of_one(greater, [from_s, to_s]);
            }
            (true, false) => {}
        }
        let time_s = root([from_s, to_s], ahead)?;
        let [before, after] = [self.gap(0, time_s)?.rate_m_s, self.gap(1, time_s)?.rate_m_s];
        if before >= 0.0 {
            return self.of_one(0, [from_s, time_s]);
        }
        if after <= 0.0 {
            return self.of_one(1, [time_s, to_s]);
        }
        let share = after / (after - before);
        Some(LeastMoment {
            time_s,
            shares: [share, 1.0 - share],
            end: None,
        })
    }
}

/// The root of a function with other signs at the ends of an interval, by the Illinois variant of the secant method; the
/// first end where signs are alike.
fn root([mut a, mut b]: [f64; 2], of: impl Fn(f64) -> Option<f64>) -> Option<f64> {
    let (mut at_a, mut at_b) = (of(a)?, of(b)?);
    if at_a * at_b > 0.0 || at_a == 0.0 {
        return Some(a);
    }
    let error = ROOT_ERROR * (b - a).abs();
    for _ in 0..ROOT_STEPS {
        if at_b == 0.0 || (b - a).abs() <= error {
            break;
        }
        let between = (a * at_b - b * at_a) / (at_b - at_a);
        let value = of(between)?;
        if value * at_b < 0.0 {
            (a, at_a) = (b, at_b);
        } else {
            at_a *= 0.5;
        }
        let is_there = (between - b).abs() <= error;
        (b, at_b) = (between, value);
        if is_there {
            break;
        }
    }
    Some(b)
}
