//! The module `enact_motion._core`: what Python calls of `enact`, in texts and bytes of numbers.
//!
//! The package `enact_motion` beside it makes arrays and records of them, and has the documentation. An array is the bytes of
//! its numbers, 64 bits each in the machine's order, row by row: so numpy stays out of here, and out of `import`.

#![forbid(unsafe_code)]

mod errors;
mod estimate;
mod fit;
mod numbers;
mod scene;
mod take;
mod watch;

use pyo3::prelude::*;

/// The module.
#[pymodule(gil_used = false)]
mod _core {
    #[pymodule_export]
    use super::estimate::Estimate;
    #[pymodule_export]
    use super::fit::{fit_takes, join_blocks, reduce_take};
    #[pymodule_export]
    use super::scene::Scene;
    #[pymodule_export]
    use super::take::Take;
}
