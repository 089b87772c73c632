mod pass;
mod watch;

use super::console::{Console, harmless, print_line};
use super::exit::{Exit, Fatal};
use super::folders::{Folders, job};
use super::interrupt::Interrupt;
use super::isolation::IsolationOptions;
use super::options::{SettingOptions, positive};
use super::summary;
use clap::Args;
use kiln::Control;
use kiln::batch::{
    Discovered, Found, Job, Ledger, LoadedEnvironment, MANIFEST, OutputLock, Policy, Shard, ShardChoice, Verdict,
    note_shard, settings_digest,
};
use kiln::settings::{EnvironmentSettings, PictureFormat, Settings};
use pass::Pass;
use std::path::PathBuf;
use std::sync::Arc;
use std::time::Duration;

const EXAMPLES: &str = "\
Examples:
  kiln batch assets --out pictures
  kiln batch chairs tables --out pictures --spp 256 --format png
  kiln batch assets --out turns --turntable 24 --background '#ffffff'
  kiln batch assets --out pictures --include '*.glb' --exclude 'old/*' --jobs 4
  kiln batch assets --out pictures --against earlier/pictures
  kiln batch assets --out pictures --dry-run       what is not up to date, and why
  kiln batch assets --out pictures --watch         render what changes until Ctrl-C
  kiln batch assets --out shard-1 --shard 1/4      a quarter of the assets: see kiln merge
  kiln batch assets --out pictures --memory 4G --timeout 600 --jobs 8
  kiln batch assets --out pictures --json | jq 'select(.status == \"failed\")'

A picture is called like its asset: chairs/oak.glb gives pictures/chairs/oak.glb.png and .exr. With several folders,
each folder's name comes first. manifest.jsonl holds one line per asset; index.html shows them all. What is up to date is not done again: interrupted or
killed, the same command goes on. Ctrl-C ends the pictures under way with the samples so far; a second one ends at once.";

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
    /// Only a part of the assets, by their names: K/N with K from 1, or auto or auto/N where an engine says which (docs/farms.md)
    #[arg(long, value_name = "K/N|auto", overrides_with = "shard")]
    shard: Option<ShardChoice>,
    /// Output folder of an earlier run: the gallery compares with it
    #[arg(long, value_name = "DIR")]
    against: Option<PathBuf>,
    /// Do everything again, up to date or not
    #[arg(long)]
    force: bool,
    /// Do again what failed, or was cut short by the time
    #[arg(long)]
    retry_failed: bool,
    /// Tell what would be done and why, and do nothing
    #[arg(long)]
    dry_run: bool,
    /// Go on: render what changes, looking every so many seconds [2 unless given]
    #[arg(long, value_name = "SECONDS", num_args = 0..=1, default_missing_value = "2", value_parser = positive, conflicts_with = "dry_run")]
    watch: Option<f64>,
    #[command(flatten)]
    isolation: IsolationOptions,
    #[command(flatten)]
    options: SettingOptions,
}

