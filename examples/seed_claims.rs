//! What `scripts/seed_claims.py` cannot learn from the program: what a random number costs with each generator, and how long
//! a picture would take with static and with dynamic scheduling. Prints one JSON object.
//!
//! Usage: seed_claims ASSET…

use cpu_time::ThreadTime;
use kiln::Control;
use kiln::batch::{Job, Output, make_ready};
use kiln::formats::Limits;
use kiln::integrate::{View, render};
use kiln::sampling::{PathSampler, Purpose};
use kiln::settings::{SamplerKind, Settings};
use serde_json::{Map, Value, json};
use std::hint::black_box;
use std::path::{Path, PathBuf};

/// Paths and vertices per path of the measurement of generators.
const PATHS: u32 = 400_000;
const VERTICES: u32 = 4;
/// Numbers per vertex: lobe, direction, choice of a light, point on it; and two for the point in the pixel.
const NUMBERS: u32 = 2 + 6 * VERTICES;
/// Bands that a picture is cut into, each of so many rows.
const BANDS: u32 = 32;
const ROWS: u32 = 6;
/// Threads that a schedule is computed for.
const THREADS: [usize; 4] = [2, 4, 8, 16];

fn main() {
    let assets: Vec<PathBuf> = std::env::args_os().skip(1).map(PathBuf::from).collect();
    let mut numbers = Map::new();
    for (name, kind) in [
        ("sobol", SamplerKind::Sobol),
        ("pcg", SamplerKind::Pcg),
        ("lcg", SamplerKind::Lcg),
        ("xorshift32", SamplerKind::Xorshift32),
    ] {
        // The least of some tries is the one that nothing else disturbed.
        let least = (0..5).map(|_| nanoseconds(kind)).fold(f64::INFINITY, f64::min);
        numbers.insert(name.into(), least.into());
    }
    let schedules: Vec<Value> = assets.iter().map(|a| schedule(a)).collect();
    println!("{}", json!({ "nanoseconds_per_number": numbers, "schedules": schedules }));
}

/// CPU time of a number, drawn as a path draws them.
fn nanoseconds(kind: SamplerKind) -> f64 {
    let clock = ThreadTime::now();
    let mut sum = 0.0;
    for path in 0..PATHS {
        let mut sampler = PathSampler::new(kind, 0, [path % 512, path / 512], path % 64);
        sum += sampler.get_2d(0, Purpose::Pixel)[0];
        for vertex in 0..VERTICES {
            sum += sampler.get_1d(vertex, Purpose::LightChoice);
            sum += sampler.get_2d(vertex, Purpose::LightPoint)[1];
            sum += sampler.get_1d(vertex, Purpose::Lobe);
            sum += sampler.get_2d(vertex, Purpose::Direction)[0];
        }
    }
    black_box(sum);
    clock.elapsed().as_secs_f64() * 1e9 / f64::from(PATHS * NUMBERS)
}

/// CPU seconds of each band of a picture, and the efficiency that schedules of them have.
fn schedule(asset: &Path) -> Value {
    let mut settings = Settings::default();
    settings.render.spp = 16;
    (settings.views.width, settings.views.height) = (BANDS * ROWS, BANDS * ROWS);
    let name = asset.file_name().unwrap_or_default().to_string_lossy().into_owned();
    let output = Output { folder: PathBuf::new(), stem: PathBuf::new(), ending: None };
    let job =
        Job { input: asset.to_path_buf(), name: name.clone(), root: None, limits: Limits::default(), output, settings };
    let control = Control::default();
    let ready = match make_ready(&job, &control, None) {
        Ok(ready) => ready,
        Err(outcome) => return json!({ "asset": name, "error": outcome.error_message }),
    };
    let seconds = |band: u32| {
        let view = band_of(&ready.views[0], band);
        render(&ready.scene, &view, &job.settings.render, &control).map_or(0.0, |r| r.cpu_seconds)
    };
    let bands: Vec<f64> = (0..BANDS).map(seconds).collect();
    let total: f64 = bands.iter().sum();
    let efficiencies: Vec<Value> = THREADS
        .iter()
        .map(|threads| {
            let share = total / *threads as f64;
            json!({ "threads": threads, "static": share / fixed(&bands, *threads), "dynamic": share / dynamic(&bands, *threads) })
        })
        .collect();
    json!({ "asset": name, "cpu_seconds": total, "efficiencies": efficiencies })
}

/// The part of a perspective view that lies in a band, from the top.
fn band_of(view: &View, band: u32) -> View {
    let mut camera = view.camera.clone();
    let n = f64::from(BANDS);
    camera.forward += camera.up * (1.0 - (2.0 * f64::from(band) + 1.0) / n);
    camera.up /= n;
    View { camera, height: ROWS, ..view.clone() }
}

/// Each thread takes as many neighbouring bands: the seconds of the slowest.
fn fixed(bands: &[f64], threads: usize) -> f64 {
    bands.chunks(bands.len().div_ceil(threads)).map(|own| own.iter().sum::<f64>()).fold(0.0, f64::max)
}

/// Each thread takes the next band when it is done with one.
fn dynamic(bands: &[f64], threads: usize) -> f64 {
    let mut busy = vec![0.0f64; threads];
    for band in bands {
        let next = (0..threads).min_by(|a, b| busy[*a].total_cmp(&busy[*b])).unwrap_or(0);
        busy[next] += band;
    }
    busy.iter().copied().fold(0.0, f64::max)
}
