//! The course of a tree from a node on, through events, with its derivatives by the unknowns of the leg.
//!
//! With `Φ` the flow's derivative, and `Δ` its change with the duration, a flow from one event, at `T`, to
//! another, at `T'`, changes with both: `δx' = Φ δx + Δ (δT' − δT)`. An impact's derivative follows. Where
//! a time is an unknown, or the rates jump, what came before is put into one matrix and the flow begins anew.

use nalgebra::DMatrix;

use super::problem::TreeProblem;
use crate::motion::TreeTouch;
use crate::physics::impact::ImpactError;
use crate::physics::tree::{Flow, Snapshot, TreeImpact, TreeImpactDerivative, TreeState, tableau};

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
    flow: Flow<'t>,
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
        let mut flow = Flow::new(&problem.tree, &problem.gravity_m_s2, problem.tableau);
        flow.begin(node, true);
        Self {
            problem,
            flow,
            now: Stop::known(from_s),
            has_derivatives: true,
            events,
            by_unknowns: None,
            by_begin: DMatrix::zeros(width, width + 1),
        }
    }

    /// From a node on, without derivatives, as exactly as the motion is told in the end.
    pub(super) fn plain(problem: &'t TreeProblem, (node, from_s): (&TreeState, f64)) -> Self {
        let mut flow = Flow::new(
            &problem.tree,
            &problem.gravity_m_s2,
            tableau::DORMAND_PRINCE,
        );
        flow.begin(node, false);
        Self {
            problem,
            flow,
            now: Stop::known(from_s),
            has_derivatives: false,
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
        if self.has_derivatives {
            let mut by_unknowns = self.jacobian();
            let width = self.problem.width();
            let by_duration = self.by_begin.column(width);
            for (event, sign) in [(from.event, -1.0), (to.event, 1.0)] {
                if let Some(event) = event {
                    let mut column = by_unknowns.column_mut(width + event);
                    column.axpy(sign, &by_duration, 1.0);
                }
            }
            self.by_unknowns = Some(by_unknowns);
        }
        let state = self.flow.state();
        self.flow.begin(&state, self.has_derivatives);
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

    /// A link hits something now. Fails as [`Snapshot::impact`] does; the course then stays as it was.
    pub(super) fn hit(
        &mut self,
        snapshot: &Snapshot,
        touch: &TreeTouch,
    ) -> Result<(TreeImpact, Option<TreeImpactDerivative>), ImpactError> {
        let state = self.flow.state();
        let at = (touch.place, &touch.contact);
        let (impact, derivative) = if self.has_derivatives {
            let (impact, derivative) = snapshot.impact_derivative(&state, at, &touch.law)?;
            let mut by_unknowns = self.jacobian();
            let freedoms = self.problem.tree.freedoms();
            let rates = &derivative.rates * &by_unknowns;
            by_unknowns.rows_mut(freedoms, freedoms).copy_from(&rates);
            self.by_unknowns = Some(by_unknowns);
            (impact, Some(derivative))
        } else {
            (snapshot.impact(&state, at, &touch.law)?, None)
        };
        let after = TreeState {
            rates: impact.rates.clone(),
            ..state
        };
        self.flow.begin(&after, self.has_derivatives);
        Ok((impact, derivative))
    }
}
