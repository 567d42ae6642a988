//! Constrained least squares on a manifold:
//!
//! ```text
//! min f(x)   s.t.  lower ≤ c(x) ≤ upper, row by row
//! ```
//!
//! where `f` is half a sum of squares with value, gradient `g` and a positive semidefinite Hessian
//! `H`, and `c` has values, bounds and a Jacobian `J`. A row with `lower = upper` is an equality.
//!
//! A problem is a [`Program`]: it says which unknowns are coupled ([`Structure`]), evaluates
//! everything at a point ([`System`]) and moves points by steps. Nothing here knows what the
//! unknowns are. [`schedule`] leads from a start to the optimum: [`descend`] minimises the
//! augmented [`lagrangian`] by Levenberg–Marquardt, then [`finish`] takes
//! sequential-quadratic-programming steps with [`kkt`]; [`active`] and [`qp`] find the active set.
//! Matrices are [`envelope`]s, constraints are stored in [`block`]s. The methods are those of
//! Nocedal and Wright, *Numerical Optimization* (2nd edition): chapter 10 (Levenberg–Marquardt), 16
//! (quadratic programmes), 17 (augmented Lagrangian), 18 (sequential quadratic programming).

pub mod active;
pub mod block;
pub mod descend;
pub mod envelope;
pub mod finish;
pub mod kkt;
pub mod lagrangian;
mod program;
pub mod qp;
pub mod reduced;
pub mod schedule;
pub mod system;
pub mod trust;
mod work;

pub use self::program::{IterationWork, Program};
pub use self::schedule::{Schedule, Solution, Stage, Watch, solve};
pub use self::system::{Structure, System};
pub use self::work::Work;
