use crate::common::{add, cube, lambert, sphere, square, view};
use glam::{DAffine3, DVec3};
use kiln::film::Film;
use kiln::integrate::{PassTally, View, render, render_pass};
use kiln::prepare::{EnvironmentSource, PreparedScene, prepare};
use kiln::settings::{PrepareSettings, RenderSettings, SamplerKind};
use kiln::{Control, Scene};

/// A ball in a box with a lamp under its ceiling.
pub fn room() -> (PreparedScene, View) {
    let mut scene = Scene::default();
    add(&mut scene, cube(true), lambert(0.7, 0.0), DAffine3::IDENTITY);
    add(&mut scene, sphere(3), lambert(0.5, 0.0), DAffine3::from_scale(DVec3::splat(0.4)));
    let down = DAffine3::from_translation(DVec3::Y * 0.99) * DAffine3::from_rotation_x(std::f64::consts::FRAC_PI_2);
    add(&mut scene, square(), lambert(0.0, 4.0), down * DAffine3::from_scale(DVec3::splat(0.3)));
    let prepared = prepare(scene, &EnvironmentSource::None, &PrepareSettings::default(), &Control::default());
    (prepared.expect("not stopped"), view(DVec3::Z * 0.9, DVec3::ZERO, 80.0, 37))
}

#[test]
fn a_render_is_the_same_however_it_is_cut_into_passes() {
    let (scene, view) = room();
    for sampler in [SamplerKind::Sobol, SamplerKind::Xorshift32] {
        let settings = RenderSettings { spp: 13, sampler, clamp: Some(1.5), ..RenderSettings::default() };
        let control = Control::default();
        let whole = render(&scene, &view, &settings, &control).expect("not stopped");
        let mut film = Film::new(view.width, view.height, view.show_environment);
        let mut tally = PassTally::default();
        for samples in [0..1, 1..6, 6..6, 6..13] {
            tally += render_pass(&scene, &view, &settings, &mut film, samples, &control).expect("not stopped");
        }
        assert_eq!(film, whole.film);
        assert_eq!((tally.rays, tally.nonfinite), (whole.rays, 0));
        assert!(tally.clamped > 0.0 && film.picture().pixels.iter().flatten().all(|c| *c <= 1.5));
    }
}

#[test]
fn a_pass_that_is_stopped_leaves_the_film_as_it_was() {
    let (scene, view) = room();
    let (settings, control) = (RenderSettings::default(), Control::default());
    let mut film = Film::new(view.width, view.height, view.show_environment);
    render_pass(&scene, &view, &settings, &mut film, 0..2, &control).expect("not stopped");
    let before = film.clone();
    control.begin(0);
    std::thread::scope(|scope| {
        scope.spawn(|| {
            // As soon as some paths have been traced.
            while control.progress().0 == 0 {
                std::thread::yield_now();
            }
            control.stop();
        });
        assert!(render_pass(&scene, &view, &settings, &mut film, 2..20_000, &control).is_err());
    });
    assert_eq!(film, before);
}
