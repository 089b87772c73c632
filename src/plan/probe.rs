use crate::batch::workers::{forget_peak, held_bytes};
use crate::batch::{Desk, Job, LoadedEnvironment, MemorySink, Outcome, StageSeconds, planned_rays, run_asset_with};
use crate::settings::Settings;
use kiln_formats::Control;
use std::sync::Arc;

/// Longest side of the probes' pictures, pixels.
const SIDE: u32 = 96;
/// Samples per pixel of probes where nothing decides about them but the settings: a tile's paths fill a wave.
const SPP: u32 = 8;
/// CPU time of a path in a whole picture over that in a probe. Measured: scripts/runs/2026-11-22-plan.md.
const SHARE_OF_PROBE: f64 = 0.9;
/// Most views of a turntable that are probed.
const VIEWS: u32 = 3;
/// Bytes per pixel of a picture under way: the film's sums twice (a pass works on a copy), the picture and its files.
const PIXEL_BYTES: u64 = 400;

/// What is foretold of an asset.
#[derive(Clone, Debug)]
pub struct Foretold {
    /// What the batch calls it.
    pub name: String,
    /// CPU seconds by stage of the whole job.
    pub cpu_seconds: StageSeconds,
    /// Samples per pixel that it will take.
    pub spp: u32,
    /// Bytes that it needs while it is worked on; `None` where the system does not tell.
    pub bytes: Option<u64>,
    /// Why it will fail, if so.
    pub error_message: Option<String>,
    /// What the probe itself took.
    pub probe: Outcome,
}

/// Does a job small: all of its import and preparation, and small pictures with few samples, the more of them the lower the
/// error that is asked for. Nothing is written. Probes are made one at a time: what they hold is what the process holds.
pub fn probe(job: &Job, control: &Control, environment: Option<Arc<LoadedEnvironment>>) -> Foretold {
    let small = Job { settings: small(&job.settings), ..job.clone() };
    let before = held_bytes();
    forget_peak();
    let sink = MemorySink::default();
    let outcome = run_asset_with(&small, control, &Desk { sink: &sink, on_stage: &|_| (), environment });
    drop(sink);
    foretell(job, &small, outcome, before)
}

fn small(settings: &Settings) -> Settings {
    let mut small = settings.clone();
    // What is prepared by the number of rays is prepared as in the batch.
    let pixels = u64::from(settings.views.width) * u64::from(settings.views.height);
    let all = pixels * u64::from(settings.views.turntable.unwrap_or(1));
    small.prepare.planned_rays = Some(planned_rays(all, settings.render.spp));
    let views = &mut small.views;
    let scale = f64::from(SIDE) / f64::from(views.width.max(views.height));
    if scale < 1.0 {
        let shrunk = |side: u32| ((f64::from(side) * scale).round() as u32).max(1);
        (views.width, views.height) = (shrunk(views.width), shrunk(views.height));
    }
    views.turntable = views.turntable.map(|n| n.min(VIEWS));
    small.goal.time = None;
    if small.goal.error.is_none() {
        small.render.spp = small.render.spp.min(SPP);
    }
    small
}

fn foretell(job: &Job, small: &Job, outcome: Outcome, before: Option<u64>) -> Foretold {
    let pixels = |s: &Settings| u64::from(s.views.width) * u64::from(s.views.height);
    let views = |s: &Settings| u64::from(s.views.turntable.unwrap_or(1));
    let (full, part) = (&job.settings, &small.settings);
    // An error asked for is reached with about as many samples in a small picture as in a large one.
    let taken = outcome.outputs.iter().map(|o| o.spp).max().unwrap_or(0);
    let spp = if full.goal.error.is_some() { taken } else { full.render.spp };
    let own = pixels(part) * views(part) * u64::from(taken);
    let wanted = pixels(full) * views(full) * u64::from(spp);
    // Looks at the scene beforehand (metering) take the same few paths in both.
    let before_pictures = outcome.rays.camera.saturating_sub(own);
    let share = (wanted + before_pictures) as f64 / (own + before_pictures).max(1) as f64;
    let mut cpu_seconds = outcome.cpu_seconds;
    // What is done once a pass and what fills its lanes badly weighs more in a probe.
    cpu_seconds.render *= if share > 1.0 { (share * SHARE_OF_PROBE).max(1.0) } else { share };
    cpu_seconds.write *= (pixels(full) * views(full)) as f64 / (pixels(part) * views(part)) as f64;
    if let Some(time) = full.goal.time {
        // With a deadline (wall seconds) there is no more rendering than fits in, on all threads.
        let fixed = cpu_seconds.import + cpu_seconds.prepare + cpu_seconds.kdtree;
        let room = (time - fixed).max(0.0) * rayon::current_num_threads() as f64;
        cpu_seconds.render = cpu_seconds.render.min(room);
    }
    cpu_seconds.total = cpu_seconds.sum();
    let held = outcome.peak_bytes.zip(before).map(|(peak, before)| peak.saturating_sub(before));
    let more = PIXEL_BYTES * pixels(full).saturating_sub(pixels(part));
    let failed = !outcome.status.is_done();
    Foretold {
        name: job.name.clone(),
        cpu_seconds,
        spp,
        bytes: held.map(|bytes| bytes + more),
        error_message: outcome.error_message.clone().filter(|_| failed),
        probe: outcome,
    }
}
