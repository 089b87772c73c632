use super::file::{Check, EnvironmentSpec};
use super::judge::{SIGNIFICANCE, Verdict, judge, tests};
use crate::integrate::{View, render};
use crate::math::statistics::sidak;
use crate::prepare::{EnvironmentSource, prepare};
use crate::settings::{Integrator, PrepareSettings, RenderSettings, Reuse, Strategy};
use kiln_formats::scene::{Camera, Image, Pixels};
use kiln_formats::{Control, ImportOptions, Stopped, import};
use rayon::prelude::*;

/// One comparison of a check.
#[derive(Clone, Debug, serde::Serialize)]
pub struct Row {
    /// The check's name.
    pub case: String,
    /// The strategy; none when the check could not be run at all.
    pub strategy: Option<Strategy>,
    /// The value expected, of the channel that did worst.
    pub expected: f64,
    /// The value got.
    pub got: f64,
    /// Its standard error.
    pub standard_error: f64,
    /// The judgement.
    pub verdict: Verdict,
    /// Why it could not be run, or fails as known; else empty.
    pub note: String,
    /// CPU seconds of the render.
    pub cpu_seconds: f64,
}

/// Runs checks by an integrator, with pixels that use each other's paths or not, on the current rayon pool; the rows come in the order of the checks. `control` counts checks.
///
/// # Errors
/// [`Stopped`] when `control` asks for it.
pub fn run(checks: &[Check], by: (Integrator, Reuse), control: &Control) -> Result<Vec<Row>, Stopped> {
    let count = |c: &Check| c.render.strategies.len() * c.expect.iter().map(tests).sum::<usize>();
    let level = sidak(SIGNIFICANCE, checks.iter().map(count).sum());
    control.begin(checks.len() as u64);
    let rows = checks.par_iter().with_max_len(1).map(|check| {
        control.check()?;
        let rows = match run_check(check, by, level) {
            Ok(rows) => rows,
            Err(note) => vec![Row {
                case: check.name.clone(),
                strategy: None,
                expected: 0.0,
                got: 0.0,
                standard_error: 0.0,
                verdict: Verdict::Error,
                note,
                cpu_seconds: 0.0,
            }],
        };
        control.advance(1);
        Ok(rows)
    });
    rows.collect::<Result<Vec<_>, _>>().map(|rows| rows.into_iter().flatten().collect())
}

fn run_check(check: &Check, (integrator, reuse): (Integrator, Reuse), level: f64) -> Result<Vec<Row>, String> {
    // Of its own: the caller's counts checks, not pixels.
    let control = Control::default();
    let imported = import(&check.scene, &ImportOptions::default(), &control)
        .map_err(|e| format!("{}: {e}", check.scene.display()))?;
    let spec = &check.render;
    let aspect = f64::from(spec.width) / f64::from(spec.height);
    let camera = match check.camera {
        Some(camera) => camera.camera(aspect)?,
        None => {
            let own = imported.scene.cameras.first().ok_or("neither the check nor its scene has a camera")?;
            Camera { right: own.right * (aspect * own.up.length() / own.right.length()), ..own.clone() }
        }
    };
    let stopped = |_| "stopped".to_string();
    let environment = source(&check.environment);
    let prepared = prepare(imported.scene, &environment, &PrepareSettings::default(), &control).map_err(stopped)?;
    let view = View { camera, width: spec.width, height: spec.height, show_environment: true };
    let mut rows = Vec::new();
    for strategy in &spec.strategies {
        let settings = RenderSettings {
            integrator,
            reuse,
            spp: spec.spp,
            seed: spec.seed,
            max_depth: spec.max_depth,
            strategy: *strategy,
            light_samples: spec.light_samples,
            sampler: spec.sampler,
            ..RenderSettings::default()
        };
        let rendered = render(&prepared, &view, &settings, &control).map_err(stopped)?;
        let known = check.known_failure.as_ref();
        let known = known.filter(|k| k.strategies.is_empty() || k.strategies.contains(strategy));
        for (k, expectation) in check.expect.iter().enumerate() {
            let judgement = judge(&rendered.film, expectation, level);
            let own = if rendered.nonfinite > 0 { Verdict::Fail } else { judgement.verdict };
            let dropped = format!("{} samples were not finite", rendered.nonfinite);
            rows.push(Row {
                case: check.name.clone(),
                strategy: Some(*strategy),
                expected: judgement.expected,
                got: judgement.got,
                standard_error: judgement.standard_error,
                verdict: if known.is_some() { own.known() } else { own },
                note: match known {
                    Some(known) => known.reason.clone(),
                    None if rendered.nonfinite > 0 => dropped,
                    None => String::new(),
                },
                cpu_seconds: if k == 0 { rendered.cpu_seconds } else { 0.0 },
            });
        }
    }
    Ok(rows)
}

fn source(environment: &EnvironmentSpec) -> EnvironmentSource {
    match (environment.constant, &environment.rows) {
        (Some(level), _) => EnvironmentSource::Constant(level.rgb().map(|x| x as f32)),
        (None, Some(rows)) => {
            let values = rows.iter().flatten().flat_map(|[r, g, b]| [*r, *g, *b, 1.0]).collect();
            let (width, height) = (rows.first().map_or(0, Vec::len) as u32, rows.len() as u32);
            let image = Image { name: String::new(), width, height, pixels: Pixels::RgbaF32(values) };
            EnvironmentSource::Image { image, rotation_y: 0.0, intensity: 1.0 }
        }
        (None, None) => EnvironmentSource::None,
    }
}
