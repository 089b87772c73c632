use super::bench::{Bench, Ended};
use super::store::with_ending;
use super::{Cell, Reference, Store, Way};
use crate::batch::{Job, LoadedEnvironment, Outcome};
use kiln_formats::Control;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// What is to be studied.
pub struct Study<'a> {
    /// The assets. Of their settings the seed is the first of the references' and pictures' seeds; their outputs do not matter.
    pub jobs: &'a [Job],
    /// The ways; the first is what the others are compared with.
    pub ways: &'a [Way],
    /// Numbers of samples per pixel, growing.
    pub ladder: &'a [u32],
    /// Pictures of each way and number of samples.
    pub seeds: u32,
    /// Seconds for each asset on a machine that does nothing else, about.
    pub budget: f64,
    /// Samples per pixel of the references; `None`: as many as a third of the budget allows.
    pub reference_spp: Option<u32>,
    /// The environment file of all jobs where there is one.
    pub environment: Option<Arc<LoadedEnvironment>>,
}

/// How a study goes on.
#[derive(Clone, Copy, Debug)]
pub struct Progress<'a> {
    /// The asset.
    pub asset: &'a str,
    /// What is being done for it.
    pub doing: &'a str,
    /// The share of the whole study that is done, by its budget.
    pub share: f64,
}

/// Watches a study.
pub trait Observer {
    /// Something begins.
    fn begins(&self, progress: &Progress);
    /// A picture has been measured.
    fn measured(&self, cell: &Cell);
}

/// What was measured of an asset.
#[derive(Clone, Debug)]
pub struct Subject {
    /// The asset.
    pub name: String,
    /// What its files are called by.
    pub stem: String,
    /// What is known of it, with the seconds of its preparation.
    pub outcome: Outcome,
    /// Exposure of its pictures, EV.
    pub exposure: f64,
    /// The reference, unless the asset could not be rendered.
    pub reference: Option<Reference>,
    /// The cells: way by way, seed by seed, growing samples.
    pub cells: Vec<Cell>,
}

/// What was measured.
#[derive(Clone, Debug)]
pub struct Studied {
    /// The assets in the study's order; one that was not begun is not there.
    pub subjects: Vec<Subject>,
    /// Whether it was stopped before its end.
    pub interrupted: bool,
}

/// Runs a study on the current rayon pool. What the store holds of it already is not done again.
///
/// # Errors
/// When something cannot be written.
pub fn run(study: &Study, store: &mut Store, control: &Control, observer: &dyn Observer) -> Result<Studied, String> {
    let mut studied = Studied { subjects: Vec::new(), interrupted: false };
    for (index, job) in study.jobs.iter().enumerate() {
        let mut bench = Bench { study, job, index, control, observer, done: 0.0 };
        let mut subject = Subject {
            name: job.name.clone(),
            stem: stem(study.jobs, index),
            outcome: Outcome::skipped(&job.name, job.settings.render.seed),
            exposure: 0.0,
            reference: None,
            cells: Vec::new(),
        };
        let ended = bench.run(&mut subject, store);
        let begun = subject.reference.is_some() || subject.outcome.error_message.is_some();
        if begun {
            subject.cells.sort_by_key(|c| {
                let way = study.ways.iter().position(|w| w.name == c.way);
                (way, c.seed, c.spp)
            });
            studied.subjects.push(subject);
        }
        match ended {
            Ok(()) => (),
            Err(Ended::Stopped) => {
                studied.interrupted = true;
                break;
            }
            Err(Ended::Unwritable(message)) => return Err(message),
        }
    }
    Ok(studied)
}

/// The file name of an asset, with its number before it where another one is called the same.
fn stem(jobs: &[Job], index: usize) -> String {
    let name = |job: &Job| job.input.file_name().unwrap_or_default().to_string_lossy().into_owned();
    let own = name(&jobs[index]);
    let twice = jobs.iter().filter(|j| name(j) == own).count() > 1;
    if twice { format!("{}-{own}", index + 1) } else { own }
}

/// Where the picture of a way's first seed is kept.
pub(super) fn picture_path(folder: &Path, stem: &str, way: &str, spp: u32) -> PathBuf {
    with_ending(&folder.join("pictures").join(stem).join(format!("{way}-{spp}")), ".png")
}
