use crate::error::asset_error;
use crate::options;
use crate::scene::Scene;
use crate::wait::interruptible;
use kiln::accuracy::{Display, Ended, Progressive};
use kiln::film::{Picture, Surfaces};
use kiln::integrate::{SurfaceSamples, surfaces};
use kiln::settings::{Background, ToneMap};
use kiln::write::{display, srgb};
use kiln::{Control, Stopped};
use pyo3::exceptions::{PyIndexError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::{PyByteArray, PyDict};
use serde_json::json;
use std::time::{Duration, Instant};

/// Renders one view: a record as JSON, and the layers' names with their channels, type and bytes.
#[pyfunction]
pub fn render<'py>(
    py: Python<'py>,
    scene: &Scene,
    view: usize,
    wants_surfaces: bool,
    options: &Bound<'py, PyDict>,
) -> PyResult<(String, Bound<'py, PyDict>)> {
    let begin = Instant::now();
    let settings = options::settings(options)?;
    let control = Control::default();
    let by_deadline = match settings.goal.time {
        Some(seconds) => control.until(begin + Duration::from_secs_f64(seconds.min(1e9))),
        None => control.clone(),
    };
    let ready = scene.ready(py, &settings, &control)?;
    let count = ready.views.len();
    let view = ready.views.get(view).ok_or_else(|| PyIndexError::new_err(format!("there are {count} views")))?;
    let display = Display::new(&settings.pictures, ready.exposure);
    let look = |samples: SurfaceSamples| match wants_surfaces {
        true => surfaces(&ready.scene, view, &settings.render, samples, &by_deadline).map(|(surfaces, _)| surfaces),
        false => Ok(Surfaces::default()),
    };
    let rendered = interruptible(py, &control, || {
        // As in the program: a deadline leaves no time for it afterwards.
        let before = settings.goal.time.map(|_| look(SurfaceSamples::All(settings.render.spp))).transpose()?;
        let mut progressive = Progressive::new(&ready.scene, view, &settings.render, &settings.goal, display);
        let ended = progressive.run(&by_deadline)?;
        let finished = progressive.finish();
        let surfaces = before.map_or_else(|| look(SurfaceSamples::Of(&finished.film)), Ok)?;
        Ok((ended, finished, surfaces))
    })?;
    let late =
        |_: Stopped| asset_error(py, "deadline-before-first-pass", "the time was up before the first pass was done");
    let (ended, finished, surfaces) = rendered.map_err(late)?;
    let film = &finished.film;
    let stated = finished.accuracy;
    let outcome = &ready.outcome;
    let record = json!({
        "width": film.width,
        "height": film.height,
        "spp": film.spp,
        "seed": settings.render.seed,
        "exposure": ready.exposure,
        "error": stated.map(|a| a.error),
        "error_bound": stated.map(|a| a.error_bound),
        "relmse": stated.map(|a| a.relmse),
        "relmse_bound": stated.map(|a| a.relmse_bound),
        "target_met": settings.goal.error.map(|target| stated.is_some_and(|a| a.error_bound <= target)),
        "ended": match ended {
            Ended::Samples => "samples",
            Ended::Error => "error",
            Ended::Deadline => "deadline",
        },
        "light": outcome.light,
        "content": outcome.content,
        "warnings": outcome.warnings,
        "scene": outcome.scene,
        "seconds": begin.elapsed().as_secs_f64(),
    });
    let layers = PyDict::new(py);
    let noise = film.noise();
    let floats = |values: &[f32]| -> Vec<u8> { values.iter().flat_map(|v| v.to_le_bytes()).collect() };
    let beauty = floats(film.picture().pixels.as_flattened());
    layers.set_item("beauty", (4, "<f4", PyByteArray::new(py, &beauty)))?;
    if let Some(variance) = &noise.variance {
        layers.set_item("variance", (3, "<f4", PyByteArray::new(py, &floats(variance.as_flattened()))))?;
    }
    if wants_surfaces {
        let albedo = floats(surfaces.albedo.as_flattened());
        layers.set_item("albedo", (3, "<f4", PyByteArray::new(py, &albedo)))?;
        let normal = floats(surfaces.normal.as_flattened());
        layers.set_item("normal", (3, "<f4", PyByteArray::new(py, &normal)))?;
        layers.set_item("depth", (1, "<f4", PyByteArray::new(py, &floats(&surfaces.depth))))?;
    }
    let samples: Vec<u8> = noise.samples.iter().flat_map(|n| n.to_le_bytes()).collect();
    layers.set_item("samples", (1, "<u4", PyByteArray::new(py, &samples)))?;
    Ok((record.to_string(), layers))
}

/// Tone-maps linear premultiplied RGBA (little-endian 32-bit floats, row by row) to 8-bit sRGB with straight alpha.
#[pyfunction]
pub fn develop<'py>(
    py: Python<'py>,
    pixels: &[u8],
    exposure: f64,
    tonemap: &str,
    background: &str,
) -> PyResult<Bound<'py, PyByteArray>> {
    let operator: ToneMap =
        serde_json::from_value(tonemap.into()).map_err(|e| PyValueError::new_err(format!("tonemap: {e}")))?;
    let background = background.parse::<Background>().map_err(|e| PyValueError::new_err(format!("background: {e}")))?;
    let values: Vec<f32> = pixels.chunks_exact(4).map(|b| f32::from_le_bytes([b[0], b[1], b[2], b[3]])).collect();
    let pixels: Vec<[f32; 4]> = values.chunks_exact(4).map(|p| [p[0], p[1], p[2], p[3]]).collect();
    let developed = py.detach(|| {
        let picture = Picture { width: u32::try_from(pixels.len()).unwrap_or(u32::MAX), height: 1, pixels };
        let shown = display::develop(&picture, exposure, operator, background);
        shown.pixels.iter().flatten().map(|v| srgb::quantise(*v, 255.0) as u8).collect::<Vec<u8>>()
    });
    Ok(PyByteArray::new(py, &developed))
}
