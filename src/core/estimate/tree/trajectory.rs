//! The trajectory of trees from a node on, through events, with its derivatives by the unknowns of the interval.
//!
//! With `Φ` the flow's derivative, and `ẋ` how it goes on, a flow from one event, at `T`, to
//! another, at `T'`, changes with both: `δx' = Φ δx + ẋ (δT' − δT)`. So it does with the physical times of samples and
//! nodes where the [tempo](super::tempo) is unknown. An impact's derivative follows; where
//! the rates jump, what came before is put into one matrix and the flow begins anew.

use nalgebra::{DMatrix, DVector};

use super::law::FreeLaw;
use super::problem::TreeProblem;
use super::time_line::TimeLine;
use crate::motion::TreeTouch;
use crate::physics::impact::ImpactError;
use crate::physics::tree::tableau;
use crate::physics::tree::{
    ForestFlow, ForestSnapshot, TreeImpact, TreeImpactDerivative, TreeState,
};

/// A time on the way at which the trajectory stops.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Stop {
    /// The physical time \[s\].
    pub(super) time_s: f64,
    /// What it moves with.
    pub(super) with: With,
}

/// What a time moves with.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum With {
    /// Nothing, or nobody asks for derivatives.
    Nothing,
    /// It is that of an event: its place among the interval's.
    Event(usize),
    /// The tempo: it is acted then \[s\].
    Tempo(f64),
}

impl Stop {
    /// A time that nothing moves \[s\].
    pub(super) fn known(time_s: f64) -> Self {
        Self {
            time_s,
            with: With::Nothing,
        }
    }

    /// The time that is acted then \[s\].
    pub(super) fn acted(line: &TimeLine, acted_s: f64) -> Self {
        Self {
            time_s: line.time_s(acted_s),
            with: With::Tempo(acted_s),
        }
    }
}

/// The motion from a node on.
pub(super) struct Trajectory<'t> {
    problem: &'t TreeProblem,
    line: &'t TimeLine<'t>,
    flow: ForestFlow<'t>,
    begun: Stop,
    now: Stop,
    has_derivatives: bool,
    /// Number of events of the interval, and of unknowns.
    events: usize,
    size: usize,
    /// Where the flow began: its derivative by the interval's unknowns; none at the node itself.
    by_unknowns: Option<DMatrix<f64>>,
    /// Derivative of the flow since then.
    by_begin: DMatrix<f64>,
    /// How the state went on there, where a hand moves: elsewhere the flow leads that to how it goes on now.
    begun_rate: Option<DVector<f64>>,
}

impl<'t> Trajectory<'t> {
    /// From a node on, with derivatives where they are asked for.
    pub(super) fn new(
        problem: &'t TreeProblem,
        line: &'t TimeLine<'t>,
        node: usize,
        state: &TreeState,
        has_derivatives: bool,
    ) -> Self {
        let width = problem.width();
        let from = Stop::acted(line, problem.interval_s(node)[0]);
        Self {
            events: problem.events_of(node).len(),
            size: problem.interval_size(node),
            by_begin: DMatrix::zeros(width, width),
            ..Self::begun(problem, line, state, from, has_derivatives)
        }
    }

    /// From a state on at a physical time \[s\], with derivatives by that state alone.
    pub(super) fn of_state(
        problem: &'t TreeProblem,
        line: &'t TimeLine<'t>,
        state: &TreeState,
        from_s: f64,
    ) -> Self {
        let width = problem.width();
        Self {
            size: width,
            by_begin: DMatrix::zeros(width, width),
            ..Self::begun(problem, line, state, Stop::known(from_s), true)
        }
    }

    /// From a state on at a physical time \[s\], without derivatives.
    pub(super) fn plain(
        problem: &'t TreeProblem,
        line: &'t TimeLine<'t>,
        state: &TreeState,
        from_s: f64,
    ) -> Self {
        Self::begun(problem, line, state, Stop::known(from_s), false)
    }

    fn begun(
        problem: &'t TreeProblem,
        line: &'t TimeLine<'t>,
        state: &TreeState,
        from: Stop,
        has_derivatives: bool,
    ) -> Self {
        let mut flow = ForestFlow::new(
            &problem.forest,
            &problem.gravity_m_s2,
            tableau::DORMAND_PRINCE,
        );
        flow.begin(state, has_derivatives);
        Self {
            problem,
            line,
            flow,
            begun: from,
            now: from,
            has_derivatives,
            events: 0,
            size: 0,
            by_unknowns: None,
            by_begin: DMatrix::zeros(0, 0),
            begun_rate: None,
        }
    }

