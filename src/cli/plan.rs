use super::batch::environment;
use super::console::print_line;
use super::exit::{Exit, Fatal};
use super::folders::{Folders, job};
use super::interrupt::Interrupt;
use super::options::SettingOptions;
use super::summary::plural;
use clap::{Args, value_parser};
use kiln::Control;
use kiln::batch::Job;
use kiln::formats::Limits;
use kiln::plan::{Forecast, Foretold, Interval, Waiting, probe};
use kiln::settings::PictureFormat;
use serde_json::json;
use std::path::PathBuf;
use std::time::Instant;

const EXAMPLES: &str = "\
Examples:
  kiln plan assets                                what kiln batch assets would take
  kiln plan assets --error 2 --width 512
  kiln plan assets --spp 256 --json | jq .seconds

Takes the flags of kiln batch. Each asset is imported, prepared, and rendered small with few samples; nothing is written.
The interval is meant to hold the real figure nine times of ten, if the machine stays as busy as it is now.";

/// How many assets are named of those that dominate.
const NAMED: usize = 10;
/// Assets are named until they make up this share of the time.
const DOMINATING: f64 = 0.8;

/// `kiln plan`.
#[derive(Args)]
#[command(after_help = EXAMPLES)]
pub struct PlanCommand {
    #[command(flatten)]
    folders: Folders,
    /// Files for each picture
    #[arg(long, value_enum, value_delimiter = ',', default_value = "png,exr")]
    format: Vec<PictureFormat>,
    /// Assets worked on at a time [default: the number of threads]
    #[arg(long, value_name = "N", value_parser = value_parser!(u16).range(1..=4096))]
    jobs: Option<u16>,
    #[command(flatten)]
    options: SettingOptions,
}

impl PlanCommand {
    /// Does it.
    ///
    /// # Errors
    /// When nothing can be begun.
    pub fn run(self) -> Result<Exit, Fatal> {
        let begin = Instant::now();
        let settings = self.options.settings(self.format.clone())?;
        let nowhere = PathBuf::new();
        let discovered = self.folders.search(&nowhere)?;
        let environment = environment(&settings)?;
        let threads = self.options.start_threads()?;
        let root = self.options.root.as_deref();
        let jobs: Vec<Job> =
            discovered.found.iter().map(|f| job(f, root, &nowhere, Limits::default(), &settings)).collect();
        let control = Control::default();
        let interrupt = Interrupt::watch(&control);
        let base = kiln::batch::workers::held_bytes().unwrap_or(0);
        let mut foretold: Vec<Foretold> = Vec::new();
        let waited = Waiting::now();
        for job in &jobs {
            let one = probe(job, &control, environment.clone());
            if interrupt.happened() {
                return Ok(Exit::Interrupted);
            }
            if self.options.verbose {
                eprintln!("{}: {:.2} s of CPU", one.name, one.cpu_seconds.total);
            }
            foretold.push(one);
        }
        let waited = waited.and_then(|before| Waiting::now()?.per_second_since(&before));
        let workers = self.jobs.map_or(threads, usize::from);
        let forecast = Forecast::of(&foretold, workers, threads, base, waited);
        let failing = forecast.assets.iter().filter(|a| a.error_message.is_some()).count();
        if self.options.json {
            let mut value = json!(forecast);
            value["workers"] = workers.into();
            value["threads"] = threads.into();
            value["probe_seconds"] = begin.elapsed().as_secs_f64().into();
            print_line(&value.to_string());
        } else {
            print_line(&text(&forecast, begin.elapsed().as_secs_f64()));
        }
        Ok(match failing {
            0 if discovered.unreadable.is_empty() => Exit::Done,
            n if n == jobs.len() => Exit::Failed,
            _ => Exit::Partial,
        })
    }
}

fn text(forecast: &Forecast, probed: f64) -> String {
    let Interval { expected, low, high } = forecast.seconds;
    let mut lines = vec![format!(
        "{} will take {} ({} to {}), {} of CPU",
        plural(forecast.assets.len(), "asset"),
        time(expected),
        time(low),
        time(high),
        time(forecast.cpu_seconds.expected)
    )];
    if forecast.slowdown > 1.3 {
        lines.push(format!(
            "other work on this machine makes that {:.1} times as long as it would be alone",
            forecast.slowdown
        ));
    }
    if let Some(bytes) = &forecast.peak_bytes {
        let giga = |b: f64| format!("{:.2}", b / 1e9);
        let range = format!("{} to {}", giga(bytes.low), giga(bytes.high));
        lines.push(format!("memory at most about {} GB ({range})", giga(bytes.expected)));
    }
    let mut sum = 0.0;
    for asset in forecast.assets.iter().take(NAMED) {
        if sum >= DOMINATING {
            break;
        }
        sum += asset.share;
        let megabytes = asset.bytes.map_or(String::new(), |b| format!(", {:.0} MB", b as f64 / 1e6));
        lines.push(format!(
            "  {:4.1} %  {:>8} of CPU, {} samples per pixel{megabytes}  {}",
            100.0 * asset.share,
            time(asset.cpu_seconds.total),
            asset.spp,
            asset.input
        ));
    }
    for asset in forecast.assets.iter().filter(|a| a.error_message.is_some()) {
        lines.push(format!("will fail: {}: {}", asset.input, asset.error_message.as_deref().unwrap_or_default()));
    }
    lines.push(format!("(probed in {})", time(probed)));
    lines.join("\n")
}

fn time(seconds: f64) -> String {
    match seconds {
        s if s >= 2.0 * 3600.0 => format!("{:.1} h", s / 3600.0),
        s if s >= 120.0 => format!("{:.1} min", s / 60.0),
        s => format!("{s:.1} s"),
    }
}
