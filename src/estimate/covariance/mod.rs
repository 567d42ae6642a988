//! How certain the estimate is.
//!
//! At the optimum an estimate `u` answers to errors `n` of the samples as `−P Jᵀ n`, where `J` is the
//! residuals' derivative, `P = Z (Zᵀ H Z)⁻¹ Zᵀ` with `H` the Hessian and `Z` spanning the directions
//! that the constraints leave free: the limit of `(H + w CᵀC)⁻¹` for large `w`, `C` the constraints'
//! derivative, and the finish has that matrix factorised. So of one unknown `u_k` with `x = P e_k`
//!
//! ```text
//! var u_k = yᵀ Σ y + xᵀ H_p x,     y = J x,   xᵀ H_p x = x_k − |y|²
//! ```
//!
//! the sandwich estimator (Huber 1967; White 1982): the weights `H` are made of, though not the
//! errors' covariance `Σ`, say how errors arrive, and `Σ` how large they are. `H_p` is the share of
//! priors (tempo, parameters, priced velocity gaps), whose standard deviations are stated and taken
//! at their word.
//!
//! `Σ` is white noise and a hand's wander ([`noise`]), and the wander may be as slow as a flight. Then
//! the flight's own fit absorbs most of it, and what is left of it looks small and short-lived. But
//! the constraints hold the fit: of the twelve numbers of every flight few are free, so that a slow
//! wander shows as contradiction to them, and a restricted likelihood ([`likelihood`]) over means of
//! some samples each ([`bins`]) knows what the fit could take away ([`trace`]). Where times are
//! unknown it takes away what lies along the flight in every bin.
//!
//! What a bound keeps in place is no better known for it: the bounds of a parameter count as a
//! standard deviation of half their width.

pub mod bins;
pub mod certainty;
pub mod likelihood;
pub mod noise;
pub mod trace;

#[cfg(test)]
mod tests;

pub use certainty::{Covariance, Moment};
