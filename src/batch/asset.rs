use super::budget::Budget;
use super::environment::LoadedEnvironment;
use super::failure::Failure;
use super::sink::{FileSink, Sink};
use super::stages::{StageClock, peak_bytes};
use super::work::Work;
use super::{Job, Outcome, Stage, Status, looks, selfcheck};
use crate::accuracy::Ended;
use kiln_formats::Control;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Arc;

/// What surrounds a job.
pub struct Desk<'a> {
    /// Takes the finished files.
    pub sink: &'a dyn Sink,
    /// Told of each stage before it begins, on the thread that works.
    pub on_stage: &'a (dyn Fn(Stage) + Sync),
    /// The job's environment file where it has been read already.
    pub environment: Option<Arc<LoadedEnvironment>>,
}

/// Turns one asset into pictures in its output folder, on the current rayon pool.
///
/// Never panics and never prints: whatever goes wrong is in the outcome. `control` carries progress out (of the stage
/// under way) and the wish to stop in.
pub fn run_asset(job: &Job, control: &Control) -> Outcome {
    let sink = FileSink { folder: job.output.folder.clone() };
    run_asset_with(job, control, &Desk { sink: &sink, on_stage: &|_| (), environment: None })
}

/// As [`run_asset`], with the files going to a sink and the stages being told.
pub fn run_asset_with(job: &Job, control: &Control, desk: &Desk) -> Outcome {
    if job.settings.look.are_many() {
        return looks::run(job, control, desk);
    }
    let clock = StageClock::begin();
    let mut outcome = Outcome::of(job);
    let views = &job.settings.views;
    let budget = Budget::begin(&job.settings.goal, control, u64::from(views.width) * u64::from(views.height));
    let control = &budget.before_the_first_pass(control);
    let work = AssertUnwindSafe(|| Work { job, control, desk, budget, framed: false, outcome: &mut outcome }.run());
    let ended = catch_unwind(work).unwrap_or_else(|panic| Err(Failure::of_panic(&*panic)));
    selfcheck::conclude(&mut outcome, ended.as_ref().ok().copied());
    match ended {
        Ok(Ended::Deadline) => outcome.status = Status::Partial,
        Ok(_) if outcome.warnings.is_empty() => outcome.status = Status::Ok,
        Ok(_) => outcome.status = Status::Warned,
        Err(failure) => {
            let late = failure.stopped && !control.was_asked_to_stop();
            let failure = if late { Failure::late(&job.settings.goal, outcome.outputs.is_empty()) } else { failure };
            outcome.status = match (failure.stopped, outcome.outputs.is_empty()) {
                (true, true) if !late => Status::Skipped,
                (true, false) => Status::Partial,
                _ => Status::Failed,
            };
            outcome.error_code = Some(failure.code);
            outcome.error_message = Some(failure.message);
        }
    }
    outcome.seconds.total = clock.seconds().0;
    outcome.cpu_seconds.total = outcome.cpu_seconds.sum();
    outcome.peak_bytes = peak_bytes();
    outcome
}
