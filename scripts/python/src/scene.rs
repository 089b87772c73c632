use crate::error::asset_error;
use crate::wait::interruptible;
use kiln::Control;
use kiln::batch::{AssetFacts, Job, LoadedEnvironment, Output, Ready, lights_itself, make_ready};
use kiln::formats::{Format, ImportOptions, Limits, Show, import};
use kiln::settings::{EnvironmentSettings, Settings};
use pyo3::exceptions::PyRuntimeError;
use pyo3::prelude::*;
use std::path::PathBuf;
use std::sync::{Arc, Mutex, PoisonError};

/// An asset. What it takes to render it is kept from one render to the next.
#[pyclass(frozen, module = "kiln")]
pub struct Scene {
    path: PathBuf,
    root: Option<PathBuf>,
    show: Show,
    /// What is in it, as JSON.
    facts: String,
    /// Of the last render, with the settings that it depends on as JSON.
    ready: Mutex<Option<(String, Arc<Ready>)>>,
}

#[pymethods]
impl Scene {
    #[getter]
    fn path(&self) -> PathBuf {
        self.path.clone()
    }

    fn facts(&self) -> &str {
        &self.facts
    }
}

impl Scene {
    /// The scene made ready to be rendered with these settings. Ready scenes differ by all settings but those of how long and by
    /// which random numbers a view is rendered.
    ///
    /// # Errors
    /// [`crate::error::AssetError`].
    pub fn ready(&self, py: Python<'_>, settings: &Settings, control: &Control) -> PyResult<Arc<Ready>> {
        let mut settings = settings.clone();
        settings.look.show = self.show.clone();
        let mut key = settings.clone();
        (key.render.spp, key.render.seed, key.goal) = (0, 0, Default::default());
        let key = serde_json::to_string(&key).map_err(|e| PyRuntimeError::new_err(e.to_string()))?;
        if let Some((known, ready)) = &*self.ready.lock().unwrap_or_else(PoisonError::into_inner)
            && *known == key
        {
            return Ok(ready.clone());
        }
        let job = Job {
            input: self.path.clone(),
            name: self.path.display().to_string(),
            root: self.root.clone(),
            limits: Limits::default(),
            output: Output { folder: PathBuf::new(), stem: PathBuf::new(), ending: None },
            settings,
        };
        let environment = match &job.settings.environment {
            EnvironmentSettings::File(file) => {
                let loaded = LoadedEnvironment::read(&file.path).map_err(|e| asset_error(py, "environment", &e))?;
                Some(Arc::new(loaded))
            }
            _ => None,
        };
        let made = interruptible(py, control, || make_ready(&job, control, environment))?;
        let ready = Arc::new(made.map_err(|outcome| {
            let code = outcome.error_code.as_deref().unwrap_or("internal");
            asset_error(py, code, outcome.error_message.as_deref().unwrap_or("cannot be rendered"))
        })?);
        *self.ready.lock().unwrap_or_else(PoisonError::into_inner) = Some((key, ready.clone()));
        Ok(ready)
    }
}

/// Reads an asset.
#[pyfunction]
#[pyo3(signature = (path, root=None, variant=None, animation=None, time_code=None))]
pub fn load(
    py: Python<'_>,
    path: PathBuf,
    root: Option<PathBuf>,
    variant: Option<String>,
    animation: Option<String>,
    time_code: Option<f64>,
) -> PyResult<Scene> {
    let control = Control::default();
    let show = Show { animation, time: time_code, variant };
    let options = ImportOptions { root: root.clone(), show: show.clone(), ..ImportOptions::default() };
    let read = interruptible(py, &control, || {
        import(&path, &options, &control).map(|imported| {
            let format = Format::of(&path);
            let light = if lights_itself(&imported.scene, format) { "own" } else { "studio" };
            let mut facts = serde_json::to_value(AssetFacts::of(format, &imported)).unwrap_or_default();
            facts["input"] = path.display().to_string().into();
            facts["light"] = light.into();
            facts.to_string()
        })
    })?;
    let facts = read.map_err(|e| asset_error(py, e.code.as_str(), &e.to_string()))?;
    Ok(Scene { path, root, show, facts, ready: Mutex::new(None) })
}
