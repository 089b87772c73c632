//! Single paths followed again, and the account of samples that were not finite.
#![allow(clippy::disallowed_methods, reason = "no pixel depends on this arithmetic")]

mod common;

use common::{add, cube, lambert, shoot, sphere, square, view};
use glam::{DAffine3, DVec3, Vec3};
use kiln::formats::scene::{ColorInput, MetalRough, ScalarInput, Surface, Volume};
use kiln::integrate::{Cause, PathEvent, View, replay};
use kiln::prepare::{EnvironmentSource, PreparedScene, prepare};
use kiln::settings::{Integrator, PrepareSettings, RenderSettings};
use kiln::{Control, Scene};

fn prepared(scene: &Scene) -> PreparedScene {
    let settings = PrepareSettings::default();
    prepare(scene.clone(), &EnvironmentSource::Constant([0.5; 3]), &settings, &Control::default()).expect("not stopped")
}

/// A lamp, a glass ball and a mirror over a floor.
fn still_life() -> (Scene, View) {
    let mut scene = Scene::default();
    add(&mut scene, square(), lambert(0.5, 0.0), DAffine3::from_scale(DVec3::splat(4.0)));
    let lamp = DAffine3::from_translation(DVec3::Z * 4.0) * DAffine3::from_scale(DVec3::new(0.5, 0.5, -1.0));
    add(&mut scene, square(), lambert(0.2, 20.0), lamp);
    let body = |metallic: f32, transmission: f32| {
        let mut material = lambert(0.9, 0.0);
        material.surface = Surface::MetalRough(MetalRough {
            base_color: ColorInput::constant([0.9; 3]),
            metallic: ScalarInput::constant(metallic),
            roughness: ScalarInput::constant(0.3 * metallic),
            transmission: ScalarInput::constant(transmission),
            volume: (transmission > 0.0)
                .then_some(Volume { attenuation_distance: 1.0, attenuation_color: [0.5, 0.7, 0.9] }),
            ..MetalRough::default()
        });
        material
    };
    add(&mut scene, sphere(3), body(0.0, 1.0), DAffine3::from_translation(DVec3::new(-1.2, 0.0, 1.0)));
    add(&mut scene, sphere(3), body(1.0, 0.0), DAffine3::from_translation(DVec3::new(1.2, 0.0, 1.0)));
    (scene, view(DVec3::new(0.0, -7.0, 3.0), DVec3::Z, 40.0, 16))
}

#[test]
fn a_replayed_path_is_that_of_the_picture() {
    let (scene, view) = still_life();
    let world = EnvironmentSource::Constant([0.5; 3]);
    let prepared = prepared(&scene);
    for integrator in [Integrator::Plain, Integrator::Path] {
        let settings = RenderSettings { spp: 1, seed: 7, integrator, ..RenderSettings::default() };
        let rendered = shoot(&scene, &world, &PrepareSettings::default(), &settings, &view);
        for y in 0..view.height {
            for x in 0..view.width {
                let trace = replay(&prepared, &view, &settings, [x, y], 0);
                let pixel = Vec3::from_slice(&rendered.picture.pixels[(y * view.width + x) as usize][..3]);
                match integrator {
                    Integrator::Plain => assert_eq!(trace.radiance, pixel, "pixel {x}, {y}"),
                    // Glass spheres magnify what rounding makes of a direction.
                    _ => assert!((trace.radiance - pixel).length() <= 1e-3 * pixel.length()),
                }
                assert_eq!(trace.cause, None);
            }
        }
    }
}

#[test]
fn contributions_of_a_replayed_path_add_up_to_its_radiance() {
    let (scene, view) = still_life();
    let prepared = prepared(&scene);
    let mut kinds = std::collections::BTreeSet::new();
    for sample in 0..1024 {
        let trace = replay(&prepared, &view, &RenderSettings::default(), [sample % 16, sample / 16 % 16], sample);
        let mut sum = Vec3::ZERO;
        for event in &trace.events {
            kinds.insert(serde_json::to_value(event).expect("JSON")["event"].to_string());
            match event {
                PathEvent::Emission { contribution, .. }
                | PathEvent::Environment { contribution, .. }
                | PathEvent::DirectLight { contribution, .. } => sum += *contribution,
                _ => {}
            }
        }
        assert!((sum - trace.radiance).length() <= 1e-5 * trace.radiance.length(), "{sum} {}", trace.radiance);
        assert!(matches!(trace.events.last(), Some(PathEvent::End { .. })));
    }
    assert!(kinds.len() == 11, "all that can happen happened: {kinds:?}");
}

/// In a closed box of such emission the light of two surfaces together is beyond f32.
#[test]
fn what_is_not_finite_is_dropped_counted_by_cause_and_can_be_replayed() {
    let mut scene = Scene::default();
    add(&mut scene, cube(true), lambert(0.9, 3e38), DAffine3::IDENTITY);
    let view = view(DVec3::new(0.3, -0.2, 0.5), DVec3::new(-1.0, 0.4, -0.8), 70.0, 16);
    let settings = RenderSettings { spp: 4, ..RenderSettings::default() };
    let rendered = shoot(&scene, &EnvironmentSource::None, &PrepareSettings::default(), &settings, &view);
    assert_eq!(rendered.nonfinite, 4 * 16 * 16);
    assert_eq!(rendered.dropped.count(), rendered.nonfinite);
    assert!(rendered.dropped.by_cause().all(|(cause, _)| matches!(cause, Cause::Overflow | Cause::LightSample)));
    assert!(rendered.picture.pixels.iter().flatten().all(|x| x.is_finite()));
    let prepared = prepared(&scene);
    assert_eq!(rendered.dropped.first().count(), 8);
    for place in rendered.dropped.first() {
        let trace = replay(&prepared, &view, &settings, place.pixel, place.sample);
        assert_eq!(trace.cause, Some(place.cause));
        assert!(!trace.radiance.is_finite());
    }
}
