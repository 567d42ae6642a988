//! Sampling: covariance matrix adaptation over the unknowns of single shooting.
//!
//! What must hold is priced by an augmented Lagrangian whose multipliers follow the mean (Atamna,
//! Auger and Hansen, "Augmented Lagrangian Constraint Handling for CMA-ES", PPSN 2016, in its
//! simplest form): a penalty alone would leave violations, or an ill-conditioned valley.

use std::cell::RefCell;

use cmaes::CMAESOptions;
use enact::estimate::terms::context::Guidance;
use enact::optimise::Program;
use enact::optimise::lagrangian::AugmentedLagrangian;
use nalgebra::DVector;

use super::model::Model;
use super::parts::Part;
use super::setting::Place;

/// Size of the first samples: position \[m\], orientation \[rad\], velocity [m/s], angular velocity
/// [rad/s]; times \[s\]; velocity gaps \[units\].
const STATE: [f64; 4] = [0.01, 0.1, 0.1, 1.0];
const TIME_S: f64 = 0.005;
const GAP: f64 = 1.0;
/// First and greatest weight of the constraints, per squared unit and information; it grows by
/// this factor where multipliers do not halve the violation.
const WEIGHTS: (f64, f64) = (10.0, 1e4);
const GROWTH: f64 = 3.0;
/// Generations between two updates of the multipliers.
const GENERATIONS: usize = 30;

/// The best mean within so many evaluations; a seed gives the same one always.
pub fn search(model: &Model, start: &Place, evaluations: usize, seed: u64) -> Place {
    if !start.exists {
        return start.clone();
    }
    let problem = model.problem();
    let guidance = Guidance::none();
    let of = |part: Part| match part {
        Part::Piece(_) => STATE.iter().flat_map(|sd| [*sd; 3]).collect(),
        Part::Event(_) => vec![TIME_S],
        Part::Parameter(p) => vec![0.3 * problem.parameters[p].length()],
    };
    let scale = model.by_unknown(of, GAP);
    let system = model.evaluated(&guidance, start);
    let lagrangian = RefCell::new(AugmentedLagrangian::new(
        &system,
        WEIGHTS.0 * problem.information(),
    ));
    let shared = RefCell::new((model, system));
    let place = |model: &Model, x: &[f64]| {
        model.moved(start, &DVector::from_column_slice(x).component_mul(&scale))
    };
    let cost = |x: &cmaes::DVector<f64>| {
        let (model, system) = &mut *shared.borrow_mut();
        let place = place(model, x.as_slice());
        model.values(&guidance, &place, system);
        match lagrangian.borrow().merit(system) {
            merit if merit.is_finite() => merit,
            // The strategy ranks; what is no motion is worst.
            _ => f64::MAX,
        }
    };
    let mut strategy = CMAESOptions::new(vec![0.0; scale.len()], 1.0)
        .tol_fun(0.0)
        .tol_fun_hist(0.0)
        .tol_x(0.0)
        .tol_stagnation(usize::MAX)
        .tol_condition_cov(f64::INFINITY)
        .max_function_evals(evaluations)
        .seed(seed)
        .build(cost)
        .expect("a size and a dimension that are positive");
    let mut generation = 0;
    let mut violation = f64::INFINITY;
    while strategy.next().is_none() {
        generation += 1;
        if generation % GENERATIONS == 0 {
            let (model, system) = &mut *shared.borrow_mut();
            let mean = place(model, strategy.mean().as_slice());
            if mean.exists {
                model.values(&guidance, &mean, system);
                let mut lagrangian = lagrangian.borrow_mut();
                lagrangian.update(system);
                let now = system.violation();
                if now > 0.5 * violation {
                    let most = WEIGHTS.1 * problem.information();
                    lagrangian.weight = (lagrangian.weight * GROWTH).min(most);
                    lagrangian.leading_weight = lagrangian.weight;
                }
                violation = now;
            }
        }
    }
    let mean = strategy.mean().as_slice().to_vec();
    let (model, _) = &*shared.borrow();
    place(model, &mean)
}
