use super::asset::Desk;
use super::budget::Budget;
use super::failure::Failure;
use super::work::Work;
use super::{FileSink, Job, LoadedEnvironment, Outcome, Status};
use crate::integrate::View;
use crate::prepare::PreparedScene;
use crate::settings::Goal;
use kiln_formats::Control;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Arc;

/// An asset that only has to be rendered.
#[derive(Debug)]
pub struct Ready {
    /// The scene.
    pub scene: PreparedScene,
    /// Its views.
    pub views: Vec<View>,
    /// The exposure of all views, EV.
    pub exposure: f64,
    /// What it took so far, and what is known of the asset.
    pub outcome: Outcome,
}

/// Does all of a job that comes before its pictures, exactly as [`super::run_asset`] does it.
///
/// # Errors
/// The outcome, when it went wrong or `control` stopped it.
pub fn make_ready(
    job: &Job,
    control: &Control,
    environment: Option<Arc<LoadedEnvironment>>,
) -> Result<Ready, Box<Outcome>> {
    let sink = FileSink { folder: job.output.folder.clone() };
    let desk = Desk { sink: &sink, on_stage: &|_| (), environment };
    let mut outcome = Outcome::skipped(&job.name, job.settings.render.seed);
    // Who asks for this decides about time.
    let budget = Budget::begin(&Goal::default(), control, 0);
    let work = AssertUnwindSafe(|| {
        Work { job, control, desk: &desk, budget, framed: false, outcome: &mut outcome }.make_ready()
    });
    match catch_unwind(work).unwrap_or_else(|panic| Err(Failure::of_panic(&*panic))) {
        Ok((scene, views, exposure)) => Ok(Ready { scene, views, exposure, outcome }),
        Err(failure) => {
            outcome.status = if failure.stopped { Status::Skipped } else { Status::Failed };
            outcome.error_code = Some(failure.code);
            outcome.error_message = Some(failure.message);
            Err(Box::new(outcome))
        }
    }
}
