//! Covariance of the estimate.
//!
//! At the optimum the unknowns `u` respond to errors `n` of the samples by `−P Jᵀ n`. Here `J` is
//! the residuals' derivative and `P = Z (Zᵀ H Z)⁻¹ Zᵀ`, with the Hessian `H` and a basis `Z` of the
//! constraints' null space. `P` is the limit of `(H + w CᵀC)⁻¹` for large `w`, with the
//! constraints' derivative `C`; that matrix is factorised as in the finish. For one unknown `u_k`,
//! with `x = P e_k`,
//!
//! ```text
//! var u_k = yᵀ Σ y + xᵀ H_p x,     y = J x,   xᵀ H_p x = x_k − |y|²
//! ```
//!
//! Where a goal on a coordinate holds, `H` contains the curvature of constraints and residuals
//! (`curvature`): through it alone the time of a goal at an apex responds to errors. It counts
//! neither as samples nor as a prior.
//!
//! A goal that has a weight is a prior too, as if its quantity were known to be in its set to that
//! standard deviation: between none and a hard goal, which is taken as exact, as the deviation goes from
//! large to small.
//!
//! This is the sandwich estimator (Huber 1967; White 1982). The weights in `H` determine how errors
//! propagate, although they are not the inverse of the errors' covariance `Σ`; `Σ` determines their
//! size. `H_p` is the part of `H` from priors (tempo, parameters, priced velocity gaps), whose
//! standard deviations are given and taken as they are.
//!
//! `Σ` is the sum of white noise and a hand's wander ([`noise`]), which may be as slow as a flight.
//! Then the flight's own fit absorbs most of it, and the remaining residuals look small and
//! short-lived. But the constraints restrict the fit: few of the twelve numbers of every flight are
//! free, so that a slow wander contradicts them. A restricted likelihood ([`likelihood`]) over
//! means of some samples each ([`bins`]) accounts for the directions that the fit can absorb
//! ([`trace`]). Where times are unknown, it absorbs the component along the flight in every bin.
//!
//! A parameter or a time at its bound is not better determined for that: its bounds count as a prior
//! with a standard deviation of half their width. Its deviation also covers what the performance asks
//! for beyond the bound ([`Covariance::beyond_bounds`]): samples without noise that contradict a
//! bound would seem to determine it to a micrometre.

pub mod bins;
pub mod certainty;
pub mod likelihood;
pub(in crate::estimate) mod linearised;
pub mod noise;
pub(in crate::estimate) mod timing;
pub mod trace;
pub(in crate::estimate) mod whitened;

#[cfg(test)]
mod tests;

pub use certainty::{Covariance, Moment};
