//! Pixels that use each other's paths show the same picture, with less noise.
#![allow(clippy::disallowed_methods, reason = "no pixel depends on this arithmetic")]

mod common;

use common::everything::{at, everything};
use common::{add, cube, lambert, shoot, sphere, square, view};
use glam::{DAffine3, DVec3};
use kiln::film::{Estimate, Film};
use kiln::formats::scene::{
    Alpha, AlphaMode, Channel, ColorInput, ColorSpace, Filter, Image, Material, Mesh, MetalRough, Pixels, ScalarInput,
    Surface, Texture, TextureRef, Wrap,
};
use kiln::integrate::{Rendered, View, render, render_pass, shares_paths};
use kiln::math::statistics;
use kiln::prepare::{EnvironmentSource, prepare};
use kiln::settings::{Adaptive, Integrator, PrepareSettings, RenderSettings, Reuse, SamplerKind, SimdTier, Strategy};
use kiln::{Control, Scene};

/// A box with a small lamp, of which most surfaces are diffuse: facets, smooth shading and a texture; a metal ball, and a shiny block.
fn room() -> Scene {
    let mut scene = Scene::default();
    let checks = [255u8, 255, 255, 255, 60, 20, 10, 0, 60, 20, 10, 128, 255, 200, 90, 255];
    scene.images.push(Image { name: String::new(), width: 2, height: 2, pixels: Pixels::Rgba8(checks.to_vec()) });
    let (wrap, filter, color_space) = (Wrap::Repeat, Filter::Linear, ColorSpace::Srgb);
    scene.textures.push(Texture { image: 0, wrap_u: wrap, wrap_v: wrap, filter, color_space });
    let rough = |color, metallic, roughness| Material {
        surface: Surface::MetalRough(MetalRough {
            base_color: ColorInput::constant(color),
            metallic: ScalarInput::constant(metallic),
            roughness: ScalarInput::constant(roughness),
            ..MetalRough::default()
        }),
        ..Material::default()
    };
    add(&mut scene, cube(true), lambert(0.7, 0.0), at(0.0, 0.0, 0.0, 1.0));
    add(&mut scene, sphere(2), lambert(0.6, 0.0), at(-0.5, -0.65, -0.5, 0.35));
    add(&mut scene, sphere(3), rough([0.9, 0.6, 0.2], 1.0, 0.4), at(0.5, -0.6, -0.5, 0.35));
    add(&mut scene, cube(false), rough([0.2, 0.4, 0.8], 0.0, 0.3), at(0.0, -0.85, 0.1, 0.15));
    let uvs = [vec![[0.0, 0.0], [2.0, 0.0], [2.0, 2.0], [0.0, 2.0]], Vec::new()];
    let picture = ColorInput { factor: [1.0; 3], texture: Some(TextureRef::new(0)) };
    let mut poster = lambert(0.0, 0.0);
    if let Surface::MetalRough(m) = &mut poster.surface {
        m.base_color = picture;
    }
    add(&mut scene, Mesh { uvs: uvs.clone(), ..square() }, poster, at(0.0, 0.0, -0.98, 0.8));
    // Half of it lets light through, by chance.
    let value = ScalarInput { factor: 0.9, texture: Some(TextureRef::new(0)), channel: Channel::A, bias: 0.0 };
    let gauze = Material { alpha: Alpha { mode: AlphaMode::Blend, value }, ..lambert(0.8, 0.0) };
    let across = at(-0.1, -0.3, -0.1, 0.4) * DAffine3::from_rotation_y(0.9);
    add(&mut scene, Mesh { uvs, ..square() }, gauze, across);
    let down = at(0.2, 0.99, -0.2, 0.2) * DAffine3::from_rotation_x(std::f64::consts::FRAC_PI_2);
    add(&mut scene, square(), lambert(0.0, 12.0), down);
    scene
}

fn inside(size: u32) -> View {
    view(DVec3::new(0.1, 0.1, 0.95), DVec3::new(0.0, -0.3, -0.6), 80.0, size)
}

fn settings(reuse: Reuse, spp: u32, max_depth: u32) -> RenderSettings {
    RenderSettings { reuse, spp, max_depth, seed: u64::from(reuse == Reuse::On), ..RenderSettings::default() }
}

fn with(scene: &Scene, world: &EnvironmentSource, settings: &RenderSettings, view: &View) -> Rendered {
    let rendered = shoot(scene, world, &PrepareSettings::default(), settings, view);
    assert_eq!((rendered.nonfinite, rendered.film.shares), (0, settings.shares()));
    rendered
}

