//! The objective: residuals of [`samples`], of points, directions and covariances (`levered`, `lever_rows`), in short form
//! (`short`) and where parameters act (`observed`, `modelled`), of the [`tempo`], of [`mark`]s and of bodies in the hand ([`held`]);
//! summed (`objective`) in a [`context`] that is fixed during a solve.

pub mod context;
pub(in crate::estimate) mod following;
pub mod held;
pub(in crate::estimate) mod lever_rows;
pub(in crate::estimate) mod levered;
pub mod mark;
pub(in crate::estimate) mod modelled;
pub(in crate::estimate) mod objective;
pub(in crate::estimate) mod observed;
pub mod samples;
pub(in crate::estimate) mod short;
pub mod tempo;
pub mod woven;
