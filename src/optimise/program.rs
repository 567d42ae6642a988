//! What is minimised.

use nalgebra::DVector;

use super::envelope::Envelope;
use super::system::{Structure, System};

/// A cost and constraints over points that steps move.
///
/// Steps are right perturbations: a point need not be a vector, but its tangents are.
pub trait Program {
    /// A value of all unknowns.
    type Point: Clone;
    /// Terms that lead the way and are gone at the end.
    type Guidance;

    /// Which unknowns meet.
    fn structure(&self) -> &Structure;

    /// Evaluates cost and constraints with their derivatives at a point. Where there is no value the
    /// cost is not finite.
    fn evaluate(&self, guidance: &Self::Guidance, point: &Self::Point, system: &mut System);

    /// The system at a point.
    fn evaluated(&self, guidance: &Self::Guidance, point: &Self::Point) -> System {
        let mut system = System::new(self.structure());
        self.evaluate(guidance, point, &mut system);
        system
    }

    /// Moves `from` by a step, into `to`.
    fn retract(&self, from: &Self::Point, step: &DVector<f64>, to: &mut Self::Point);

    /// Diagonal of the damping at `λ = 1`: `10/s²` with a length `s` for every kind of unknown, in
    /// multiples of the least information.
    fn damping(&self) -> DVector<f64>;

    /// How much the cost knows, at the least and at the most, against what weights and prices of a
    /// schedule are made for: they are multiples of it.
    fn information(&self) -> (f64, f64);

    /// Adds the constraints' curvature `Σ ν ∇²c` under multipliers `ν`, row by row, to a Hessian; rows
    /// that say theirs ([`Block::curvature`](super::block::Block::curvature)) are left out.
    fn add_curvature(
        &self,
        at: (&Self::Point, &System),
        multipliers: &[f64],
        hessian: &mut Envelope,
    );
}
