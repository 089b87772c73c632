use pyo3::create_exception;
use pyo3::exceptions::PyException;
use pyo3::prelude::*;

create_exception!(kiln, AssetError, PyException, "An asset cannot be rendered; `code` is a stable word for why.");

/// An [`AssetError`] with its code.
pub fn asset_error(py: Python<'_>, code: &str, message: &str) -> PyErr {
    let error = AssetError::new_err(message.to_owned());
    match error.value(py).setattr("code", code) {
        Ok(()) => error,
        Err(other) => other,
    }
}
