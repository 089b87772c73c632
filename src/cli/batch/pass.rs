use super::super::console::Console;
use super::super::exit::{Exit, Fatal};
use super::super::gallery;
use super::super::progress::Progress;
use super::super::summary;
use super::BatchCommand;
use kiln::Control;
use kiln::batch::{
    Batch, Discovered, FileSink, Job, LoadedEnvironment, MANIFEST, Manifest, Outcome, OutputLock, Policy, Status,
    Tally, Workshop, schedule,
};
use kiln::settings::Settings;
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Instant;

/// All assets looked at once, and done where they are not up to date.
pub(super) struct Pass<'a> {
    pub command: &'a BatchCommand,
    pub settings: &'a Settings,
    pub environment: Option<Arc<LoadedEnvironment>>,
    pub lock: &'a OutputLock,
    pub control: &'a Control,
    pub console: Console,
}

impl Pass<'_> {
    /// Does it, and tells people what became of it. `again`: silent when there is nothing to tell.
    ///
    /// # Errors
    /// When nothing can be begun.
    pub fn run(&self, discovered: &Discovered, policy: Policy, again: bool) -> Result<Exit, Fatal> {
        let begin = Instant::now();
        let (command, found) = (self.command, &discovered.found);
        let job = |index: usize| command.job(&found[index], self.settings);
        let manifest = Manifest::open(&command.out, found.len(), policy).map_err(|e| command.unwritable(&e))?;
        let cores = command.options.cores();
        let workers = command.isolation.jobs(cores, found.len());
        let presence = self.lock.presence().to_path_buf();
        let isolation = command.isolation.isolation(cores, workers, self.settings.goal.time, presence)?;
        let sink = FileSink { folder: command.out.clone() };
        let progress = Progress::new(self.console, command.options.json, found.len(), workers);
        let tally = Mutex::<Tally>::default();
        let batch = Batch {
            count: found.len(),
            job: &job,
            workers,
            workshop: if command.isolation.in_process {
                Workshop::InProcess { sink: &sink, environment: self.environment.clone() }
            } else {
                Workshop::Processes(&isolation)
            },
            manifest: Some(&manifest),
            control: self.control,
            observer: &progress,
        };
        schedule(&batch, &|_, outcome, kept| tally.lock().unwrap_or_else(PoisonError::into_inner).add(&outcome, kept));
        drop(batch);
        progress.end();
        let mut tally = tally.into_inner().unwrap_or_else(PoisonError::into_inner);
        tally.skip(found.len() - tally.all());
        let recorded = manifest.finish(&|index| found[index].name(), &|index| skipped(&job(index)));
        let path = command.out.join(MANIFEST).display().to_string();
        if !(self.console.quiet || again && tally.kept == found.len()) {
            eprintln!("{}", summary::text(&self.console, &tally, begin.elapsed().as_secs_f64(), &path));
        }
        if let Err(error) = &recorded {
            eprintln!("error: {path}: cannot be written: {error}");
        }
        if tally.disk_full || recorded.is_err() {
            let left = summary::plural(tally.count(Status::Skipped), "asset");
            eprintln!("error: nothing more can be written, {left} left undone; the same command goes on from here");
        }
        // The page of what was there already is there already.
        let stands = tally.kept == found.len() && command.against.is_none() && command.out.join("index.html").exists();
        let shown = stands || gallery::write(&command.out, command.against.as_deref(), &self.console);
        let whole = discovered.unreadable.is_empty() && recorded.is_ok() && shown;
        let interrupted = self.control.was_asked_to_stop() && !tally.disk_full && recorded.is_ok();
        // A part may have nothing to do.
        let nothing = found.is_empty() && whole && !interrupted;
        Ok(if nothing { Exit::Done } else { Exit::of(&tally, whole, interrupted) })
    }
}

/// Of a job that was never begun.
fn skipped(job: &Job) -> Outcome {
    let mut outcome = Outcome::of(job);
    outcome.error_code = Some("stopped".into());
    outcome.error_message = Some("interrupted before it began".into());
    outcome
}
