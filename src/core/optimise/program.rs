//! The interface of a problem: cost and constraints over points on a manifold.

use nalgebra::DVector;

use super::envelope::Envelope;
use super::system::{Structure, System};

/// A cost and constraints over points that steps move.
///
/// Steps are right perturbations: a point need not be a vector, but its tangents are.
pub trait Program {
    /// Values of all unknowns.
    type Point: Clone;
    /// Which temporary terms are added to the cost to lead a start to the optimum; none in the
    /// finish.
    type Guidance;

    /// Which unknowns are coupled.
    fn structure(&self) -> &Structure;

    /// Evaluates cost and constraints with their derivatives at a point, into `system`. Where they
    /// are undefined the cost is not finite.
    fn evaluate(&self, guidance: &Self::Guidance, point: &Self::Point, system: &mut System);

    /// [`Program::evaluate`] of a trial that may be refused: without derivatives where they cost much more than values.
    /// What it leaves out [`Program::differentiate`] completes.
    fn try_out(&self, guidance: &Self::Guidance, point: &Self::Point, system: &mut System) {
        self.evaluate(guidance, point, system);
    }

    /// The derivatives at a point that [`Program::try_out`] left out; nothing where it leaves nothing out.
    fn differentiate(
        &self,
        _guidance: &Self::Guidance,
        _point: &Self::Point,
        _system: &mut System,
    ) {
    }

    /// [`Program::evaluate`] into a new system.
    fn evaluated(&self, guidance: &Self::Guidance, point: &Self::Point) -> System {
        let mut system = System::new(self.structure());
        self.evaluate(guidance, point, &mut system);
        system
    }

    /// `to = from ⊞ step`.
    fn retract(&self, from: &Self::Point, step: &DVector<f64>, to: &mut Self::Point);

    /// The work of an iteration at a point, in a unit of the program's own.
    fn iteration_work(&self, _point: &Self::Point) -> IterationWork {
        IterationWork::default()
    }

    /// Diagonal of the Levenberg–Marquardt damping matrix at `λ = 1`: `10/s²` times the least
    /// [`Program::information`], with a typical step length `s` for every kind of unknown.
    fn damping(&self) -> DVector<f64>;

    /// Whether the cost leaves directions open that constraints do not determine either, but for terms
    /// that are next to nothing.
    fn is_open(&self) -> bool {
        false
    }

    /// Whether hard constraints are curved strongly along what else holds, as the length of a vector is,
    /// so that the Lagrangian may be concave along them far from the optimum.
    fn is_curved(&self) -> bool {
        false
    }

    /// Scale of the cost's Hessian relative to the problem for which the weights of a
    /// [`Schedule`](super::Schedule) are given: least and greatest over the kinds of residuals.
    /// Weights of constraints are multiplied by it, so that they keep their proportion to the cost.
    fn information(&self) -> (f64, f64);

    /// Adds what the cost's Hessian lacks of the Lagrangian's, `Σ_k ν_k ∇²c_k + Σ_i r_i ∇²r_i` with
    /// multipliers `ν`, row by row. Rows with their curvature in closed form
    /// ([`Block::curvature`](super::block::Block::curvature),
    /// [`Block::second`](super::block::Block::second)) are left out: theirs is added by the
    /// optimiser.
    fn add_curvature(
        &self,
        at: (&Self::Point, &System),
        multipliers: &[f64],
        hessian: &mut Envelope,
    );
}

/// The work of an iteration, counted and not timed: limits of it end a solve at the same place on every machine.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct IterationWork {
    /// Without second derivatives,
    pub plain: usize,
    /// and with them.
    pub curved: usize,
}
