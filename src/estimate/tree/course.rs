//! The course of trees from a node on, through events, with its derivatives by the unknowns of the leg.
//!
//! With `Φ` the flow's derivative, and `Δ` its change with the duration, a flow from one event, at `T`, to
//! another, at `T'`, changes with both: `δx' = Φ δx + Δ (δT' − δT)`. An impact's derivative follows. Where
//! a time is an unknown, or the rates jump, what came before is put into one matrix and the flow begins anew.

use nalgebra::DMatrix;

use super::problem::TreeProblem;
use crate::motion::TreeTouch;
use crate::physics::impact::ImpactError;
use crate::physics::tree::tableau::{self, Tableau};
use crate::physics::tree::{
    ForestFlow, ForestSnapshot, TreeImpact, TreeImpactDerivative, TreeState,
};

/// A time on the way at which the course stops.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Stop {
    /// The time \[s\].
    pub(super) time_s: f64,
    /// About when that is \[s\], which tells the number of steps: it stays as unknown times move, so that the flow
    /// is one smooth function.
    pub(super) about_s: f64,
    /// Place among the leg's events of the one whose time this is.
    pub(super) event: Option<usize>,
}

impl Stop {
    /// A time that is known \[s\].
    pub(super) fn known(time_s: f64) -> Self {
        Self {
            time_s,
            about_s: time_s,
            event: None,
        }
    }
}

/// The motion from a node on.
pub(super) struct Course<'t> {
    problem: &'t TreeProblem,
    flow: ForestFlow<'t>,
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
    /// From a node on, with derivatives; so many events are on its leg.
    pub(super) fn new(
        problem: &'t TreeProblem,
        (node, from_s): (&TreeState, f64),
        events: usize,
    ) -> Self {
        let width = problem.width();
        Self {
            events,
            by_begin: DMatrix::zeros(width, width + 1),
            ..Self::begun(problem, (node, from_s), problem.tableau, true)
        }
    }

    /// From a node on, without derivatives, as exactly as the motion is told in the end.
    pub(super) fn plain(problem: &'t TreeProblem, from: (&TreeState, f64)) -> Self {
        Self::begun(problem, from, tableau::DORMAND_PRINCE, false)
    }

    fn begun(
        problem: &'t TreeProblem,
        (node, from_s): (&TreeState, f64),
        tableau: Tableau,
        has_derivatives: bool,
    ) -> Self {
        let mut flow = ForestFlow::new(&problem.forest, &problem.gravity_m_s2, tableau);
        flow.begin(node, has_derivatives);
        Self {
            problem,
            flow,
            now: Stop::known(from_s),
            has_derivatives,
            events: 0,
            by_unknowns: None,
            by_begin: DMatrix::zeros(0, 0),
        }
    }

    /// Goes on, or back, to a time.
    pub(super) fn advance(&mut self, to: Stop) {
        let from = self.now;
        let (duration_s, about_s) = (to.time_s - from.time_s, to.about_s - from.about_s);
        let steps = self.problem.steps(about_s.abs());
        self.now = to;
        if from.event.is_none() && to.event.is_none() {
            if duration_s != 0.0 {
                self.flow.advance(duration_s, steps, 0.0);
            }
            return;
        }
        self.begin_anew();
        self.flow.advance(duration_s, steps, 1.0);
        self.begin_anew();
        if let Some(by_unknowns) = &mut self.by_unknowns {
            let width = self.problem.width();
            let by_duration = self.by_begin.column(width);
            for (event, sign) in [(from.event, -1.0), (to.event, 1.0)] {
                if let Some(event) = event {
                    let mut column = by_unknowns.column_mut(width + event);
                    column.axpy(sign, &by_duration, 1.0);
                }
            }
        }
    }

    /// The flow begins where it is.
    fn begin_anew(&mut self) {
        if self.has_derivatives {
            self.by_unknowns = Some(self.jacobian());
        }
        let state = self.flow.state();
        self.flow.begin(&state, self.has_derivatives);
    }

    /// The state now.
    pub(super) fn state(&mut self) -> TreeState {
        self.flow.state()
    }

    /// Its derivative by the node's tangent and by the times of the leg's events.
    pub(super) fn jacobian(&mut self) -> DMatrix<f64> {
        self.flow.jacobian(&mut self.by_begin);
        let width = self.problem.width();
        let by_begin = self.by_begin.columns(0, width);
        match &self.by_unknowns {
            Some(by_unknowns) => by_begin * by_unknowns,
            None => by_begin
                .clone_owned()
                .resize_horizontally(width + self.events, 0.0),
        }
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

    /// [`Course::hit`] of a plain course.
    pub(super) fn hit_plainly(&mut self, touch: &TreeTouch) -> Result<(), ImpactError> {
        let state = self.flow.state();
        let mut snapshot = ForestSnapshot::new(&self.problem.forest, &self.problem.gravity_m_s2);
        snapshot.set(&state);
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
    }
}
