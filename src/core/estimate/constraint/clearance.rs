//! Two solids of which one flies stay out of each other: the row of their [least distance](super::least).

use nalgebra::{RowSVector, Vector3};

use super::kind::{At, Constraint, Filled};
use super::least::{FeatureGap, LeastMoment, MovingFrame};
use super::quantity::ByState;
use super::reached::Reached;
use crate::estimate::problem::clearance::{Clearance, FlightEnd};
use crate::estimate::problem::{Problem, unit};
use crate::estimate::unknowns::layout::Layout;
use crate::motion::Gap;
use crate::optimise::block::{Block, BlockPattern};
use crate::physics::contact::{Contact, Frame};
use crate::physics::state::{DIMENSION, part};

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

    fn filled(&self, at: &At, (pattern, block): Filled) -> Option<()> {
        let point = at.point;
        let gravity_m_s2 = at.problem.gravity(&point.parameters);
        let least = self.least(at)?;
        let reached = self.reached(at, &gravity_m_s2, least.time_s)?;
        let gap = |contact: &Contact| self.gap(contact, &reached, least.time_s);
        let FeatureGap {
            gap_m,
            rate_m_s,
            by,
        } = least.shared(&self.solids, gap)?;
        block.values[0] = gap_m / unit::POSITION_M;
        block.bounds[0] = (self.solids.least_m / unit::POSITION_M, f64::INFINITY);
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
        let flown = |side: usize| {
            let end = reached[side].end();
            MovingFrame {
                frame: Frame::of(&end.state),
                rate: end.rate.fixed_rows::<6>(part::POSITION).into(),
            }
        };
        let other = MovingFrame::of_other(&self.solids.from, time_s, || flown(1));
        FeatureGap::new(contact, &[flown(0), other])
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
        let ends_s = [end_s(&self.ends[0]), end_s(&self.ends[1])];
        let gravity_m_s2 = at.problem.gravity(&at.point.parameters);
        LeastMoment::of(&self.solids, ends_s, &mut |contact, time_s| {
            let reached = self.reached(at, &gravity_m_s2, time_s)?;
            self.gap(contact, &reached, time_s)
        })
    }
}

/// The first row of derivatives by states for one by the poses of a side.
fn of_pose(by: &RowSVector<f64, 12>, side: usize) -> ByState {
    let mut all = ByState::zeros();
    all.fixed_view_mut::<1, 6>(0, part::POSITION)
        .copy_from(&by.fixed_columns::<6>(6 * side));
    all
}
