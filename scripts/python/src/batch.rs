use crate::options;
use crate::wait::BREATH;
use globset::{Glob, GlobSet, GlobSetBuilder};
use kiln::Control;
use kiln::batch::{
    Batch as Assets, Discovery, FileSink, Found, Job, LoadedEnvironment, Manifest, Observer, Outcome, Output,
    OutputLock, Policy, Stage, Workshop, discover, schedule, settings_digest,
};
use kiln::formats::Limits;
use kiln::gallery::Gallery;
use kiln::settings::EnvironmentSettings;
use pyo3::exceptions::{PyOSError, PyRuntimeError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use std::io;
use std::path::{Path, PathBuf};
use std::sync::mpsc::{self, Receiver, RecvTimeoutError};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread::JoinHandle;

/// A batch under way: an iterator over the manifest lines, as assets are finished.
#[pyclass(frozen, module = "kiln")]
pub struct Batch {
    lines: Mutex<Receiver<String>>,
    control: Control,
    worker: Mutex<Option<JoinHandle<io::Result<()>>>>,
    total: usize,
}

/// Who listens to finished assets alone.
struct Silent;

impl Observer for Silent {
    fn started(&self, _: usize, _: &Job, _: &Control) {}

    fn stage(&self, _: usize, _: Stage) {}

    fn finished(&self, _: usize, _: &Outcome) {}
}

#[pymethods]
impl Batch {
    fn __len__(&self) -> usize {
        self.total
    }

    fn __iter__(slf: Py<Self>) -> Py<Self> {
        slf
    }

    /// The next manifest line; waits with the interpreter free.
    fn __next__(&self, py: Python<'_>) -> PyResult<Option<String>> {
        loop {
            let line = py.detach(|| self.lines.lock().unwrap_or_else(PoisonError::into_inner).recv_timeout(BREATH));
            match line {
                Ok(line) => return Ok(Some(line)),
                Err(RecvTimeoutError::Timeout) => {
                    if let Err(signal) = py.check_signals() {
                        self.stop(py)?;
                        return Err(signal);
                    }
                }
                Err(RecvTimeoutError::Disconnected) => {
                    self.join(py)?;
                    return Ok(None);
                }
            }
        }
    }

    /// Stops the batch: pictures not begun are skipped. Returns when the manifest is written.
    fn stop(&self, py: Python<'_>) -> PyResult<()> {
        self.control.stop();
        self.join(py)
    }
}

impl Batch {
    fn join(&self, py: Python<'_>) -> PyResult<()> {
        let worker = self.worker.lock().unwrap_or_else(PoisonError::into_inner).take();
        let Some(worker) = worker else { return Ok(()) };
        match py.detach(|| worker.join()) {
            Ok(done) => done.map_err(PyOSError::new_err),
            Err(_) => Err(PyRuntimeError::new_err("an internal error of Kiln")),
        }
    }
}

impl Drop for Batch {
    fn drop(&mut self) {
        self.control.stop();
    }
}

/// Begins a batch.
#[pyfunction]
#[expect(clippy::too_many_arguments, reason = "each is one of Python's")]
pub fn batch(
    folders: Vec<PathBuf>,
    out: PathBuf,
    include: Vec<String>,
    exclude: Vec<String>,
    jobs: Option<usize>,
    against: Option<PathBuf>,
    again: (bool, bool),
    options: &Bound<'_, PyDict>,
) -> PyResult<Batch> {
    let settings = options::settings(options)?;
    let discovery = Discovery { folders, include: globs(&include)?, exclude: globs(&exclude)?, output: out.clone() };
    let found = discover(&discovery);
    if let Some(place) = found.unreadable.first() {
        return Err(PyOSError::new_err(format!("{} cannot be searched: {}", place.path.display(), place.message)));
    }
    let environment = match &settings.environment {
        EnvironmentSettings::File(file) => {
            Some(Arc::new(LoadedEnvironment::read(&file.path).map_err(PyValueError::new_err)?))
        }
        _ => None,
    };
    let digest = settings_digest(&settings, environment.as_deref().map(LoadedEnvironment::digest));
    let digest = digest.map_err(|e| PyValueError::new_err(e.to_string()))?;
    let (force, retry_failed) = again;
    let policy = Policy { settings: digest, force, retry_failed, ..Policy::default() };
    let found = found.found;
    let lock = OutputLock::take(&out).map_err(PyOSError::new_err)?;
    let manifest = Manifest::open(&out, found.len(), policy).map_err(PyOSError::new_err)?;
    let (sender, lines) = mpsc::channel();
    let control = Control::default();
    let (total, stop) = (found.len(), control.clone());
    let work = move || {
        let job = |found: &Found| Job {
            input: found.path.clone(),
            name: found.name(),
            root: found.folder.as_deref().map(Path::to_path_buf),
            limits: Limits::default(),
            output: Output { folder: out.clone(), stem: found.relative.clone(), ending: None },
            settings: settings.clone(),
        };
        let sender = Mutex::new(sender);
        let tell = |_: usize, outcome: Outcome, _: bool| {
            if let Ok(line) = outcome.to_line() {
                // Nobody listens any more when the iterator is gone.
                let _ = sender.lock().unwrap_or_else(PoisonError::into_inner).send(line);
            }
        };
        let sink = FileSink { folder: out.clone() };
        let by_index = |index: usize| job(&found[index]);
        let all = Assets {
            count: found.len(),
            job: &by_index,
            workers: jobs.unwrap_or_else(rayon::current_num_threads).max(1),
            workshop: Workshop::InProcess { sink: &sink, environment },
            manifest: Some(&manifest),
            control: &stop,
            observer: &Silent,
        };
        schedule(&all, &tell);
        drop(all);
        manifest.finish(&|index| found[index].name(), &|index| Outcome::of(&job(&found[index])))?;
        drop(lock);
        Gallery { folder: &out, against: against.as_deref() }.write().map(|_| ())
    };
    let worker = std::thread::Builder::new().name("kiln-batch".into()).spawn(work).map_err(PyOSError::new_err)?;
    Ok(Batch { lines: Mutex::new(lines), control, worker: Mutex::new(Some(worker)), total })
}

fn globs(patterns: &[String]) -> PyResult<GlobSet> {
    let wrong = |e: globset::Error| PyValueError::new_err(e.to_string());
    let mut set = GlobSetBuilder::new();
    for pattern in patterns {
        set.add(Glob::new(pattern).map_err(wrong)?);
    }
    set.build().map_err(wrong)
}
