//! An arc's state at a time, with derivatives in whichever form serves.

use nalgebra::Vector3;

use super::kind::At;
use super::quantity::ByState;
use crate::estimate::problem::influence::Influence;
use crate::estimate::reach::arc_end::{self, ArcEnd};
use crate::estimate::reach::arrival::GeneralArrival;
use crate::physics::state::{StateTangent, part};
use crate::physics::{Body, State, flow};

/// An arc's state at a time with its derivatives.
pub(super) struct Reached<'a> {
    pub(super) end: ReachedEnd,
    pub(super) body: Body,
    pub(super) gravity_m_s2: &'a Vector3<f64>,
}

/// The state, by the short form where that serves.
pub(super) enum ReachedEnd {
    Plain(Box<ArcEnd>),
    General(Box<GeneralArrival>),
}

impl<'a> Reached<'a> {
    /// The state of an arc at a time; `None` where no body has such moments.
    pub(super) fn new(
        at: &At,
        arc: usize,
        gravity_m_s2: &'a Vector3<f64>,
        time_s: f64,
    ) -> Option<Self> {
        let (problem, point) = (at.problem, at.point);
        let epoch_s = at.epochs_s[arc];
        let (end, body) = if problem.arcs[arc].is_plain {
            let body = problem.body_of(arc);
            let end = ArcEnd::new(body, gravity_m_s2, point, arc, [epoch_s, time_s]);
            (ReachedEnd::Plain(Box::new(end)), *body)
        } else {
            let body = problem.body_at(arc, &point.parameters)?;
            let arrival = GeneralArrival::new(problem, point, arc, epoch_s, time_s)?;
            (ReachedEnd::General(Box::new(arrival)), body)
        };
        Some(Self {
            end,
            body,
            gravity_m_s2,
        })
    }

    pub(super) fn end(&self) -> &ArcEnd {
        match &self.end {
            ReachedEnd::Plain(end) => end,
            ReachedEnd::General(arrival) => &arrival.end,
        }
    }

    /// Derivatives by the arriving state, chained to those by the state at the epoch.
    pub(super) fn chain(&self, by: &ByState) -> ByState {
        match &self.end {
            ReachedEnd::Plain(end) => {
                let chained = end.chain(&arc_end::ByState::<3>::of(by, 0));
                let mut all = ByState::zeros();
                for (at, block) in [
                    (part::POSITION, chained.position),
                    (part::ORIENTATION, chained.orientation),
                    (part::VELOCITY, chained.velocity),
                    (part::ANGULAR_VELOCITY, chained.spin),
                ] {
                    all.fixed_view_mut::<3, 3>(0, at).copy_from(&block);
                }
                all
            }
            ReachedEnd::General(arrival) => by * arrival.by_state(),
        }
    }

    /// The same by a parameter that acts on the flight.
    pub(super) fn by(&self, by: &ByState, influence: Influence, value: f64) -> Vector3<f64> {
        match (&self.end, influence) {
            (ReachedEnd::Plain(end), Influence::Pull(axis)) => {
                end.by_gravity(&arc_end::ByState::<3>::of(by, 0), axis)
            }
            (ReachedEnd::Plain(_), _) => Vector3::zeros(),
            (ReachedEnd::General(arrival), influence) => by * arrival.by(influence, value),
        }
    }

    /// The state moved along its flight by a short time, to first order.
    pub(super) fn moved(&self, by_s: f64) -> State {
        let end = self.end();
        end.state.retract(&(end.rate * by_s))
    }

    pub(super) fn rate(&self, state: &State) -> StateTangent {
        flow::rate(&self.body, self.gravity_m_s2, state)
    }
}
