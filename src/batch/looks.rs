//! Assets that are pictured in many looks: in every variant, or with each frame of a turntable at its moment.
//!
//! Each look is a job of its own, and their outcomes become one.

use super::budget::Budget;
use super::environment::LoadedEnvironment;
use super::failure::TOO_LATE;
use super::read::{import, note};
use super::stages::StageClock;
use super::{Desk, Job, Outcome, Status, digest, run_asset_with, views};
use crate::integrate::View;
use crate::settings::{EnvironmentSettings, Exposure, FixedView, LookSettings, Settings, ViewSettings};
use glam::{DAffine3, DVec3};
use kiln_formats::scene::{Instance, Material, Mesh};
use kiln_formats::{Contents, Control, ErrorCode, ImportError, Scene, Touched, Warning};
use std::sync::Arc;

/// Points of all frames of an animation that the framing looks at; frames with more are taken by their boxes.
const POINT_BUDGET: usize = 8_000_000;

/// As [`run_asset_with`], for a job whose looks are many.
pub(super) fn run(job: &Job, control: &Control, desk: &Desk) -> Outcome {
    let clock = StageClock::begin();
    let mut outcome = Outcome::of(job);
    let mut touched = Touched::default();
    let budget = Budget::begin(&job.settings.goal, control, 0);
    match plan(job, &budget.share(control, 1), &mut touched) {
        Ok(jobs) => {
            // An environment file is read once.
            let environment = desk.environment.clone().or_else(|| match &job.settings.environment {
                EnvironmentSettings::File(file) => LoadedEnvironment::read(&file.path).ok().map(Arc::new),
                _ => None,
            });
            let hash = digest::of_settings(&job.settings, environment.as_deref().map(LoadedEnvironment::digest));
            let desk = Desk { environment, ..*desk };
            let count = jobs.len();
            for (index, mut look) in jobs.into_iter().enumerate() {
                // Each look has an equal share of the time that is left.
                let control = budget.share(control, count - index);
                // One exposure for all looks: the first one's.
                if let Some(first) = outcome.outputs.first() {
                    look.settings.pictures.exposure = Exposure::Ev(first.exposure);
                }
                let one = run_asset_with(&look, &control, &desk);
                let goes_on = one.status.is_done() || one.status == Status::Partial;
                join(&mut outcome, one, index as u32);
                if !goes_on {
                    break;
                }
            }
            outcome.settings = hash.ok();
        }
        Err(error) => {
            note(&mut outcome, job, &touched);
            let stopped = error.code == ErrorCode::Stopped;
            let late = stopped && !control.was_asked_to_stop();
            outcome.status = if stopped && !late { Status::Skipped } else { Status::Failed };
            outcome.error_code = Some(if late { TOO_LATE } else { error.code.as_str() }.into());
            outcome.error_message = Some(error.to_string());
        }
    }
    outcome.seconds.total = clock.seconds().0;
    outcome.cpu_seconds.total = outcome.cpu_seconds.sum();
    outcome
}

/// The looks of an asset as jobs of one look each.
fn plan(job: &Job, control: &Control, touched: &mut Touched) -> Result<Vec<Job>, ImportError> {
    let settings = &job.settings;
    let contents = read(job, settings.look.show.time, control, touched)?.1;
    let plain = LookSettings { show: settings.look.show.clone(), ray: settings.look.ray, ..LookSettings::default() };
    let single = |settings: Settings, suffix: Option<&str>| {
        let mut job = Job { settings, ..job.clone() };
        if let Some(suffix) = suffix {
            let mut name = job.output.stem.file_name().unwrap_or_default().to_os_string();
            name.push(format!(".{suffix}"));
            job.output.stem = job.output.stem.with_file_name(name);
        }
        job
    };
    let still = Settings { look: plain.clone(), ..settings.clone() };
    if settings.look.every_variant && !contents.variants.is_empty() {
        let names = file_names(&contents.variants);
        let variant = |(index, name): (usize, &String)| {
            let mut settings = Settings { look: settings.look.clone(), ..settings.clone() };
            settings.look.every_variant = false;
            // By index, for names need not be different.
            settings.look.show.variant = Some(index.to_string());
            single(settings, Some(name))
        };
        return Ok(names.iter().enumerate().map(variant).collect());
    }
    let seconds = seconds(&contents, settings.look.show.animation.as_deref());
    let (Some(frames), true, Some(seconds)) = (settings.views.turntable, settings.look.play, seconds) else {
        return Ok(vec![single(still, None)]);
    };
    let begin = settings.look.show.time.unwrap_or(0.0);
    let moment = |k: u32| begin + seconds * f64::from(k) / f64::from(frames);
    let mut hull = Hull::new(POINT_BUDGET / frames.max(1) as usize);
    for k in 0..frames {
        hull.add(&read(job, Some(moment(k)), control, touched)?.0);
    }
    let cameras = views::plan(&hull.scene, &settings.views, false)
        .map_err(|message| ImportError::new(ErrorCode::Invalid, message))?;
    let frame = |(k, view): (usize, View)| {
        let mut settings = still.clone();
        settings.look.show.time = Some(moment(k as u32));
        settings.views = ViewSettings { turntable: None, fixed: Some(fixed(&view)), ..settings.views };
        single(settings, Some(&format!("{k:03}")))
    };
    Ok(cameras.into_iter().enumerate().map(frame).collect())
}

fn read(
    job: &Job,
    time: Option<f64>,
    control: &Control,
    touched: &mut Touched,
) -> Result<(Scene, Contents), ImportError> {
    let mut show = job.settings.look.show.clone();
    show.time = time.or(job.settings.look.play.then_some(0.0));
    let imported = import(job, show, control, touched)?;
    Ok((imported.scene, imported.contents))
}

