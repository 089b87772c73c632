//! Light that comes as rare specks: the samples of most pictures do not know how much there is.

use crate::common::{add, lambert, sphere, square};
use glam::{DAffine3, DVec3};
use kiln::accuracy::{Accuracy, CONFIDENCE, Display, Ended, Progressive};
use kiln::formats::scene::{Light, LightKind, Material, MetalRough, ScalarInput, Surface};
use kiln::integrate::View;
use kiln::prepare::{EnvironmentSource, PreparedScene, prepare};
use kiln::settings::{Goal, PictureSettings, PrepareSettings, RenderSettings};
use kiln::{Control, Scene};

/// A metal ball on a white floor in the sun.
fn ball(roughness: f32) -> (PreparedScene, View) {
    let mut scene = Scene::default();
    let metal = MetalRough {
        base_color: kiln::formats::scene::ColorInput::constant([0.9; 3]),
        metallic: ScalarInput::constant(1.0),
        roughness: ScalarInput::constant(roughness),
        ..MetalRough::default()
    };
    let metal = Material { surface: Surface::MetalRough(metal), ..Material::default() };
    add(&mut scene, sphere(4), metal, DAffine3::IDENTITY);
    let floor = DAffine3::from_translation(-DVec3::Y) * DAffine3::from_rotation_x(-std::f64::consts::FRAC_PI_2);
    add(&mut scene, square(), lambert(0.8, 0.0), floor * DAffine3::from_scale(DVec3::splat(4.0)));
    scene.lights.push(Light {
        name: "Sun".into(),
        kind: LightKind::Directional,
        color: [2.0; 3],
        position: DVec3::ZERO,
        direction: DVec3::new(-0.5, -1.0, 0.3).normalize(),
        through_glass: false,
    });
    let prepared = prepare(scene, &EnvironmentSource::None, &PrepareSettings::default(), &Control::default());
    (prepared.expect("not stopped"), crate::common::view(DVec3::new(0.0, 2.0, 5.0), DVec3::ZERO, 40.0, 24))
}

/// A picture of at most 320 samples, whose error may be 200 levels: why it ended, after how many samples, and what it states and what it would by these
/// alone.
fn shoot((scene, view): &(PreparedScene, View), seed: u64) -> (Ended, u32, [Accuracy; 2]) {
    let display = Display::new(&PictureSettings::default(), 0.0);
    let settings = RenderSettings { seed, spp: 320, ..RenderSettings::default() };
    let goal = Goal { error: Some(200.0), time: None };
    let mut progressive = Progressive::new(scene, view, &settings, &goal, display);
    let ended = progressive.run(&Control::default()).expect("not stopped");
    let alone = Accuracy::of(progressive.film(), &display, CONFIDENCE).expect("two replicates");
    (ended, progressive.film().spp, [progressive.accuracy().expect("two replicates"), alone])
}

#[test]
fn bounds_are_further_away_and_end_no_picture_early() {
    let mirror = ball(0.1);
    assert!(mirror.0.rare_light.is_some());
    let (ended, spp, [stated, alone]) = shoot(&mirror, 1);
    assert_eq!((ended, spp), (Ended::Error, 256));
    assert!((stated.error - alone.error).abs() < 1e-9);
    // By the number of looks it is further away yet.
    assert!(stated.error_bound >= 2.0 * alone.error_bound, "{stated:?} {alone:?}");
    assert!(stated.relmse_bound >= 4.0 * alone.relmse_bound, "{stated:?} {alone:?}");

    let (ended, spp, [stated, alone]) = shoot(&ball(0.5), 1);
    assert_eq!((ended, spp), (Ended::Error, 16));
    assert!((stated.error_bound - alone.error_bound).abs() < 1e-9, "{stated:?} {alone:?}");
}
