use kiln::Control;
use pyo3::exceptions::{PyOSError, PyRuntimeError};
use pyo3::prelude::*;
use std::sync::{Condvar, Mutex, PoisonError};
use std::thread::Builder;
use std::time::Duration;

/// How often Python is asked for signals while it waits.
pub const BREATH: Duration = Duration::from_millis(50);
/// As in the program: importers may recurse as deep as the limit on nesting allows.
const STACK_BYTES: usize = 16 << 20;

/// Does work on a thread of its own while other Python threads run. A signal that Python turns into an exception (Ctrl-C)
/// stops the work through `control`, and is raised when it has stopped.
pub fn interruptible<T: Send>(py: Python<'_>, control: &Control, work: impl FnOnce() -> T + Send) -> PyResult<T> {
    let done = (Mutex::new(false), Condvar::new());
    std::thread::scope(|scope| {
        let task = || {
            let result = work();
            *done.0.lock().unwrap_or_else(PoisonError::into_inner) = true;
            done.1.notify_all();
            result
        };
        let worker = Builder::new().stack_size(STACK_BYTES).spawn_scoped(scope, task).map_err(PyOSError::new_err)?;
        let mut signal = None;
        while !worker.is_finished() {
            let finished = py.detach(|| {
                let guard = done.0.lock().unwrap_or_else(PoisonError::into_inner);
                let waited = done.1.wait_timeout_while(guard, BREATH, |done| !*done);
                *waited.unwrap_or_else(PoisonError::into_inner).0
            });
            if signal.is_none()
                && let Err(raised) = py.check_signals()
            {
                control.stop();
                signal = Some(raised);
            }
            if finished {
                break;
            }
        }
        let result = py.detach(|| worker.join());
        match (signal, result) {
            (Some(signal), _) => Err(signal),
            (None, Ok(result)) => Ok(result),
            (None, Err(_)) => Err(PyRuntimeError::new_err("an internal error of Kiln")),
        }
    })
}

/// Chooses how many threads render, before the first render.
#[pyfunction]
pub fn set_threads(threads: usize) -> PyResult<()> {
    let built = rayon::ThreadPoolBuilder::new().num_threads(threads).build_global();
    built.map_err(|_| PyRuntimeError::new_err("threads can be chosen only once, before the first render"))
}
