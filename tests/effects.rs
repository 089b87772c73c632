//! What a scene does not call for is left out without a trace: pruned and full renderer give the same film, bit for bit, and the
//! same layers. `scripts/effects_equal.py` does the same with whole folders and files.

#![allow(clippy::disallowed_methods, reason = "no pixel depends on this arithmetic")]

mod common;

use common::everything::everything;
use glam::DVec3;
use kiln::batch::{Job, Output, make_ready};
use kiln::checks;
use kiln::formats::scene::{Alpha, AlphaMode, ScalarInput};
use kiln::formats::{ImportOptions, Limits, import};
use kiln::integrate::{SurfaceSamples, View, render, surfaces};
use kiln::prepare::{EnvironmentSource, PreparedScene, prepare};
use kiln::settings::{EffectSet, EffectSettings, PrepareSettings, RenderSettings, Settings};
use kiln::{Control, Scene};
use rayon::prelude::*;
use std::path::{Path, PathBuf};

fn prepare_settings(full: bool) -> PrepareSettings {
    let forced = if full { EffectSet::all() } else { EffectSet::default() };
    PrepareSettings { effects: EffectSettings { forced, ..EffectSettings::default() }, ..PrepareSettings::default() }
}

/// Whether two preparations of a scene give the same film and the same layers.
fn same([pruned, full]: [&PreparedScene; 2], view: &View) -> bool {
    let (settings, control) = (RenderSettings { spp: 4, ..RenderSettings::default() }, Control::default());
    let film = |scene| render(scene, view, &settings, &control).expect("not stopped").film;
    let layers = |scene| surfaces(scene, view, &settings, SurfaceSamples::All(4), &control).expect("not stopped").0;
    film(pruned) == film(full) && layers(pruned) == layers(full)
}

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

#[test]
fn samples_are_the_same_pruned_and_full() {
    let folder = root().join("scenes/samples");
    let files = std::fs::read_dir(folder).expect("samples").map(|entry| entry.expect("an entry").path());
    let scenes: Vec<PathBuf> = files.filter(|path| kiln::formats::Format::of(path).is_some()).collect();
    assert!(scenes.len() >= 10, "{}", scenes.len());
    scenes.par_iter().for_each(|input| {
        let ready = |full| {
            let mut settings = Settings { prepare: prepare_settings(full), ..Settings::default() };
            (settings.views.width, settings.views.height) = (32, 24);
            let output = Output { folder: PathBuf::new(), stem: PathBuf::new(), ending: None };
            let name = input.display().to_string();
            let job = Job { input: input.clone(), name, root: None, limits: Limits::default(), output, settings };
            make_ready(&job, &Control::default(), None).expect("a sound sample")
        };
        let (pruned, full) = (ready(false), ready(true));
        assert!(same([&pruned.scene, &full.scene], &pruned.views[0]), "{}", input.display());
    });
}

#[test]
fn checks_are_the_same_pruned_and_full() {
    let checks = checks::load(&root().join("scenes/checks")).expect("checks");
    // The largest scenes take long to prepare twice.
    let small = |path: &Path| std::fs::metadata(path).is_ok_and(|data| data.len() < 100_000);
    checks.par_iter().filter(|check| small(&check.scene)).for_each(|check| {
        let scene = import(&check.scene, &ImportOptions::default(), &Control::default()).expect("sound").scene;
        let own = scene.cameras.first().cloned();
        let Some(camera) = check.camera.map(|camera| camera.camera(1.0).expect("sound")).or(own) else { return };
        let world = EnvironmentSource::Constant([0.7, 0.8, 0.9]);
        let view = View { camera, width: 8, height: 8, show_environment: true };
        let [pruned, full] = both(&scene, &world);
        assert!(same([&pruned, &full], &view), "{}", check.name);
    });
}

#[test]
fn a_scene_with_everything_is_the_same_pruned_and_full() {
    let [pruned, full] = both(&everything(), &EnvironmentSource::Studio);
    let inside = common::view(DVec3::new(0.1, 0.1, 0.95), DVec3::new(0.0, -0.4, -0.6), 80.0, 50);
    assert!(same([&pruned, &full], &inside));
}

#[test]
fn a_scene_that_lets_every_ray_pass_is_the_same_pruned_and_full() {
    let mut open = everything();
    for material in &mut open.materials {
        material.alpha = Alpha { mode: AlphaMode::Blend, value: ScalarInput::constant(0.0) };
    }
    for world in [EnvironmentSource::Studio, EnvironmentSource::None] {
        let [pruned, full] = both(&open, &world);
        let inside = common::view(DVec3::new(0.1, 0.1, 0.95), DVec3::new(0.0, -0.4, -0.6), 80.0, 50);
        assert!(same([&pruned, &full], &inside));
        let unmet = pruned.unmet();
        assert!(unmet.open > 100, "{unmet:?}");
    }
}

fn both(scene: &Scene, world: &EnvironmentSource) -> [PreparedScene; 2] {
    [false, true]
        .map(|full| prepare(scene.clone(), world, &prepare_settings(full), &Control::default()).expect("not stopped"))
}
