//! Errors as Python's exceptions.

use std::io;

use enact::config::SceneError;
use enact::service::{Refusal, words};
use pyo3::call::PyCallArgs;
use pyo3::prelude::*;

/// The exceptions of the package; Python has them, with attributes and words.
const MODULE: &str = "enact_motion._errors";

/// An exception of the package.
fn exception<'py>(py: Python<'py>, name: &str, arguments: impl PyCallArgs<'py>) -> PyErr {
    let made = || py.import(MODULE)?.getattr(name)?.call1(arguments);
    made().map_or_else(|error| error, PyErr::from_value)
}

/// A scene that is refused.
pub fn of_scene(py: Python<'_>, error: &SceneError) -> PyErr {
    let place = (error.line, error.column);
    let arguments = (&error.message, error.file.as_deref(), place.0, place.1);
    exception(py, "SceneError", arguments)
}

/// Anything else that fails: by its cause.
pub fn of_any(py: Python<'_>, error: &anyhow::Error) -> PyErr {
    if let Some(error) = error.downcast_ref::<SceneError>() {
        return of_scene(py, error);
    }
    let words = words(error);
    let mut causes = error.chain();
    if let Some(io) = causes.find_map(|cause| cause.downcast_ref::<io::Error>()) {
        return io::Error::new(io.kind(), words).into();
    }
    let refusal = error.downcast_ref::<Refusal>();
    let diagnoses = refusal.map_or(&[][..], |refusal| &refusal.diagnoses);
    let likely: Vec<&str> = diagnoses.iter().map(|of| of.sentence.as_str()).collect();
    exception(py, "TakeError", (words, likely))
}
