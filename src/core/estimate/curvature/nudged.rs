//! A point of which one unknown at a time is displaced, for differences of exact derivatives.

use nalgebra::{DMatrix, DVector};

use crate::estimate::terms::context::SolveContext;
use crate::estimate::unknowns::point::Point;
use crate::optimise::block::BlockPattern;
use crate::optimise::envelope::Envelope;
use crate::physics::State;
use crate::physics::state::{self, StateTangent};

/// Steps of the differences: position [m], orientation [rad], velocity [m/s], angular velocity
/// [rad/s].
const STEPS: [f64; 4] = [5e-6, 1e-5, 5e-5, 5e-5];
/// Step of a time \[s\].
pub(super) const TIME_STEP_S: f64 = 1e-6;
/// Step of a parameter, relative to its length.
const PARAMETER_STEP: f64 = 1e-5;

/// The part of the point to which an unknown belongs.
#[derive(Clone, Copy)]
enum NudgedOwner {
    State {
        arc: usize,
        entry: usize,
    },
    /// Of a held body at a collision.
    Held {
        index: usize,
        entry: usize,
    },
    Event(usize),
    Parameter(usize),
    /// The time of a node, on which no constraint depends.
    Node,
}

/// A point of which one unknown at a time is displaced.
pub(super) struct Nudged<'a> {
    /// Where the point is one of.
    pub(super) context: &'a SolveContext<'a>,
    /// The point with nothing displaced.
    pub(super) origin: &'a Point,
    point: Point,
    owners: Vec<NudgedOwner>,
    /// Two values of `Jᵀν` over all unknowns, zero between uses.
    pulls: [Vec<f64>; 2],
}

impl<'a> Nudged<'a> {
    /// The origin, with nothing displaced.
    pub(super) fn new(context: &'a SolveContext<'a>, origin: &'a Point) -> Self {
        let layout = context.layout;
        let mut owners = vec![NudgedOwner::Node; layout.size()];
        for (arc, at) in layout.arcs.iter().enumerate() {
            for entry in 0..state::DIMENSION {
                owners[at + entry] = NudgedOwner::State { arc, entry };
            }
        }
        for (index, at) in layout.held.iter().enumerate() {
            for entry in 0..state::DIMENSION {
                owners[at + entry] = NudgedOwner::Held { index, entry };
            }
        }
        for (event, at) in layout.events.iter().enumerate() {
            if let Some(at) = at {
                owners[*at] = NudgedOwner::Event(event);
            }
        }
        for (parameter, at) in layout.parameters.iter().enumerate() {
            owners[*at] = NudgedOwner::Parameter(parameter);
        }
        Self {
            context,
            origin,
            point: origin.clone(),
            pulls: [vec![0.0; layout.size()], vec![0.0; layout.size()]],
            owners,
        }
    }

    /// Step of a difference by an unknown, in its unit.
    pub(super) fn step(&self, unknown: usize) -> f64 {
        match self.owners[unknown] {
            NudgedOwner::State { entry, .. } | NudgedOwner::Held { entry, .. } => STEPS[entry / 3],
            NudgedOwner::Event(_) | NudgedOwner::Node => TIME_STEP_S,
            NudgedOwner::Parameter(index) => {
                PARAMETER_STEP * self.context.problem.parameters[index].length()
            }
        }
    }

    /// Displaces one unknown from the origin; zero restores it.
    fn nudge(&mut self, unknown: usize, by: f64) {
        match self.owners[unknown] {
            NudgedOwner::State { arc, entry } => {
                self.point.arcs[arc] = nudged(&self.origin.arcs[arc], entry, by);
            }
            NudgedOwner::Held { index, entry } => {
                self.point.held[index] = nudged(&self.origin.held[index], entry, by);
            }
            NudgedOwner::Event(event) => {
                self.point.event_times_s[event] = self.origin.event_times_s[event] + by;
            }
            NudgedOwner::Parameter(index) => {
                self.point.parameters[index] = self.origin.parameters[index] + by;
            }
            NudgedOwner::Node => {}
        }
    }

    /// Derivatives of a list of numbers by some unknowns, column by column.
    pub(super) fn slopes(
        &mut self,
        unknowns: &[usize],
        of: impl Fn(&Point) -> DVector<f64>,
    ) -> DMatrix<f64> {
        let columns = unknowns.iter().map(|unknown| {
            let step = self.step(*unknown);
            let [after, before] = [step, -step].map(|by| {
                self.nudge(*unknown, by);
                of(&self.point)
            });
            self.nudge(*unknown, 0.0);
            (after - before) / (2.0 * step)
        });
        DMatrix::from_columns(&columns.collect::<Vec<_>>())
    }

    /// Adds the symmetric part of the derivative of `pull` by the unknowns of some patterns.
    pub(super) fn add_curvature(
        &mut self,
        patterns: &[&BlockPattern],
        mut pull: impl FnMut(&Point, &mut [f64]),
        matrix: &mut Envelope,
    ) {
        let mut unknowns: Vec<usize> = patterns
            .iter()
            .flat_map(|pattern| pattern.cliques().flatten())
            .collect();
        unknowns.sort_unstable();
        unknowns.dedup();
        for unknown in &unknowns {
            let step = self.step(*unknown);
            for (side, by) in [step, -step].into_iter().enumerate() {
                self.nudge(*unknown, by);
                pull(&self.point, &mut self.pulls[side]);
            }
            self.nudge(*unknown, 0.0);
            for other in &unknowns {
                let [after, before] = [0, 1].map(|side| self.pulls[side][*other]);
                let value = 0.5 * (after - before) / (2.0 * step);
                // Half from (i, j) and half from (j, i); the diagonal entry counts in full.
                let value = if other == unknown { 2.0 * value } else { value };
                if value != 0.0 && value.is_finite() {
                    let (row, column) = (*unknown.max(other), *unknown.min(other));
                    matrix.add(&self.context.layout.structure.pattern, row, column, value);
                }
                self.pulls[0][*other] = 0.0;
                self.pulls[1][*other] = 0.0;
            }
        }
    }
}

/// A state displaced along one entry of its tangent.
fn nudged(origin: &State, entry: usize, by: f64) -> State {
    let mut delta = StateTangent::zeros();
    delta[entry] = by;
    if by == 0.0 {
        *origin
    } else {
        origin.retract(&delta)
    }
}
