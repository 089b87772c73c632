use super::console::Console;
use super::exit::{Exit, Fatal};
use super::folders::{Folders, job};
use super::gallery;
use super::interrupt::Interrupt;
use super::options::SettingOptions;
use super::progress::Progress;
use super::summary;
use clap::{Args, value_parser};
use kiln::Control;
use kiln::batch::{Assignment, FileSink, Job, LoadedEnvironment, Manifest, run};
use kiln::settings::{EnvironmentSettings, PictureFormat, Settings};
use std::path::PathBuf;
use std::sync::Arc;
use std::time::Instant;

const EXAMPLES: &str = "\
Examples:
  kiln batch assets --out pictures
  kiln batch chairs tables --out pictures --spp 256 --format png
  kiln batch assets --out turns --turntable 24 --background '#ffffff'
  kiln batch assets --out pictures --include '*.glb' --exclude 'old/*' --jobs 4
  kiln batch assets --out pictures --against earlier/pictures
  kiln batch assets --out pictures --json | jq 'select(.status == \"failed\")'

A picture is called like its asset: chairs/oak.glb gives pictures/chairs/oak.glb.png and .exr. With several folders,
each folder's name comes first. manifest.jsonl holds one line per asset; index.html shows them all.";

/// `kiln batch`.
#[derive(Args)]
#[command(after_help = EXAMPLES)]
pub struct BatchCommand {
    #[command(flatten)]
    folders: Folders,
    /// Folder for pictures and manifest
    #[arg(short, long, value_name = "DIR")]
    out: PathBuf,
    /// Files for each picture
    #[arg(long, value_enum, value_delimiter = ',', default_value = "png,exr")]
    format: Vec<PictureFormat>,
    /// Assets worked on at a time: bounds the memory [default: the number of threads]
    #[arg(long, value_name = "N", value_parser = value_parser!(u16).range(1..=4096))]
    jobs: Option<u16>,
    /// Output folder of an earlier run: the gallery compares with it
    #[arg(long, value_name = "DIR")]
    against: Option<PathBuf>,
    #[command(flatten)]
    options: SettingOptions,
}

impl BatchCommand {
    /// Does it.
    ///
    /// # Errors
    /// When nothing can be begun.
    pub fn run(self) -> Result<Exit, Fatal> {
        let begin = Instant::now();
        let settings = self.options.settings(self.format.clone())?;
        let console = Console::new(self.options.quiet, self.options.verbose);
        let discovered = self.folders.search(&self.out)?;
        let environment = environment(&settings)?;
        let threads = self.options.start_threads()?;
        let workers = self.jobs.map_or(threads, usize::from);
        let jobs: Vec<Job> =
            discovered.found.iter().map(|f| job(f, self.options.root.as_deref(), &self.out, &settings)).collect();
        let unwritable =
            |e: std::io::Error| Fatal::failed(format!("{}: cannot be written to: {e}", self.out.display()));
        let manifest = Manifest::begin(&self.out).map_err(unwritable)?;
        let control = Control::default();
        let interrupt = Interrupt::watch(&control);
        let progress = Progress::new(console, self.options.json, jobs.len(), workers);
        let (outcomes, recorded) = run(&Assignment {
            jobs: &jobs,
            workers,
            sink: &FileSink { folder: self.out.clone() },
            environment,
            manifest: Some(&manifest),
            control: &control,
            observer: &progress,
        });
        progress.end();
        let manifest = self.out.join("manifest.jsonl").display().to_string();
        if !console.quiet {
            eprintln!("{}", summary::text(&console, &outcomes, begin.elapsed().as_secs_f64(), &manifest));
        }
        if let Err(error) = &recorded {
            eprintln!("error: {manifest}: cannot be written: {error}");
        }
        let shown = gallery::write(&self.out, self.against.as_deref(), &console);
        let whole = discovered.unreadable.is_empty() && recorded.is_ok() && shown;
        Ok(Exit::of(&outcomes, whole, interrupt.happened()))
    }
}

/// The environment file of the settings, read once for all assets.
///
/// # Errors
/// When there is one and it cannot be read.
pub fn environment(settings: &Settings) -> Result<Option<Arc<LoadedEnvironment>>, Fatal> {
    match &settings.environment {
        EnvironmentSettings::File(file) => {
            LoadedEnvironment::read(&file.path).map(|e| Some(Arc::new(e))).map_err(Fatal::failed)
        }
        _ => Ok(None),
    }
}
