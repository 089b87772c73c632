use kiln::batch::ViewFile;
use kiln::settings::{CameraChoice, Goal, Layer, PictureFormat, RenderSettings, Settings, ViewSettings};
use pyo3::exceptions::{PyTypeError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use serde::de::DeserializeOwned;
use serde_json::Value;
use std::path::PathBuf;
use std::str::FromStr;

/// The settings that keyword arguments ask for, as the command line's flags of the same names would.
pub fn settings(options: &Bound<'_, PyDict>) -> PyResult<Settings> {
    let mut settings = Settings::default();
    settings.pictures.formats = vec![PictureFormat::Png, PictureFormat::Exr];
    let (mut spp, mut width, mut height, mut depth) = (None, None, None, None);
    let mut goal = Goal::default();
    let mut view = None;
    for (key, value) in options {
        let key: String = key.extract()?;
        match key.as_str() {
            "width" => width = Some(size(&key, &value)?),
            "height" => height = Some(size(&key, &value)?),
            "spp" => spp = Some(within(&key, value.extract::<i64>()?, 1, 1 << 24)?),
            "error" => goal.error = Some(positive(&key, &value)?),
            "time" => goal.time = Some(positive(&key, &value)?),
            "seed" => settings.render.seed = value.extract()?,
            "max_depth" => depth = Some(within(&key, value.extract::<i64>()?, 0, i64::from(u32::MAX))?),
            "light_samples" => {
                settings.render.light_samples = Some(within(&key, value.extract::<i64>()?, 1, 4096)?);
            }
            "strategy" => settings.render.strategy = word(&key, &value)?,
            "sampler" => settings.render.sampler = word(&key, &value)?,
            "reuse" => settings.render.reuse = word(&key, &value)?,
            "clamp" => settings.render.clamp = Some(positive(&key, &value)? as f32),
            "camera" => {
                // Every text is a camera's name.
                let Ok(camera) = CameraChoice::from_str(&value.extract::<String>()?);
                settings.views.camera = camera;
            }
            "view" => view = Some(ViewFile::read(&value.extract::<PathBuf>()?).map_err(PyValueError::new_err)?),
            "turntable" => {
                settings.views.turntable = Some(within(&key, value.extract::<i64>()?, 1, 100_000)?);
            }
            "up" => settings.views.up = word(&key, &value)?,
            "env" => settings.environment = parsed(&key, &text(&value)?)?,
            "exposure" => settings.pictures.exposure = parsed(&key, &text(&value)?)?,
            "background" => settings.pictures.background = parsed(&key, &text(&value)?)?,
            "tonemap" => settings.pictures.tonemap = word(&key, &value)?,
            "bits" => settings.pictures.bits = word(&key, &value.str()?.into_any())?,
            "formats" => {
                let names: Vec<Bound<'_, PyAny>> = value.extract()?;
                let formats: PyResult<Vec<PictureFormat>> = names.iter().map(|name| word(&key, name)).collect();
                settings.pictures.formats = formats?;
            }
            "layers" => {
                let names: Vec<Bound<'_, PyAny>> = value.extract()?;
                let layers: PyResult<Vec<Layer>> = names.iter().map(|name| word(&key, name)).collect();
                settings.pictures.layers = layers?;
            }
            "variant" => settings.look.show.variant = Some(value.extract()?),
            "animation" => settings.look.show.animation = Some(value.extract()?),
            "time_code" => settings.look.show.time = Some(value.extract()?),
            _ => return Err(PyTypeError::new_err(format!("unexpected keyword argument '{key}'"))),
        }
    }
    if let Some(file) = view {
        (width, height) = (width.or(file.size.0), height.or(file.size.1));
        depth = depth.or(file.max_depth);
        settings.views.fixed = Some(file.view);
        if !options.contains("env")? {
            settings.environment = file.environment;
        }
        if !options.contains("background")? {
            settings.pictures.background = file.background;
        }
    }
    settings.goal = goal;
    settings.render.spp = spp.or(goal.most_spp()).unwrap_or(RenderSettings::default().spp);
    settings.render.max_depth = depth.unwrap_or(settings.render.max_depth);
    settings.views.width = width.unwrap_or(ViewSettings::default().width);
    settings.views.height = height.unwrap_or(settings.views.width);
    Ok(settings)
}

fn size(key: &str, value: &Bound<'_, PyAny>) -> PyResult<u32> {
    within(key, value.extract()?, 1, 32_768)
}

fn within(key: &str, value: i64, least: i64, most: i64) -> PyResult<u32> {
    let wrong = || PyValueError::new_err(format!("{key} must be from {least} to {most}, not {value}"));
    u32::try_from(value).ok().filter(|_| (least..=most).contains(&value)).ok_or_else(wrong)
}

fn positive(key: &str, value: &Bound<'_, PyAny>) -> PyResult<f64> {
    let number: f64 = value.extract()?;
    let wrong = || PyValueError::new_err(format!("{key} must be a number greater than 0, not {number}"));
    Some(number).filter(|n| n.is_finite() && *n > 0.0).ok_or_else(wrong)
}

/// A text, a path, or a number as text.
fn text(value: &Bound<'_, PyAny>) -> PyResult<String> {
    Ok(value.str()?.to_string())
}

fn parsed<T: FromStr<Err = String>>(key: &str, text: &str) -> PyResult<T> {
    text.parse().map_err(|e| PyValueError::new_err(format!("{key}: {e}")))
}

/// One of the words that the manifest has for a setting.
fn word<T: DeserializeOwned>(key: &str, value: &Bound<'_, PyAny>) -> PyResult<T> {
    let word: String = value.extract()?;
    serde_json::from_value(Value::String(word)).map_err(|e| PyValueError::new_err(format!("{key}: {e}")))
}