    /// The same flow by itself, without derivatives; this one goes back to its beginning.
    pub(super) fn aside(&mut self) -> Trajectory<'t> {
        self.advance(Stop::known(self.begun.time_s));
        let state = self.flow.state();
        Self::begun(self.problem, self.line, &state, self.begun, false)
    }

    /// Goes on, or back, to a time. The state is no number at one that is farther from the motion than that lasts: an event
    /// that runs away ends a step, and is not followed.
    pub(super) fn advance(&mut self, to: Stop) {
        let [from_s, to_s] = self.line.physical_span_s();
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

    /// Its derivative by the interval's unknowns; zeros where none were asked for.
    pub(super) fn jacobian(&mut self) -> DMatrix<f64> {
        if !self.has_derivatives {
            return DMatrix::zeros(self.problem.width(), self.size);
        }
        self.flow.jacobian(&mut self.by_begin);
        let mut by_unknowns = match &self.by_unknowns {
            Some(by_unknowns) => &self.by_begin * by_unknowns,
            None => self.by_begin.clone().resize_horizontally(self.size, 0.0),
        };
        let stops = [(self.begun.with, -1.0), (self.now.with, 1.0)];
        let moves = |with: &With| match with {
            With::Nothing => false,
            With::Event(_) => true,
            With::Tempo(_) => self.line.is_unknown(),
        };
        if stops.iter().any(|(with, _)| moves(with)) {
            let now = self.flow.rate();
            let begun = self.begun_rate.as_ref().map(|rate| &self.by_begin * rate);
            let rates = [begun.as_ref().unwrap_or(&now), &now];
            let width = self.problem.width();
            for ((with, sign), rate) in stops.into_iter().zip(rates) {
                let mut add = |at: usize, by: f64| {
                    let mut column = by_unknowns.column_mut(width + at);
                    column.axpy(by, rate, 1.0);
                };
                match with {
                    With::Nothing => {}
                    With::Event(event) => add(event, sign),
                    With::Tempo(acted_s) => {
                        for (piece, by) in self.line.by_log_paces(acted_s).enumerate() {
                            add(self.events + piece, sign * by);
                        }
                    }
                }
            }
        }
        by_unknowns
    }

    /// Something is hit now: the impact with its derivatives. Fails as [`ForestSnapshot::impact`] does; the trajectory then
    /// stays as it was.
    pub(super) fn hit(
        &mut self,
        snapshot: &ForestSnapshot,
        touch: &TreeTouch,
        free: &FreeLaw,
    ) -> Result<(TreeImpact, TreeImpactDerivative), ImpactError> {
        let state = self.flow.state();
        let (impact, derivative) = snapshot.impact_derivative(&state, &touch.at, &touch.law)?;
        let mut by_unknowns = self.jacobian();
        let freedoms = self.problem.forest.freedoms();
        let rates = &derivative.rates * &by_unknowns;
        by_unknowns.rows_mut(freedoms, freedoms).copy_from(&rates);
        if let (Some(carried), With::Event(event)) = (&derivative.carried, self.now.with) {
            let mut column = by_unknowns.column_mut(self.problem.width() + event);
            let mut rates = column.rows_mut(freedoms, freedoms);
            rates += &carried.rates;
        }
        let first = self.size - self.problem.parameters.len();
        for (parameter, by) in free.rates_by(&derivative) {
            let mut column = by_unknowns.column_mut(first + parameter);
            let mut rates = column.rows_mut(freedoms, freedoms);
            rates += by;
        }
        self.by_unknowns = Some(by_unknowns);
        self.go_on(state, &impact);
        Ok((impact, derivative))
    }

    /// [`Trajectory::hit`] by a law of which nothing is free, where nothing is asked of the impact.
    pub(super) fn bounce(&mut self, touch: &TreeTouch) -> Result<(), ImpactError> {
        let state = self.flow.state();
        let mut snapshot = ForestSnapshot::new(&self.problem.forest, &self.problem.gravity_m_s2);
        snapshot.set(&state);
        if self.has_derivatives {
            let fixed = FreeLaw::default();
            return self.hit(&snapshot, touch, &fixed).map(|_| ());
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
        if self.has_derivatives && self.problem.forest.is_in_hand() {
            self.begun_rate = Some(self.flow.rate());
        }
    }
}
