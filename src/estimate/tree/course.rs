//! The course of trees from a node on, through events, with its derivatives by the unknowns of the leg.
//!
//! With `Φ` the flow's derivative, and `ẋ` how it goes on, a flow from one event, at `T`, to
//! another, at `T'`, changes with both: `δx' = Φ δx + ẋ (δT' − δT)`. An impact's derivative follows; where
//! the rates jump, what came before is put into one matrix and the flow begins anew.

use nalgebra::DMatrix;

use super::problem::TreeProblem;
use crate::motion::TreeTouch;
use crate::physics::impact::ImpactError;
use crate::physics::tree::tableau;
use crate::physics::tree::{
    ForestFlow, ForestSnapshot, TreeImpact, TreeImpactDerivative, TreeState,
};

/// A time on the way at which the course stops.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Stop {
    /// The time \[s\].
    pub(super) time_s: f64,
    /// Place among the leg's events of the one whose time this is.
    pub(super) event: Option<usize>,
}

impl Stop {
    /// A time that is known \[s\].
    pub(super) fn known(time_s: f64) -> Self {
        Self {
            time_s,
            event: None,
        }
    }
}

/// The motion from a node on.
pub(super) struct Course<'t> {
    problem: &'t TreeProblem,
    flow: ForestFlow<'t>,
    begun: Stop,
    now: Stop,
    has_derivatives: bool,
    /// Number of events of the leg.
    events: usize,
    /// Where the flow began: its derivative by the node's tangent and by the times of the leg's events; none at
    /// the node itself.
    by_unknowns: Option<DMatrix<f64>>,
    /// Derivative of the flow since then.
    by_begin: DMatrix<f64>,
}

impl<'t> Course<'t> {
    /// From a node on, with derivatives where they are asked for; so many events are on its leg.
    pub(super) fn new(
        problem: &'t TreeProblem,
        (node, from_s): (&TreeState, f64),
        (events, has_derivatives): (usize, bool),
    ) -> Self {
        let width = problem.width();
        Self {
            events,
            by_begin: DMatrix::zeros(width, width),
            ..Self::begun(problem, (node, from_s), has_derivatives)
        }
    }

    /// From a node on, without derivatives.
    pub(super) fn plain(problem: &'t TreeProblem, from: (&TreeState, f64)) -> Self {
        Self::begun(problem, from, false)
    }

    fn begun(
        problem: &'t TreeProblem,
        (node, from_s): (&TreeState, f64),
        has_derivatives: bool,
    ) -> Self {
        let mut flow = ForestFlow::new(
            &problem.forest,
            &problem.gravity_m_s2,
            tableau::DORMAND_PRINCE,
        );
        flow.begin(node, has_derivatives);
        Self {
            problem,
            flow,
            begun: Stop::known(from_s),
            now: Stop::known(from_s),
            has_derivatives,
            events: 0,
            by_unknowns: None,
            by_begin: DMatrix::zeros(0, 0),
        }
    }

    /// Goes on, or back, to a time. The state is no number at one that is farther from the motion than that lasts: an event
    /// that runs away ends a step, and is not followed.
    pub(super) fn advance(&mut self, to: Stop) {
        let [from_s, to_s] = self.problem.span_s;
        let lasts_s = to_s - from_s;
        let is_near = (from_s - lasts_s..=to_s + lasts_s).contains(&to.time_s);
        let elapsed_s = match is_near {
            true => to.time_s - self.begun.time_s,
            false => f64::NAN,
        };
        self.flow.reach(elapsed_s, self.problem.step_s);
        self.now = to;
    }

    /// Goes on to a time in one step.
    pub(super) fn step(&mut self, to_s: f64) {
        self.flow.advance(to_s - self.now.time_s, 1);
        self.now = Stop::known(to_s);
    }

    /// The state now.
    pub(super) fn state(&mut self) -> TreeState {
        self.flow.state()
    }

    /// Its derivative by the node's tangent and by the times of the leg's events; zeros where none were asked for.
    pub(super) fn jacobian(&mut self) -> DMatrix<f64> {
        if !self.has_derivatives {
            let width = self.problem.width();
            return DMatrix::zeros(width, width + self.events);
        }
        self.flow.jacobian(&mut self.by_begin);
        let width = self.problem.width();
        let mut by_unknowns = match &self.by_unknowns {
            Some(by_unknowns) => &self.by_begin * by_unknowns,
            None => self
                .by_begin
                .clone()
                .resize_horizontally(width + self.events, 0.0),
        };
        let stops = [(self.begun.event, -1.0), (self.now.event, 1.0)];
        if stops.iter().any(|(event, _)| event.is_some()) {
            let rate = self.flow.rate();
            for (event, sign) in stops {
                if let Some(event) = event {
                    let mut column = by_unknowns.column_mut(width + event);
                    column.axpy(sign, &rate, 1.0);
                }
            }
        }
        by_unknowns
    }

    /// Something is hit now: the impact with its derivatives. Fails as [`ForestSnapshot::impact`] does; the course then
    /// stays as it was.
    pub(super) fn hit(
        &mut self,
        snapshot: &ForestSnapshot,
        touch: &TreeTouch,
    ) -> Result<(TreeImpact, TreeImpactDerivative), ImpactError> {
        let state = self.flow.state();
        let (impact, derivative) = snapshot.impact_derivative(&state, &touch.at, &touch.law)?;
        let mut by_unknowns = self.jacobian();
        let freedoms = self.problem.forest.freedoms();
        let rates = &derivative.rates * &by_unknowns;
        by_unknowns.rows_mut(freedoms, freedoms).copy_from(&rates);
        self.by_unknowns = Some(by_unknowns);
        self.go_on(state, &impact);
        Ok((impact, derivative))
    }

    /// [`Course::hit`] where nothing is asked of the impact.
    pub(super) fn bounce(&mut self, touch: &TreeTouch) -> Result<(), ImpactError> {
        let state = self.flow.state();
        let mut snapshot = ForestSnapshot::new(&self.problem.forest, &self.problem.gravity_m_s2);
        snapshot.set(&state);
        if self.has_derivatives {
            return self.hit(&snapshot, touch).map(|_| ());
        }
        let impact = snapshot.impact(&state, &touch.at, &touch.law)?;
        self.go_on(state, &impact);
        Ok(())
    }

    fn go_on(&mut self, before: TreeState, impact: &TreeImpact) {
        let after = TreeState {
            rates: impact.rates.clone(),
            ..before
        };
        self.flow.begin(&after, self.has_derivatives);
        self.begun = self.now;
    }
}
