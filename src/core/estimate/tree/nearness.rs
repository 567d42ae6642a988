//! The row of a clearance: the [least distance](crate::estimate::constraint::least) of two links, or of a link and what
//! stands or is in a hand.
//!
//! The moment `t*` is found on a trajectory beside that of the interval, which has no derivatives. With `φ_q` by the poses of
//! both, `L` of links by the state of all and `X = ∂x(t*)/∂(x_k, T, λ, p)`, the row is `φ_q L X`: of its moving moment nothing
//! is seen, but at an event that ends the motion there.

use nalgebra::{DMatrix, Matrix1xX, Vector6};

use super::clearance::{MotionPiece, TreeClearance};
use super::point::TreePoint;
use super::problem::TreeProblem;
use super::time_line::TimeLine;
use super::trajectory::{Stop, Trajectory, With};
use crate::estimate::constraint::least::{FeatureGap, LeastMoment, MovingFrame};
use crate::estimate::problem::clearance::KeptFrom;
use crate::estimate::problem::unit;
use crate::optimise::block::{Block, BlockPattern};
use crate::physics::contact::{Contact, Frame};
use crate::physics::state::part;
use crate::physics::tree::ForestSnapshot;

/// When a clearance is least, as a stop of the trajectory.
#[derive(Clone, Copy, Debug)]
pub(super) struct LeastStop {
    pub(super) moment: LeastMoment,
    pub(super) stop: Stop,
}

/// What is known at such a stop.
pub(super) struct StoppedMotion<'s> {
    pub(super) snapshot: &'s ForestSnapshot<'s>,
    /// `L` of both places.
    pub(super) links: [&'s DMatrix<f64>; 2],
    /// `X`.
    pub(super) jacobian: &'s DMatrix<f64>,
}

impl MotionPiece {
    /// Number of events of its interval before it.
    pub(super) fn phase(&self, problem: &TreeProblem) -> usize {
        let events = problem.events_of(self.node);
        self.events_before.clamp(events.start, events.end) - events.start
    }

    /// Its beginning and its end.
    pub(super) fn ends(
        &self,
        problem: &TreeProblem,
        line: &TimeLine,
        point: &TreePoint,
    ) -> [Stop; 2] {
        let events = problem.events_of(self.node);
        let at_event = |event: usize| Stop {
            time_s: point.event_times_s[events.start + event],
            with: With::Event(event),
        };
        let phase = self.phase(problem);
        let stamps_s = problem.interval_s(self.node);
        let [start, end] = stamps_s.map(|acted_s| Stop::acted(line, acted_s));
        [
            phase.checked_sub(1).map_or(start, at_event),
            match phase < events.len() {
                true => at_event(phase),
                false => end,
            },
        ]
    }
}

impl TreeClearance {
    /// When its features are nearest on the motion between these ends, on which the trajectory is; that goes back.
    /// `None` where features have no distance.
    pub(super) fn least(
        &self,
        problem: &TreeProblem,
        ends: [Stop; 2],
        trajectory: &mut Trajectory,
    ) -> Option<LeastStop> {
        let ends_s = ends.map(|end| end.time_s);
        let mut aside = trajectory.aside();
        let mut snapshot = ForestSnapshot::new(&problem.forest, &problem.gravity_m_s2);
        let moment = LeastMoment::of(&self.solids, ends_s, &mut |contact, time_s| {
            aside.advance(Stop::known(time_s));
            snapshot.set(&aside.state());
            self.gap(contact, &snapshot, time_s)
        })?;
        let stop = moment.end.map(|end| ends[end]);
        Some(LeastStop {
            moment,
            stop: stop.unwrap_or(Stop::known(moment.time_s)),
        })
    }

    /// How many of both move as the unknowns say.
    fn moving_sides(&self) -> usize {
        1 + usize::from(matches!(self.solids.from, KeptFrom::Flying))
    }

    fn gap(&self, contact: &Contact, snapshot: &ForestSnapshot, time_s: f64) -> Option<FeatureGap> {
        let moving = |side: usize| MovingFrame::of(&snapshot.link_state(self.places[side]));
        let other = MovingFrame::of_other(&self.solids.from, time_s, || moving(1));
        FeatureGap::new(contact, &[moving(0), other])
    }

    /// Its row with the derivatives by the interval's unknowns; NaN where features have no distance.
    pub(super) fn fill(
        &self,
        least: &LeastStop,
        at: &StoppedMotion,
        pattern: &BlockPattern,
        block: &mut Block,
    ) {
        let time_s = least.moment.time_s;
        let gap = |contact: &Contact| self.gap(contact, at.snapshot, time_s);
        let Some(gap) = least.moment.shared(&self.solids, gap) else {
            block.spoil();
            return;
        };
        block.values[0] = gap.gap_m / unit::POSITION_M;
        block.bounds[0] = (self.solids.least_m / unit::POSITION_M, f64::INFINITY);
        let sides = [0, 1].map(|side| gap.by.fixed_columns::<6>(6 * side).into_owned());
        let mut by_state = Matrix1xX::zeros(at.jacobian.nrows());
        for (by, link) in sides.iter().zip(at.links).take(self.moving_sides()) {
            by_state += by * link.fixed_rows::<6>(part::POSITION);
        }
        let mut by = by_state * at.jacobian;
        if let With::Event(event) = least.stop.with {
            // A hand carries what hangs from it, whatever the state is.
            let carried = |side: usize| {
                let rate = at.snapshot.link_carried(self.places[side]);
                Vector6::from(rate.fixed_rows::<6>(part::POSITION))
            };
            let other = MovingFrame::of_other(&self.solids.from, time_s, || MovingFrame {
                frame: Frame::world(),
                rate: carried(1),
            });
            let rates = [carried(0), other.rate];
            for (by_pose, rate) in sides.iter().zip(&rates) {
                by[at.jacobian.nrows() + event] += (by_pose * rate)[0];
            }
        }
        let entries = block.derivatives_mut(pattern, 0);
        for (entry, by) in entries.iter_mut().zip(by.iter()) {
            *entry = by / unit::POSITION_M;
        }
    }
}

impl TreeProblem {
    /// When the features of a clearance are nearest \[s\].
    pub(super) fn least_s(&self, of: &TreeClearance, point: &TreePoint) -> Option<f64> {
        let this = &*self.as_told(point);
        let line = &point.time_line(this);
        let ends = of.piece.ends(this, line, point);
        let node = of.piece.node;
        let node_s = line.time_s(this.interval_s(node)[0]);
        let mut trajectory = Trajectory::plain(this, line, &point.nodes[node], node_s);
        this.follow(point, node_s, ends[0].time_s, &mut trajectory);
        let least = of.least(this, ends, &mut trajectory)?;
        Some(least.moment.time_s)
    }
}