/// Means of blocks of 4 × 4 pixels, all channels: each of their pixels is of another group.
fn blocks(film: &Film) -> Vec<Estimate> {
    let width = film.width as usize;
    let pixels = |k: usize| {
        let corner = (k / (width / 4) * width + k % (width / 4)) * 4;
        (0..16).map(move |i| corner + i / 4 * width + i % 4)
    };
    let channels = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    (0..film.pixels.len() / 16).flat_map(|k| channels.map(|c| film.estimate(pixels(k), c))).collect()
}

/// Student's t of a difference, and its degrees of freedom (Welch).
fn welch(a: &Estimate, b: &Estimate) -> (f64, f64) {
    let share = |e: &Estimate| e.variance * e.variance / e.degrees;
    let variance = a.variance + b.variance;
    let degrees = variance * variance / (share(a) + share(b)).max(1e-300);
    ((a.mean - b.mean) / variance.sqrt().max(1e-9), degrees.clamp(1.0, 1e5))
}

fn assert_same_light(
    scene: &Scene,
    world: &EnvironmentSource,
    view: &View,
    of: impl Fn(Reuse) -> RenderSettings,
    what: &str,
) {
    let [with_it, without] = [Reuse::On, Reuse::Off].map(|reuse| with(scene, world, &of(reuse), view));
    let whole = |r: &Rendered| r.film.estimate(0..r.film.pixels.len(), [1.0 / 3.0; 3]);
    let (a, b) = (blocks(&with_it.film), blocks(&without.film));
    let level = statistics::sidak(1e-3, a.len() + 1);
    let (t, degrees) = welch(&whole(&with_it), &whole(&without));
    println!("{what}: {:?} {:?}, t = {t}", whole(&with_it), whole(&without));
    assert!(statistics::student_t_two_sided(t, degrees) > level, "{what}: t = {t}");
    for (k, (a, b)) in a.iter().zip(&b).enumerate() {
        let (t, degrees) = welch(a, b);
        let p = statistics::student_t_two_sided(t, degrees);
        assert!(p > level, "{what}: block {k}: {} and {}, t = {t} ({degrees} degrees)", a.mean, b.mean);
    }
}

#[test]
fn the_light_is_that_of_paths_used_once() {
    let (dark, view) = (EnvironmentSource::None, inside(16));
    assert_same_light(&room(), &dark, &view, |reuse| settings(reuse, 1024, 4), "room");
    // One bounce only: what is joined is all the indirect light there is.
    assert_same_light(&room(), &dark, &view, |reuse| settings(reuse, 1024, 2), "two scatterings");
    let early = |reuse| RenderSettings { roulette_after: 1, strategy: Strategy::Light, ..settings(reuse, 1024, 4) };
    assert_same_light(&room(), &dark, &view, early, "roulette from the first vertex on");
    // Open to a studio's map.
    let mut open = room();
    open.instances.remove(0);
    assert_same_light(&open, &EnvironmentSource::Studio, &inside(32), |reuse| settings(reuse, 256, 4), "studio");
}

/// What a shiny wall sends to one viewer it does not send to another: it is no second vertex for others.
#[test]
fn what_shines_is_each_pixels_own() {
    let mut scene = room();
    scene.instances.drain(1..6);
    if let Surface::MetalRough(m) = &mut scene.materials[0].surface {
        m.base_color = ColorInput::constant([0.1; 3]);
        (m.specular, m.roughness) = (ScalarInput::constant(1.0), ScalarInput::constant(0.25));
    }
    add(
        &mut scene,
        square(),
        lambert(0.8, 0.0),
        at(0.0, -0.99, 0.0, 1.0) * DAffine3::from_rotation_x(-std::f64::consts::FRAC_PI_2),
    );
    assert_same_light(&scene, &EnvironmentSource::None, &inside(16), |reuse| settings(reuse, 2048, 3), "shiny walls");
}

#[test]
fn the_light_is_the_same_in_a_scene_with_everything() {
    let mut scene = everything();
    scene.lights.iter_mut().for_each(|l| l.through_glass = false);
    let world = EnvironmentSource::Constant([0.2; 3]);
    let view = view(DVec3::new(0.1, 0.1, 0.95), DVec3::new(0.0, -0.2, -0.6), 70.0, 16);
    assert_same_light(&scene, &world, &view, |reuse| settings(reuse, 1024, 8), "everything");
}

#[test]
fn a_furnace_has_its_light_on_average() {
    let mut scene = Scene::default();
    add(&mut scene, cube(true), lambert(0.5, 1.0), at(0.0, 0.0, 0.0, 1.0));
    let ways = RenderSettings { strategy: Strategy::Bsdf, roulette_after: u32::MAX, ..settings(Reuse::On, 16, 6) };
    let film = with(&scene, &EnvironmentSource::None, &ways, &inside(48)).film;
    let own = film.estimate(0..film.pixels.len(), [1.0, 0.0, 0.0]);
    // All paths gather the same; what one pixel gets too little, others of its group get too much.
    let expected = (0..=6).map(|k| 0.5f64.powi(k)).sum::<f64>();
    assert!((own.mean - expected).abs() < 1e-4 * expected, "{} and {expected}", own.mean);
    let pixels: f64 = film.pixels.iter().map(|p| p.variance()[0]).sum();
    assert!(own.variance < 1e-6 * pixels, "{} and {pixels}", own.variance);
}

