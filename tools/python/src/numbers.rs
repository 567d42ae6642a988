//! Arrays as bytes.

use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::PyBytes;

/// The numbers in bytes.
pub fn of_bytes(bytes: &[u8]) -> PyResult<Vec<f64>> {
    let (numbers, rest) = bytes.as_chunks::<8>();
    match rest {
        [] => Ok(numbers.iter().map(|of| f64::from_ne_bytes(*of)).collect()),
        _ => Err(PyValueError::new_err("expected numbers of 64 bits")),
    }
}

/// The bytes of numbers.
pub fn to_bytes<'py>(
    py: Python<'py>,
    numbers: impl IntoIterator<Item = f64>,
) -> Bound<'py, PyBytes> {
    let bytes: Vec<u8> = numbers.into_iter().flat_map(f64::to_ne_bytes).collect();
    PyBytes::new(py, &bytes)
}
