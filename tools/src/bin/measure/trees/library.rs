//! A library's methods that choose their steps by tolerance: explicit ones of high order, and Radau's.

use std::cell::RefCell;

use differential_equations::prelude::*;

use super::system::System;

/// Which of its methods.
#[derive(Clone, Copy)]
pub enum Scheme {
    /// Hairer, Nørsett and Wanner's, order 8.
    DormandPrince853,
    /// Verner's efficient pair, order 9.
    Verner9,
    /// Implicit, order 5, its Jacobians by differences.
    Radau5,
}

struct Equations<'s, 'c>(&'s RefCell<&'s mut System<'c>>);

impl ODE<f64, Vec<f64>> for Equations<'_, '_> {
    fn diff(&self, _: f64, y: &Vec<f64>, slope: &mut Vec<f64>) {
        self.0.borrow_mut().slope(y, slope);
    }
}

/// Moves a list on for a time; whether the library got there.
pub fn advance(
    system: &mut System,
    y: &mut Vec<f64>,
    duration_s: f64,
    scheme: Scheme,
    tolerance: f64,
) -> bool {
    const MOST: usize = 100_000;
    let cell = RefCell::new(system);
    let equations = Equations(&cell);
    let problem = || IVP::ode(&equations, 0.0, duration_s, y.clone());
    let solution = match scheme {
        Scheme::DormandPrince853 => problem()
            .method(ExplicitRungeKutta::dop853().rtol(tolerance).atol(tolerance).max_steps(MOST))
            .t_eval([duration_s])
            .solve(),
        Scheme::Verner9 => problem()
            .method(ExplicitRungeKutta::rkv989e().rtol(tolerance).atol(tolerance).max_steps(MOST))
            .t_eval([duration_s])
            .solve(),
        Scheme::Radau5 => problem()
            .method(ImplicitRungeKutta::radau5().rtol(tolerance).atol(tolerance).max_steps(MOST))
            .t_eval([duration_s])
            .solve(),
    };
    let end = solution.ok().and_then(|solution| solution.y.last().cloned());
    let Some(end) = end else { return false };
    *y = end;
    cell.borrow().layout.normalise(y);
    true
}
