//! Constrained least squares: the least of a cost of which value, gradient and a positive semidefinite
//! Hessian are known, while rows of constraints stay within bounds.
//!
//! What is minimised is a [`Program`]: it says which unknowns meet ([`Structure`]), evaluates all at a
//! point ([`System`]) and moves points by steps. Nothing here knows what the unknowns are.
//! [`schedule`] is the way from a start to the optimum: [`descend`] on the augmented [`lagrangian`],
//! then [`finish`] by the steps of [`kkt`], with [`active`] and [`qp`] to say which bounds act. Matrices
//! are [`envelope`]s, rows of constraints are in [`block`]s.

pub mod active;
pub mod block;
pub mod descend;
pub mod envelope;
pub mod finish;
pub mod kkt;
pub mod lagrangian;
mod program;
pub mod qp;
pub mod schedule;
pub mod system;
mod work;

pub use self::program::Program;
pub use self::schedule::{Schedule, Solution, Stage, Watch, solve};
pub use self::system::{Structure, System};
pub use self::work::Work;
