//! Covariance of the estimate.
//!
//! At the optimum the unknowns `u` respond to errors `n` of the samples, of unit variance, by `−P Jᵀ n`. Here `J` is
//! the residuals' derivative and `P = Z (Zᵀ H Z)⁻¹ Zᵀ`, with the Hessian `H` and a basis `Z` of the
//! constraints' null space. `P` is the limit of `(H + w CᵀC)⁻¹` for large `w`, with the
//! constraints' derivative `C`; that matrix is factorised as in the finish. For one unknown `u_k`,
//! with `x = P e_k`,
//!
//! ```text
//! var u_k = |y|² + xᵀ H_p x,     y = J x,   xᵀ H_p x = x_k − |y|²
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
//! The weights of samples are those of their errors, which are a process in time ([`wander`](super::wander)). Where a motion
//! was found with each sample weighed by itself, that process is told at it ([`in_time`]); where residuals are too few to tell
//! it, weights are taken as the scene states them. What residuals leave open of a hand makes intervals wider. `H_p` is the part of `H` from priors (tempo, parameters, priced velocity
//! gaps), whose standard deviations are given and taken as they are.
//!
//! A parameter or a time at its bound is not better determined for that: its bounds count as a prior
//! with a standard deviation of half their width. Its deviation also covers what the performance asks
//! for beyond the bound ([`Covariance::beyond_bounds`]): samples without noise that contradict a
//! bound would seem to determine it to a micrometre.

pub mod certainty;
pub mod in_time;
pub(in crate::estimate) mod linearised;
pub mod residuals;
pub(in crate::estimate) mod timing;
mod vague;
pub(in crate::estimate) mod whitened;

#[cfg(test)]
mod tests;

pub use certainty::Covariance;
pub use timing::Moment;
