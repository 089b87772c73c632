use super::schedule::{Batch, Workshop, schedule};
use super::{Job, LoadedEnvironment, Outcome, Sink, Stage};
use kiln_formats::Control;
use std::sync::{Arc, OnceLock};

/// Watches a batch. Called from several threads at once.
pub trait Observer: Sync {
    /// A worker takes up a job; `control` carries its progress.
    fn started(&self, worker: usize, job: &Job, control: &Control);
    /// A worker begins a stage of its job.
    fn stage(&self, worker: usize, stage: Stage);
    /// A worker is done with its job.
    fn finished(&self, worker: usize, outcome: &Outcome);
    /// An asset is up to date, and this is what the manifest says of it.
    fn kept(&self, _outcome: &Outcome) {}
}

/// Jobs and all that is needed to do them in this process.
pub struct Assignment<'a> {
    /// The jobs.
    pub jobs: &'a [Job],
    /// How many assets are worked on at a time, ≥ 1: what bounds the memory.
    pub workers: usize,
    /// Takes the finished pictures.
    pub sink: &'a dyn Sink,
    /// The environment file of all jobs where there is one and it has been read.
    pub environment: Option<Arc<LoadedEnvironment>>,
    /// Stops everything.
    pub control: &'a Control,
    /// Is told what happens.
    pub observer: &'a dyn Observer,
}

/// Does the jobs in this process and gives their outcomes in the jobs' order.
///
/// A job that fails stops no other; when `control` stops, jobs not begun are skipped.
pub fn run(assignment: &Assignment) -> Vec<Outcome> {
    let jobs = assignment.jobs;
    let outcomes: Vec<OnceLock<Outcome>> = jobs.iter().map(|_| OnceLock::new()).collect();
    let batch = Batch {
        count: jobs.len(),
        job: &|index| jobs[index].clone(),
        workers: assignment.workers,
        workshop: Workshop::InProcess { sink: assignment.sink, environment: assignment.environment.clone() },
        manifest: None,
        control: assignment.control,
        observer: assignment.observer,
    };
    // Each job ends once.
    schedule(&batch, &|index, outcome, _| drop(outcomes[index].set(outcome)));
    let skipped = |job: &Job| Outcome::skipped(&job.name, job.settings.render.seed);
    outcomes.into_iter().zip(jobs).map(|(slot, job)| slot.into_inner().unwrap_or_else(|| skipped(job))).collect()
}
