//! How an optimum follows what some of its equalities ask for.
//!
//! Let `f*(t) = min f(x)  s.t.  c_r(x) = t_r` for some rows `r`, beside all other constraints. By the envelope theorem
//! `∂f*/∂t_r = −ν_r`, and with the change `T = dx/dt` of the optimum, which holds all linearised rows, and the
//! Lagrangian's Hessian `L` its second derivative is `Tᵀ L T`: the Schur complement of these rows in the system of Karush,
//! Kuhn and Tucker (Nocedal and Wright, *Numerical Optimization*, chapters 12 and 16).

use nalgebra::{DMatrix, DVector};

use super::active::ActiveSet;
use super::envelope::Envelope;
use super::kkt::Kkt;
use super::program::Program;
use super::schedule::Solution;
use super::system::System;

/// Greatest number of Newton's steps to an optimum to rounding.
const STEPS: usize = 8;
/// A step that is no shorter than this share of the one before is rounding.
const SHORTER: f64 = 0.25;
/// A step that gains less than this share of the cost, or of one, is the last: the next would be as its square.
const GAINED: f64 = 1e-16;

/// Derivatives of an optimum by what rows ask for, in units of the rows.
#[derive(Clone, Debug)]
pub struct Reduced {
    /// `∂f*/∂t`.
    pub gradient: DVector<f64>,
    /// `∂²f*/∂t²`.
    pub curvature: DMatrix<f64>,
    /// `dx/dt`, a tangent for each row.
    pub responses: Vec<DVector<f64>>,
}

impl Reduced {
    /// The derivatives by the equalities `rows` at an optimum, which is brought to rounding first; `None` where its
    /// system cannot be factorised.
    pub fn of<P: Program>(
        program: &P,
        guidance: &P::Guidance,
        solution: &mut Solution<P::Point>,
        rows: &[usize],
    ) -> Option<Self> {
        let structure = program.structure();
        let (kkt, exact) = polished(program, guidance, solution)?;
        let system = &solution.system;
        let responses = rows.iter().map(|row| {
            let response = kkt.response(structure, system, Some(&exact), *row);
            response.delta
        });
        let responses: Vec<DVector<f64>> = responses.collect();
        let closed = system.curvature(structure, |row| solution.multipliers[row]);
        let products = responses.iter().map(|response| {
            let mut product = DVector::zeros(response.len());
            exact.multiply_add(&structure.pattern, response, &mut product);
            for of in &closed {
                of.multiply_add(response, &mut product);
            }
            product
        });
        let products: Vec<DVector<f64>> = products.collect();
        let count = rows.len();
        let curvature = DMatrix::from_fn(count, count, |a, b| {
            0.5 * (responses[a].dot(&products[b]) + responses[b].dot(&products[a]))
        });
        let gradient = rows.iter().map(|row| -solution.multipliers[*row]);
        let gradient = DVector::from_iterator(count, gradient);
        let is_finite = gradient.iter().chain(&curvature).all(|x| x.is_finite());
        is_finite.then_some(Self {
            gradient,
            curvature,
            responses,
        })
    }
}

/// The factorised system with the Lagrangian's Hessian.
fn factorised<P: Program>(program: &P, solution: &Solution<P::Point>) -> Option<(Kkt, Envelope)> {
    let Solution {
        point,
        system,
        multipliers,
        ..
    } = solution;
    let mut exact = system.hessian.clone();
    program.add_curvature((point, system), multipliers, &mut exact);
    let active = ActiveSet::of(system, multipliers, program.information().1);
    let kkt = Kkt::with(program, system, Some(&exact), multipliers, &active)?;
    Some((kkt, exact))
}

/// Newton's steps until they are rounding, with the system of the last. A solve ends where a further step would gain next to
/// nothing of the cost, which leaves half as many digits of the unknowns.
fn polished<P: Program>(
    program: &P,
    guidance: &P::Guidance,
    solution: &mut Solution<P::Point>,
) -> Option<(Kkt, Envelope)> {
    let structure = program.structure();
    let mut before = f64::INFINITY;
    let mut steps = 0;
    loop {
        let (kkt, exact) = factorised(program, solution)?;
        let step = kkt.step(structure, &solution.system, Some(&exact));
        let mut product = DVector::zeros(step.delta.len());
        exact.multiply_add(&structure.pattern, &step.delta, &mut product);
        let gained = step.delta.dot(&product).abs();
        if steps == STEPS || !(gained < SHORTER * SHORTER * before) {
            return Some((kkt, exact));
        }
        (before, steps) = (gained, steps + 1);
        let (mut point, mut system) = (solution.point.clone(), System::new(structure));
        program.retract(&solution.point, &step.delta, &mut point);
        program.evaluate(guidance, &point, &mut system);
        if !system.cost.is_finite() {
            return Some((kkt, exact));
        }
        (solution.point, solution.system) = (point, system);
        solution.multipliers = step.multipliers;
        if gained < GAINED * solution.system.cost.max(1.0) {
            return Some((kkt, exact));
        }
    }
}