impl BatchCommand {
    /// Does it.
    ///
    /// # Errors
    /// When nothing can be begun.
    pub fn run(self) -> Result<Exit, Fatal> {
        let settings = self.options.settings(self.format.clone())?;
        let shard = self.shard()?;
        let mut discovered = self.folders.search(&self.out)?;
        restrict(&mut discovered, shard);
        let environment = environment(&settings)?;
        let digest = settings_digest(&settings, environment.as_deref().map(LoadedEnvironment::digest))
            .map_err(|e| Fatal::usage(format!("the settings: {e}")))?;
        let policy = Policy {
            settings: digest,
            force: self.force,
            retry_failed: self.retry_failed,
            memory: self.isolation.memory,
            timeout: self.isolation.timeout,
        };
        if self.dry_run {
            return self.foretell(&discovered, &settings, &policy);
        }
        let lock = OutputLock::take(&self.out).map_err(|e| self.unwritable(&e))?;
        if let Some(warning) = &lock.warning {
            eprintln!("warning: {}: {warning}", self.out.display());
        }
        note_shard(&self.out, shard).map_err(|e| self.unwritable(&e))?;
        if self.isolation.in_process {
            self.options.start_threads()?;
        }
        let control = Control::default();
        Interrupt::watch(&control);
        let console = Console::new(self.options.quiet, self.options.verbose);
        let pass = Pass { command: &self, settings: &settings, environment, lock: &lock, control: &control, console };
        let mut exit = pass.run(&discovered, policy.clone(), false)?;
        let Some(seconds) = self.watch else { return Ok(exit) };
        let policy = Policy { force: false, retry_failed: false, ..policy };
        let manifest = self.out.join(MANIFEST);
        let mut before = watch::look(&discovered, &manifest);
        let interval = Duration::from_secs_f64(seconds);
        loop {
            let find = || {
                let mut discovered = self.folders.look(&self.out);
                restrict(&mut discovered, shard);
                discovered
            };
            let look = || watch::look(&find(), &manifest);
            if !watch::wait(interval, &control, &before, look) {
                return Ok(exit);
            }
            let discovered = find();
            before = watch::look(&discovered, &manifest);
            exit = pass.run(&discovered, policy.clone(), true)?;
            // What an asset refers to is known when it has been read.
            for (path, seen) in watch::look(&discovered, &manifest) {
                before.entry(path).or_insert(seen);
            }
        }
    }

    /// The part that is asked for.
    fn shard(&self) -> Result<Option<Shard>, Fatal> {
        let environment = |of| Shard::of_environment(of, |name| std::env::var(name).ok());
        match self.shard {
            Some(ShardChoice::Fixed(shard)) => Ok(Some(shard)),
            Some(ShardChoice::Auto(of)) => match environment(of).map_err(Fatal::usage)? {
                Some((engine, shard)) => {
                    if !self.options.quiet {
                        eprintln!("shard {shard}, as {engine} says");
                    }
                    Ok(Some(shard))
                }
                None => Err(Fatal::usage(
                    "--shard auto: neither a Slurm array, nor an AWS Batch array, nor an indexed Job of Kubernetes runs this",
                )),
            },
            None => {
                if let Ok(Some((engine, shard))) = environment(None)
                    && shard.of > 1
                {
                    eprintln!(
                        "note: {engine} runs this as {shard}, and all assets are rendered: --shard auto takes a part"
                    );
                }
                Ok(None)
            }
        }
    }

    /// Tells what would be done.
    fn foretell(&self, discovered: &Discovered, settings: &Settings, policy: &Policy) -> Result<Exit, Fatal> {
        let path = self.out.join(MANIFEST);
        let ledger =
            Ledger::read(&path).map_err(|e| Fatal::failed(format!("{}: cannot be read: {e}", path.display())))?;
        let mut due = 0;
        for found in &discovered.found {
            match ledger.verdict(&self.job(found, settings), policy, &Control::default()) {
                Verdict::Due(reason) => {
                    due += 1;
                    print_line(&format!("render      {} ({})", harmless(&found.name()), reason.words()));
                }
                Verdict::Current(outcome) => {
                    print_line(&format!("up to date  {} ({})", harmless(&found.name()), outcome.status.word()))
                }
            }
        }
        eprintln!("{} to render, {} up to date", summary::plural(due, "asset"), discovered.found.len() - due);
        Ok(Exit::Done)
    }

    fn job(&self, found: &Found, settings: &Settings) -> Job {
        job(found, self.options.root.as_deref(), &self.out, self.isolation.limits(), settings)
    }

    fn unwritable(&self, error: &std::io::Error) -> Fatal {
        Fatal::failed(format!("{}: cannot be written to: {error}", self.out.display()))
    }
}

/// Leaves the assets of a part.
fn restrict(discovered: &mut Discovered, shard: Option<Shard>) {
    if let Some(shard) = shard {
        discovered.found.retain(|found| shard.has(&found.name()));
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
