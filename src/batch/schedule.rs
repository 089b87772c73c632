use super::failure::DISK_FULL;
use super::workers::{Death, Isolation, Worker};
use super::{Desk, Job, LoadedEnvironment, Manifest, Observer, Outcome, Sink, Verdict, run_asset_with};
use kiln_formats::Control;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Instant;

/// Where assets are worked on.
pub enum Workshop<'a> {
    /// On threads of this process, which share its global rayon pool: a crash ends everything.
    InProcess {
        /// Takes the finished pictures.
        sink: &'a dyn Sink,
        /// The environment file of all jobs where there is one and it has been read.
        environment: Option<Arc<LoadedEnvironment>>,
    },
    /// In processes of their own, which write into the jobs' output folder.
    Processes(&'a Isolation),
}

/// Assets to be worked on.
pub struct Batch<'a> {
    /// How many jobs there are.
    pub count: usize,
    /// Makes the job of an index; they are never all held at a time.
    pub job: &'a (dyn Fn(usize) -> Job + Sync),
    /// How many assets are worked on at a time, ≥ 1.
    pub workers: usize,
    /// Where.
    pub workshop: Workshop<'a>,
    /// What was done before, and the record of what is done.
    pub manifest: Option<&'a Manifest>,
    /// Stops everything.
    pub control: &'a Control,
    /// Is told what happens.
    pub observer: &'a dyn Observer,
}

/// Stack of a thread that works on assets: importers may recurse as deep as the limit on nesting allows.
const STACK_BYTES: usize = 16 << 20;

/// Does the jobs, in order as far as several at a time have one, and hands out each outcome with its index, and whether it was
/// up to date.
///
/// A job that fails stops no other, unless the disk is full or the manifest cannot be written: then nothing more can be kept. When
/// the control stops, jobs not begun have no outcome.
pub fn schedule(batch: &Batch, each: &(dyn Fn(usize, Outcome, bool) + Sync)) {
    let starved = Mutex::new(Vec::new());
    let all: Vec<usize> = Vec::new();
    let shift = Shift { batch, each, chosen: &all, next: AtomicUsize::new(0), starved: Some(&starved) };
    shift.work(batch.workers.min(batch.count));
    let mut starved = starved.into_inner().unwrap_or_else(PoisonError::into_inner);
    if let Workshop::Processes(isolation) = &batch.workshop
        && !starved.is_empty()
    {
        // One at a time, each may have all the memory.
        starved.sort_unstable();
        let isolation = Isolation { memory: isolation.alone, alone: None, ..(*isolation).clone() };
        let batch = Batch { workshop: Workshop::Processes(&isolation), ..*batch };
        Shift { batch: &batch, each, chosen: &starved, next: AtomicUsize::new(0), starved: None }.work(1);
    }
}

/// Jobs being done by several workers.
struct Shift<'a> {
    batch: &'a Batch<'a>,
    each: &'a (dyn Fn(usize, Outcome, bool) + Sync),
    /// Indices of the jobs; empty: all of them.
    chosen: &'a [usize],
    next: AtomicUsize,
    /// Takes the jobs that ran out of memory beside others.
    starved: Option<&'a Mutex<Vec<usize>>>,
}

impl Shift<'_> {
    fn work(&self, workers: usize) {
        std::thread::scope(|scope| {
            for worker in 1..workers {
                // With fewer threads than wished for, the work is done all the same.
                let builder = std::thread::Builder::new().name(format!("asset-{worker}")).stack_size(STACK_BYTES);
                let _ = builder.spawn_scoped(scope, move || self.attend(worker));
            }
            let builder = std::thread::Builder::new().name("asset-0".into()).stack_size(STACK_BYTES);
            if builder.spawn_scoped(scope, || self.attend(0)).is_err() {
                self.attend(0);
            }
        });
    }

    fn next(&self) -> Option<usize> {
        let turn = self.next.fetch_add(1, Ordering::Relaxed);
        if self.chosen.is_empty() {
            Some(turn).filter(|index| *index < self.batch.count)
        } else {
            self.chosen.get(turn).copied()
        }
    }

    /// Takes job after job.
    fn attend(&self, worker: usize) {
        let batch = self.batch;
        let mut process = None;
        while !batch.control.is_stopped()
            && let Some(index) = self.next()
        {
            let job = (batch.job)(index);
            if let Some(Verdict::Current(outcome)) = batch.manifest.map(|m| m.keep(index, &job, batch.control)) {
                batch.observer.kept(&outcome);
                (self.each)(index, *outcome, true);
                continue;
            }
            let control = batch.control.child();
            batch.observer.started(worker, &job, &control);
            let Some(mut outcome) = self.one(worker, index, &job, &control, &mut process) else { continue };
            if let Some(manifest) = batch.manifest
                && manifest.append(index, &job, &mut outcome).is_err()
            {
                batch.control.stop();
            }
            if outcome.error_code.as_deref() == Some(DISK_FULL) {
                batch.control.stop();
            }
            batch.observer.finished(worker, &outcome);
            (self.each)(index, outcome, false);
        }
    }

    /// Does one job; `None`: it is to be done later.
    fn one(
        &self,
        worker: usize,
        index: usize,
        job: &Job,
        control: &Control,
        process: &mut Option<Worker>,
    ) -> Option<Outcome> {
        let on_stage = |stage| self.batch.observer.stage(worker, stage);
        let isolation = match &self.batch.workshop {
            Workshop::InProcess { sink, environment } => {
                let desk = Desk { sink: *sink, on_stage: &on_stage, environment: environment.clone() };
                return Some(run_asset_with(job, control, &desk));
            }
            Workshop::Processes(isolation) => *isolation,
        };
        let begin = Instant::now();
        loop {
            if process.as_ref().is_none_or(|worker| !worker.is_well()) {
                // The old one is gone before the new one comes.
                drop(process.take());
                *process = Worker::start(isolation).ok();
            }
            let mut fresh = true;
            let done = match process {
                Some(worker) => {
                    fresh = worker.jobs == 0;
                    worker.run(job, isolation, control, &on_stage)
                }
                None => Err(Death::Unreachable("it could not be started".into())),
            };
            let death = match done {
                Ok(outcome) => return Some(outcome),
                Err(death) => death,
            };
            *process = None;
            let own_fault = fresh || matches!(death, Death::Timeout(_) | Death::Stalled(_) | Death::Stopped);
            if !own_fault && !control.was_asked_to_stop() {
                // Perhaps it died of what earlier assets left behind.
                continue;
            }
            if death == Death::OutOfMemory
                && isolation.alone.is_some()
                && let Some(starved) = self.starved
            {
                starved.lock().unwrap_or_else(PoisonError::into_inner).push(index);
                return None;
            }
            let settings = self.batch.manifest.map(|m| m.policy().settings.clone());
            return Some(death.outcome(job, begin.elapsed().as_secs_f64(), isolation, settings));
        }
    }
}
