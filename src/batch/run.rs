use super::{Desk, Job, LoadedEnvironment, Manifest, Outcome, Sink, Stage, run_asset_with};
use kiln_formats::Control;
use std::io;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Arc, Mutex, OnceLock, PoisonError};

/// Watches a batch. Called from several threads at once.
pub trait Observer: Sync {
    /// A worker takes up a job; `control` carries its progress.
    fn started(&self, worker: usize, job: &Job, control: &Control);
    /// A worker begins a stage of its job.
    fn stage(&self, worker: usize, stage: Stage);
    /// A worker is done with its job.
    fn finished(&self, worker: usize, outcome: &Outcome);
}

/// Jobs and all that is needed to do them.
pub struct Assignment<'a> {
    /// The jobs, in the order of the manifest.
    pub jobs: &'a [Job],
    /// How many assets are worked on at a time, ≥ 1: what bounds the memory.
    pub workers: usize,
    /// Takes the finished pictures.
    pub sink: &'a dyn Sink,
    /// The environment file of all jobs where there is one and it has been read.
    pub environment: Option<Arc<LoadedEnvironment>>,
    /// The record.
    pub manifest: Option<&'a Manifest>,
    /// Stops everything.
    pub control: &'a Control,
    /// Is told what happens.
    pub observer: &'a dyn Observer,
}

/// Stack of a worker: importers may recurse as deep as the limit on nesting allows.
const STACK_BYTES: usize = 16 << 20;

/// Does the jobs and gives their outcomes in the jobs' order.
///
/// Each worker is a thread that takes the next job when it is done with one. It imports and writes by itself;
/// preparing and rendering share the global rayon pool, so that the cores are full when one asset is left, too. A job
/// that fails stops no other; when `control` stops, jobs not begun are skipped.
///
/// # Errors
/// When the manifest cannot be written. The jobs are done all the same.
pub fn run(assignment: &Assignment) -> (Vec<Outcome>, io::Result<()>) {
    let jobs = assignment.jobs;
    let outcomes: Vec<OnceLock<Outcome>> = jobs.iter().map(|_| OnceLock::new()).collect();
    let next = AtomicUsize::new(0);
    let manifest_error = Mutex::new(None);
    let work = |worker: usize| {
        loop {
            let index = next.fetch_add(1, Ordering::Relaxed);
            let (Some(job), Some(slot)) = (jobs.get(index), outcomes.get(index)) else { return };
            let outcome = one(assignment, worker, job);
            if let Some(manifest) = assignment.manifest
                && let Err(error) = manifest.append(&outcome)
            {
                manifest_error.lock().unwrap_or_else(PoisonError::into_inner).get_or_insert(error);
            }
            assignment.observer.finished(worker, &outcome);
            // Each index is taken once.
            let _ = slot.set(outcome);
        }
    };
    std::thread::scope(|scope| {
        let work = &work;
        for worker in 1..assignment.workers.min(jobs.len()) {
            // With fewer threads than wished for, the work is done all the same.
            let builder = std::thread::Builder::new().name(format!("asset-{worker}")).stack_size(STACK_BYTES);
            let _ = builder.spawn_scoped(scope, move || work(worker));
        }
        let builder = std::thread::Builder::new().name("asset-0".into()).stack_size(STACK_BYTES);
        if builder.spawn_scoped(scope, move || work(0)).is_err() {
            work(0);
        }
    });
    let skipped = |job: &Job| Outcome::skipped(&job.name, job.settings.render.seed);
    let outcomes: Vec<Outcome> =
        outcomes.into_iter().zip(jobs).map(|(slot, job)| slot.into_inner().unwrap_or_else(|| skipped(job))).collect();
    let appended = manifest_error.into_inner().unwrap_or_else(PoisonError::into_inner).map_or(Ok(()), Err);
    let finished = assignment.manifest.map_or(Ok(()), |m| m.finish(&outcomes));
    (outcomes, finished.and(appended))
}

fn one(assignment: &Assignment, worker: usize, job: &Job) -> Outcome {
    let control = assignment.control.child();
    if control.is_stopped() {
        let mut outcome = Outcome::skipped(&job.name, job.settings.render.seed);
        outcome.error_code = Some("stopped".into());
        outcome.error_message = Some("interrupted before it began".into());
        return outcome;
    }
    assignment.observer.started(worker, job, &control);
    let on_stage = |stage| assignment.observer.stage(worker, stage);
    let desk = Desk { sink: assignment.sink, on_stage: &on_stage, environment: assignment.environment.clone() };
    run_asset_with(job, &control, &desk)
}
