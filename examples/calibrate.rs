//! Does the stated error hold? Renders assets with many seeds and compares the error that each picture states with the
//! one that it has.
//!
//! `calibrate ASSET… [--size N] [--seeds N] [--most SPP] [--converged SPP] [--reuse] [--csv FILE]`
//!
//! `--reuse`: pixels use each other's paths.
//!
//! The converged picture that a render is compared with is the mean of all other seeds' samples, so that it costs
//! nothing, or with `--converged` one with so many samples of a seed of its own, for assets that converge slowly; what noise
//! that has itself is taken off. Each seed is rendered once, and looked at where it first states an error
//! at or below 8, 4 and 2 (as `--error` would stop there) and at 16 and 64 samples per pixel.
#![allow(clippy::disallowed_methods, reason = "no pixel depends on this arithmetic")]

#[path = "calibrate/report.rs"]
mod report;
#[path = "calibrate/trial.rs"]
mod trial;

use kiln::Control;
use kiln::batch::{Job, Output, Ready, make_ready};
use kiln::formats::Limits;
use kiln::settings::{RenderSettings, Reuse, Settings, ViewSettings};
use std::path::{Path, PathBuf};

/// What is asked for on the command line.
struct Options {
    assets: Vec<PathBuf>,
    size: u32,
    seeds: u64,
    most: u32,
    converged: Option<u32>,
    csv: Option<PathBuf>,
    reuse: Reuse,
}

fn options() -> Result<Options, String> {
    let mut options =
        Options { assets: Vec::new(), size: 64, seeds: 50, most: 256, converged: None, csv: None, reuse: Reuse::Off };
    let mut words = std::env::args().skip(1);
    while let Some(word) = words.next() {
        let mut value = || words.next().ok_or(format!("{word} needs a value"));
        let number = |text: String| text.parse::<u32>().map_err(|e| format!("{text}: {e}"));
        match word.as_str() {
            "--size" => options.size = number(value()?)?,
            "--seeds" => options.seeds = number(value()?)?.into(),
            "--most" => options.most = number(value()?)?,
            "--converged" => options.converged = Some(number(value()?)?),
            "--reuse" => options.reuse = Reuse::On,
            "--csv" => options.csv = Some(value()?.into()),
            _ => options.assets.push(word.into()),
        }
    }
    if options.assets.is_empty() { Err("which assets?".into()) } else { Ok(options) }
}

/// An asset as `kiln render` shows it.
fn load(asset: &Path, size: u32) -> Result<Ready, String> {
    let views = ViewSettings { width: size, height: size, ..ViewSettings::default() };
    let job = Job {
        input: asset.into(),
        name: asset.display().to_string(),
        root: None,
        limits: Limits::default(),
        output: Output { folder: PathBuf::new(), stem: PathBuf::new(), ending: None },
        settings: Settings { views, ..Settings::default() },
    };
    make_ready(&job, &Control::default(), None).map_err(|outcome| outcome.error_message.unwrap_or_default())
}

fn main() -> Result<(), String> {
    let options = options()?;
    let way = RenderSettings { spp: options.most, reuse: options.reuse, ..RenderSettings::default() };
    let mut all = Vec::new();
    for asset in &options.assets {
        let name = asset.file_name().unwrap_or_default().to_string_lossy().into_owned();
        let ready = match load(asset, options.size) {
            Ok(loaded) => loaded,
            Err(error) => {
                println!("{name}: left out: {error}");
                continue;
            }
        };
        let clock = cpu_time::ProcessTime::now();
        let rows = trial::run(&name, &ready, &way, options.seeds, options.converged).map_err(|e| e.to_string())?;
        report::asset(&name, &rows, clock.elapsed().as_secs_f64());
        all.extend(rows);
        // As one goes: a run that is cut short leaves what it did.
        if let Some(path) = &options.csv {
            std::fs::write(path, report::csv(&all)).map_err(|e| e.to_string())?;
        }
    }
    report::total(&all);
    Ok(())
}
