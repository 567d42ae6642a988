//! A library's explicit methods of high order, which choose their steps by tolerance.

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
}

struct Equations<'s, 'c>(&'s RefCell<&'s mut System<'c>>);

impl<const N: usize> ODE<f64, [f64; N]> for Equations<'_, '_> {
    fn diff(&self, _: f64, y: &[f64; N], slope: &mut [f64; N]) {
        self.0.borrow_mut().slope(y, slope);
    }
}

/// Moves a list on for a time; whether the library got there. It wants to know at compile time how long lists are; of
/// other lengths than these there are none.
pub fn advance(
    system: &mut System,
    y: &mut [f64],
    duration_s: f64,
    scheme: Scheme,
    tolerance: f64,
) -> bool {
    macro_rules! of_length {
        ($($length:literal),*) => {
            match y.len() {
                $($length => moved::<$length>(system, y, duration_s, scheme, tolerance),)*
                other => panic!("a list of {other} numbers"),
            }
        };
    }
    let end = of_length!(4, 6, 8, 10, 12, 14, 15, 16, 20, 21, 32, 35, 56);
    let Some(end) = end else { return false };
    y.copy_from_slice(&end);
    system.layout.normalise(y);
    true
}

fn moved<const N: usize>(
    system: &mut System,
    y: &[f64],
    duration_s: f64,
    scheme: Scheme,
    tolerance: f64,
) -> Option<Vec<f64>> {
    const MOST: usize = 100_000;
    let start: [f64; N] = y.try_into().ok()?;
    let cell = RefCell::new(system);
    let equations = Equations(&cell);
    let problem = IVP::ode(&equations, 0.0, duration_s, start);
    macro_rules! solved {
        ($method:expr) => {
            problem
                .method($method.rtol(tolerance).atol(tolerance).max_steps(MOST))
                .t_eval([duration_s])
                .solve()
        };
    }
    let solution = match scheme {
        Scheme::DormandPrince853 => solved!(ExplicitRungeKutta::dop853()),
        Scheme::Verner9 => solved!(ExplicitRungeKutta::rkv989e()),
    };
    solution.ok()?.y.last().map(|end| end.to_vec())
}