#[test]
fn indirect_light_has_less_noise() {
    // The box and its lamp alone.
    let mut bare = room();
    bare.instances.drain(1..6);
    let noise = |reuse| {
        let ways = RenderSettings { adaptive: Adaptive::Off, ..settings(reuse, 32, 4) };
        let film = with(&bare, &EnvironmentSource::None, &ways, &inside(64)).film;
        let mut all: Vec<f64> = film.pixels.iter().map(|p| p.variance().iter().sum::<f64>()).collect();
        // Of a few pixels, edges of the lamp make nearly all of the sum.
        all.sort_by(f64::total_cmp);
        all[all.len() / 2]
    };
    let [with_it, without] = [Reuse::On, Reuse::Off].map(noise);
    println!("median variance {with_it} and {without}");
    assert!(with_it < 0.3 * without, "{with_it} and {without}");
}

#[test]
fn every_tier_number_of_threads_and_cut_into_passes_gives_the_same_bytes() {
    let mut scene = everything();
    scene.lights.iter_mut().for_each(|l| l.through_glass = false);
    // Much of the picture is empty: where nothing is there to be met, pixels of groups are missing.
    let mut few = room();
    few.instances.truncate(3);
    few.instances.remove(0);
    let distant = view(DVec3::new(0.5, 0.5, 4.0), DVec3::new(0.0, -0.5, -0.5), 30.0, 37);
    for (scene, mut view) in [(scene, inside(37)), (room(), inside(37)), (few, distant)] {
        view.show_environment = false;
        let film = |simd, threads, cuts: &[u32]| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads");
            let (control, prepare_settings) =
                (Control::default(), PrepareSettings { simd, ..PrepareSettings::default() });
            let studio = EnvironmentSource::Studio;
            pool.install(|| {
                let prepared = prepare(scene.clone(), &studio, &prepare_settings, &control).expect("prepared");
                let mut film = Film::new(view.width, view.height, false);
                for end in cuts {
                    let samples = film.spp..*end;
                    let settings = settings(Reuse::On, 9, 5);
                    render_pass(&prepared, &view, &settings, &mut film, samples, &control).expect("not stopped");
                }
                film
            })
        };
        let first = film(SimdTier::Scalar, 1, &[9]);
        for (simd, threads, cuts) in
            [(SimdTier::Avx2, 2, &[1, 9][..]), (SimdTier::Avx512, 1, &[3, 4, 9]), (SimdTier::Auto, 5, &[9])]
        {
            assert_eq!(first, film(simd, threads, cuts), "{simd:?}, {threads} threads, {cuts:?}");
        }
    }
}

#[test]
fn integrators_that_follow_each_path_alone_do_not_share() {
    let alone = RenderSettings { integrator: Integrator::Plain, ..settings(Reuse::On, 2, 2) };
    assert!(!alone.shares());
    let film = with(&room(), &EnvironmentSource::None, &alone, &inside(16)).film;
    assert!(!film.shares);
}

#[test]
fn where_nothing_is_diffuse_nothing_is_shared_and_pixels_stay_independent() {
    let metal = |metallic| {
        let metal = MetalRough { metallic: ScalarInput::constant(metallic), ..MetalRough::default() };
        Material { surface: Surface::MetalRough(metal), ..Material::default() }
    };
    let shares = |material: Material, settings: &RenderSettings| {
        let mut scene = Scene::default();
        add(&mut scene, square(), material, DAffine3::IDENTITY);
        let world = EnvironmentSource::Constant([1.0; 3]);
        let prepared = prepare(scene, &world, &PrepareSettings::default(), &Control::default()).expect("not stopped");
        let film = render(&prepared, &inside(16), settings, &Control::default()).expect("not stopped").film;
        assert_eq!(film.shares, shares_paths(&prepared, settings));
        let allotted = settings.allotted(film.shares);
        assert_eq!(allotted == Adaptive::Off, film.shares, "noise decides where pixels are independent");
        film.shares
    };
    let on = settings(Reuse::On, 2, 2);
    assert!(shares(lambert(0.5, 0.0), &on));
    assert!(!shares(metal(1.0), &on));
    assert!(!shares(metal(0.0), &on), "plastic reflects like a mirror, a little");
    assert!(!shares(lambert(0.5, 0.0), &RenderSettings { sampler: SamplerKind::Xorshift32, ..on }));
}
