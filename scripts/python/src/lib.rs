//! The native part of the Python package `kiln`; `python/kiln/__init__.py` is what people use.
//!
//! Everything that takes long runs on a thread of its own while the interpreter is free, and stops on Ctrl-C.

mod batch;
mod error;
mod options;
mod picture;
mod scene;
mod wait;

use pyo3::prelude::*;

/// The module `kiln._kiln`.
#[pymodule]
fn _kiln(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add("__version__", env!("CARGO_PKG_VERSION"))?;
    module.add("AssetError", module.py().get_type::<error::AssetError>())?;
    module.add_class::<scene::Scene>()?;
    module.add_class::<batch::Batch>()?;
    module.add_function(wrap_pyfunction!(scene::load, module)?)?;
    module.add_function(wrap_pyfunction!(picture::render, module)?)?;
    module.add_function(wrap_pyfunction!(picture::develop, module)?)?;
    module.add_function(wrap_pyfunction!(batch::batch, module)?)?;
    module.add_function(wrap_pyfunction!(wait::set_threads, module)?)
}