/// How long the animation lasts that a choice means (the importer has seen to it that there is one).
fn seconds(contents: &Contents, choice: Option<&str>) -> Option<f64> {
    let clips = &contents.animations;
    let named = |choice: &str| {
        let by_name = clips.iter().find(|c| c.name == choice);
        by_name.or_else(|| choice.parse().ok().and_then(|i: usize| clips.get(i)))
    };
    match choice.map(|choice| named(choice).ok_or(())) {
        None => clips.first()?.seconds,
        Some(Ok(clip)) => clip.seconds,
        Some(Err(())) => clips.iter().filter_map(|c| c.seconds).reduce(f64::max),
    }
}

/// Variants' names as parts of file names, each different.
fn file_names(variants: &[String]) -> Vec<String> {
    let mut names: Vec<String> = Vec::new();
    for (index, variant) in variants.iter().enumerate() {
        let plain = |c: char| if c.is_alphanumeric() || "-_ ".contains(c) { c } else { '_' };
        let mut name: String = variant.chars().take(64).map(plain).collect::<String>().trim().to_owned();
        if name.is_empty() || names.contains(&name) {
            name = format!("{name}{}{index}", if name.is_empty() { "variant " } else { " " });
        }
        names.push(name);
    }
    names
}

/// A camera of a turntable in numbers.
fn fixed(view: &View) -> FixedView {
    let camera = &view.camera;
    let (right, up, back) = (camera.right.normalize(), camera.up.normalize(), -camera.forward.normalize());
    let o = camera.origin;
    FixedView {
        camera_to_world: [
            [right.x, up.x, back.x, o.x],
            [right.y, up.y, back.y, o.y],
            [right.z, up.z, back.z, o.z],
            [0.0, 0.0, 0.0, 1.0],
        ],
        vfov_deg: (2.0 * libm::atan(camera.up.length() / camera.forward.length())).to_degrees(),
    }
}

/// A scene whose drawn points are those of many scenes.
struct Hull {
    scene: Scene,
    points_per_scene: usize,
}

impl Hull {
    fn new(points_per_scene: usize) -> Self {
        let scene = Scene { materials: vec![Material::default()], ..Scene::default() };
        Self { scene, points_per_scene }
    }

    fn add(&mut self, scene: &Scene) {
        self.scene.up = scene.up;
        let Some((low, high)) = views::bounds(scene) else { return };
        let middle = 0.5 * (low + high);
        let mut positions: Vec<[f32; 3]> = Vec::new();
        views::for_each_point(scene, |p| {
            if positions.len() <= self.points_per_scene {
                positions.push((p - middle).as_vec3().to_array());
            }
        });
        if positions.len() > self.points_per_scene {
            let corner = |k: usize| {
                let pick = |axis: usize| if k >> axis & 1 == 0 { low[axis] } else { high[axis] };
                (DVec3::new(pick(0), pick(1), pick(2)) - middle).as_vec3().to_array()
            };
            positions = (0..8).map(corner).collect();
        }
        // Points count when a triangle uses them.
        let triangles = (0..positions.len() as u32).map(|i| [i; 3]).collect();
        let mesh = self.scene.meshes.len() as u32;
        self.scene.meshes.push(Mesh { positions, triangles, ..Mesh::default() });
        let transform = DAffine3::from_translation(middle);
        self.scene.instances.push(Instance { name: String::new(), mesh, transform });
    }
}

/// Adds the outcome of one look, the `index`th, to that of the asset.
fn join(all: &mut Outcome, one: Outcome, index: u32) {
    if index == 0 {
        (all.content, all.light, all.scene) = (one.content, one.light, one.scene);
        (all.files, all.missing) = (one.files, one.missing);
    }
    let frames = all.outputs.iter().map(|o| o.view + 1).max().unwrap_or(0);
    all.outputs.extend(one.outputs.into_iter().map(|o| super::OutputRecord { view: frames + o.view, ..o }));
    let known = |w: &Warning, list: &[Warning]| list.iter().any(|k| k.code == w.code && k.place == w.place);
    for warning in one.warnings {
        if !known(&warning, &all.warnings) {
            all.warnings.push(warning);
        }
    }
    let partial = all.status == Status::Partial;
    all.status = match (one.status, all.outputs.is_empty(), all.warnings.is_empty()) {
        (Status::Ok, _, false) if !partial => Status::Warned,
        // Interrupted, or out of time, after some looks were done.
        (Status::Skipped, false, _) => Status::Partial,
        (Status::Failed, false, _) if one.error_code.as_deref() == Some(TOO_LATE) => Status::Partial,
        (Status::Ok | Status::Warned, ..) if partial => Status::Partial,
        (status, ..) => status,
    };
    (all.error_code, all.error_message) = (one.error_code, one.error_message);
    for (sum, seconds) in [(&mut all.seconds, one.seconds), (&mut all.cpu_seconds, one.cpu_seconds)] {
        sum.import += seconds.import;
        sum.prepare += seconds.prepare;
        sum.kdtree += seconds.kdtree;
        sum.render += seconds.render;
        sum.write += seconds.write;
    }
    all.rays += one.rays;
    all.nonfinite += one.nonfinite;
    all.peak_bytes = one.peak_bytes.or(all.peak_bytes);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_of_variants_become_names_of_files() {
        let variants = ["Beach", "a/b: c", "Beach", "", "../.."].map(str::to_owned);
        assert_eq!(file_names(&variants), ["Beach", "a_b_ c", "Beach 2", "variant 3", "_____"]);
    }
}
