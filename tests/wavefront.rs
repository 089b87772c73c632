//! The wavefront gives the pictures of the plain integrator: the same paths, to rounding.

#![allow(clippy::disallowed_methods, reason = "no pixel depends on this arithmetic")]

mod common;

use common::everything::everything;
use common::{add, cube, lambert, shoot, sphere, square, view};
use glam::{DAffine3, DVec3};
use kiln::formats::scene::{
    Channel, ColorInput, ColorSpace, Filter, Image, Instance, Layers, Light, LightKind, Material, Mesh, MetalRough,
    NormalMap, Pixels, ScalarInput, Surface, Texture, TextureRef, Wrap,
};
use kiln::integrate::{Rendered, View, render};
use kiln::prepare::{EnvironmentSource, prepare};
use kiln::settings::{Instances, Integrator, PrepareSettings, RenderSettings, SamplerKind, SimdTier, Strategy};
use kiln::{Control, Scene};

/// Renders with both integrators, and compares each channel of each pixel. Where two numbers are nearly equal, rounding may
/// decide for another lobe or let a ray pass an edge on the other side; such pixels must be rare.
fn assert_same(scene: &Scene, world: &EnvironmentSource, settings: RenderSettings, view: &View, what: &str) {
    let [wavefront, plain] = [Integrator::Path, Integrator::Plain].map(|integrator| {
        shoot(scene, world, &PrepareSettings::default(), &RenderSettings { integrator, ..settings }, view)
    });
    assert_eq!(wavefront.nonfinite, plain.nonfinite, "{what}");
    let count = |r: &Rendered| [r.rays.camera, r.rays.bounce, r.rays.shadow];
    for (a, b) in count(&wavefront).into_iter().zip(count(&plain)) {
        assert!(a.abs_diff(b) as f64 <= 2e-4 * b as f64, "{what}: {a} rays, not {b}");
    }
    let (mut near, mut others, mut lit) = (0, 0, 0);
    for (a, b) in wavefront.picture.pixels.iter().zip(&plain.picture.pixels) {
        assert_eq!(a[3], b[3], "{what}");
        lit += usize::from(b[0] > 0.0);
        let differs = |by: f32| usize::from((0..3).any(|c| (a[c] - b[c]).abs() > by * b[c].max(0.05)));
        near += differs(2e-5);
        others += differs(1e-3);
    }
    let pixels = plain.picture.pixels.len();
    assert!(lit > pixels / 4, "{what}: a black picture says nothing");
    // Curved mirrors and glass magnify rounding.
    assert!(near <= pixels / 20 && others <= pixels / 100, "{what}: {near} pixels differ, {others} of them by much");
}

/// Surfaces that lanes know: facets and smooth shading, diffuse, plastic, metal, lit by faces, points and the sun.
fn rough() -> Scene {
    let mut scene = Scene::default();
    let at = |x: f64, y: f64, z: f64, s: f64| {
        DAffine3::from_translation(DVec3::new(x, y, z)) * DAffine3::from_scale(DVec3::splat(s))
    };
    let metal_rough = |color: [f32; 3], metallic, roughness| Material {
        surface: Surface::MetalRough(MetalRough {
            base_color: ColorInput::constant(color),
            metallic: ScalarInput::constant(metallic),
            roughness: ScalarInput::constant(roughness),
            ..MetalRough::default()
        }),
        ..Material::default()
    };
    add(&mut scene, cube(true), lambert(0.7, 0.0), at(0.0, 0.0, 0.0, 1.0));
    add(&mut scene, sphere(2), lambert(0.5, 0.0), at(-0.5, -0.7, -0.3, 0.3));
    add(&mut scene, sphere(3), metal_rough([0.9, 0.6, 0.2], 1.0, 0.3), at(0.5, -0.6, -0.4, 0.4));
    add(&mut scene, cube(false), metal_rough([0.2, 0.4, 0.8], 0.0, 0.5), at(0.0, -0.8, 0.2, 0.2));
    let lamp = Mesh { normals: Vec::new(), ..square() };
    let down = DAffine3::from_translation(DVec3::new(0.0, 0.99, 0.0))
        * DAffine3::from_cols(DVec3::X * 0.3, DVec3::Z * 0.3, -DVec3::Y, DVec3::ZERO);
    add(&mut scene, lamp, lambert(0.0, 8.0), down);
    scene.lights.push(Light {
        name: String::new(),
        kind: LightKind::Directional,
        color: [0.3; 3],
        position: DVec3::ZERO,
        direction: DVec3::new(0.1, -0.2, -1.0).normalize(),
        through_glass: false,
    });
    scene
}

/// Clear coats in the box of [`rough`]: mirrors, rough ones, with strengths from an image, and with normals of their own.
fn coats() -> Scene {
    let mut scene = rough();
    let texels = vec![160u8, 128, 250, 255, 128, 90, 240, 255, 0, 150, 250, 255, 100, 128, 255, 255];
    scene.images.push(Image { name: String::new(), width: 2, height: 2, pixels: Pixels::Rgba8(texels) });
    let (wrap_u, wrap_v, filter, color_space) = (Wrap::Repeat, Wrap::Repeat, Filter::Linear, ColorSpace::Linear);
    scene.textures.push(Texture { image: 0, wrap_u, wrap_v, filter, color_space });
    let map = || Some(NormalMap { texture: TextureRef::new(0), scale: 0.8 });
    let coated = |layers: Layers, [metallic, roughness]: [f32; 2], normal_map| Material {
        surface: Surface::MetalRough(MetalRough {
            base_color: ColorInput::constant([0.7, 0.2, 0.1]),
            metallic: ScalarInput::constant(metallic),
            roughness: ScalarInput::constant(roughness),
            layers: Some(layers),
            ..MetalRough::default()
        }),
        normal_map,
        ..Material::default()
    };
    let strength = ScalarInput { factor: 1.0, texture: Some(TextureRef::new(0)), channel: Channel::R, bias: 0.0 };
    let (full, rough) = (ScalarInput::constant(1.0), ScalarInput::constant(0.4));
    let smooth = Layers { clearcoat: full, ..Layers::default() };
    let worn = Layers { clearcoat: strength, clearcoat_roughness: rough, ..Layers::default() };
    let own = Layers { clearcoat: full, clearcoat_normal_map: map(), ..Layers::default() };
    let uvs = [vec![[0.0, 0.0], [2.0, 0.0], [2.0, 2.0], [0.0, 2.0]], Vec::new()];
    let sheet = Mesh { uvs, tangents: vec![[1.0, 0.0, 0.0, 1.0]; 4], ..square() };
    let at = |x: f64, y: f64, s: f64| {
        DAffine3::from_translation(DVec3::new(x, y, -0.7)) * DAffine3::from_scale(DVec3::splat(s))
    };
    add(&mut scene, sphere(2), coated(smooth, [0.0, 0.5], None), at(0.0, 0.4, 0.25));
    add(&mut scene, sheet.clone(), coated(worn, [0.0, 0.5], None), at(-0.5, 0.4, 0.25));
    add(&mut scene, sheet.clone(), coated(own, [1.0, 0.5], None), at(0.5, 0.4, 0.25));
    add(&mut scene, sheet.clone(), coated(smooth, [0.0, 0.5], map()), at(0.5, -0.1, 0.2));
    // Light samples matter by the coat alone.
    let rough_alone = Layers { clearcoat: full, clearcoat_roughness: rough, ..Layers::default() };
    add(&mut scene, sheet, coated(rough_alone, [1.0, 0.0], None), at(-0.5, -0.1, 0.2));
    scene
}

/// With so many light samples a vertex, or with 0 as many as renders take unasked.
fn settings(strategy: Strategy, sampler: SamplerKind, light_samples: u32) -> RenderSettings {
    let light_samples = (light_samples > 0).then_some(light_samples);
    RenderSettings { spp: 8, max_depth: 8, strategy, sampler, light_samples, ..RenderSettings::default() }
}

#[test]
fn a_scene_with_everything_comes_out_the_same() {
    let view = view(DVec3::new(0.1, 0.1, 0.95), DVec3::new(0.0, -0.2, -0.6), 70.0, 37);
    let world = EnvironmentSource::Constant([0.2; 3]);
    for (strategy, sampler, light_samples) in [
        (Strategy::Mis, SamplerKind::Sobol, 0),
        (Strategy::Mis, SamplerKind::Pcg, 3),
        (Strategy::Light, SamplerKind::Sobol, 0),
        (Strategy::Bsdf, SamplerKind::Sobol, 1),
        (Strategy::Cosine, SamplerKind::Xorshift32, 1),
    ] {
        let what = format!("{strategy:?} {sampler:?} {light_samples}");
        assert_same(&everything(), &world, settings(strategy, sampler, light_samples), &view, &what);
        // Without light that goes straight through glass, lanes shade what they can.
        let mut plain_lights = everything();
        plain_lights.lights.iter_mut().for_each(|l| l.through_glass = false);
        assert_same(&plain_lights, &world, settings(strategy, sampler, light_samples), &view, &what);
    }
}

#[test]
fn rough_surfaces_come_out_the_same() {
    let inside = view(DVec3::new(0.1, 0.1, 0.95), DVec3::new(0.0, -0.4, -0.6), 80.0, 50);
    for (strategy, light_samples) in [(Strategy::Mis, 0), (Strategy::Mis, 4), (Strategy::Light, 1), (Strategy::Bsdf, 1)]
    {
        let settings = settings(strategy, SamplerKind::Sobol, light_samples);
        let what = format!("{strategy:?} {light_samples}");
        assert_same(&rough(), &EnvironmentSource::None, settings, &inside, &what);
    }
    for (strategy, light_samples) in [(Strategy::Mis, 0), (Strategy::Light, 2), (Strategy::Bsdf, 1)] {
        let settings = settings(strategy, SamplerKind::Sobol, light_samples);
        assert_same(&coats(), &EnvironmentSource::None, settings, &inside, &format!("coats, {strategy:?}"));
    }
    // Without the box around it, below the studio's map.
    let mut open = rough();
    open.instances.remove(0);
    let outside = view(DVec3::new(1.0, 0.6, 2.0), DVec3::new(0.0, -0.6, 0.0), 40.0, 50);
    let settings = settings(Strategy::Mis, SamplerKind::Sobol, 1);
    assert_same(&open, &EnvironmentSource::Studio, settings, &outside, "open");
}

#[test]
fn every_tier_and_number_of_threads_gives_the_same_bytes() {
    let view = view(DVec3::new(0.1, 0.1, 0.95), DVec3::new(0.0, -0.4, -0.6), 80.0, 33);
    let settings = RenderSettings { spp: 6, max_depth: 6, ..RenderSettings::default() };
    let shoot_with = |scene: &Scene, simd, threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads");
        let prepare = PrepareSettings { simd, ..PrepareSettings::default() };
        pool.install(|| shoot(scene, &EnvironmentSource::Studio, &prepare, &settings, &view)).film
    };
    for scene in [everything(), rough(), coats()] {
        let first = shoot_with(&scene, SimdTier::Scalar, 1);
        for (simd, threads) in [(SimdTier::Avx2, 2), (SimdTier::Avx512, 1), (SimdTier::Auto, 5)] {
            assert_eq!(first, shoot_with(&scene, simd, threads), "{simd:?}, {threads} threads");
        }
    }
}

/// The scene with every mesh twice more: smaller, mirrored and sheared, in other places.
fn with_copies(mut scene: Scene) -> Scene {
    let mirrored = DAffine3::from_scale(DVec3::new(-0.3, 0.4, 0.35));
    let sheared = DAffine3::from_cols(
        DVec3::new(0.3, 0.1, 0.0),
        DVec3::new(-0.05, 0.25, 0.1),
        DVec3::new(0.1, 0.0, 0.3),
        DVec3::ZERO,
    );
    for instance in scene.instances.clone() {
        for (map, place) in [(mirrored, DVec3::new(0.3, 0.2, 0.1)), (sheared, DVec3::new(-0.4, -0.2, 0.3))] {
            let transform = DAffine3::from_translation(place) * map * instance.transform;
            scene.instances.push(Instance { transform, ..instance.clone() });
        }
    }
    scene
}

#[test]
fn triangles_that_placements_share_give_the_same_bytes() {
    let view = view(DVec3::new(0.1, 0.1, 0.95), DVec3::new(0.0, -0.4, -0.6), 80.0, 33);
    for (scene, integrator) in
        [(everything(), Integrator::Path), (everything(), Integrator::Plain), (rough(), Integrator::Path)]
    {
        let scene = with_copies(scene);
        let settings = RenderSettings { spp: 6, max_depth: 6, integrator, ..RenderSettings::default() };
        let [shared, copied] = [Instances::Always, Instances::Never].map(|instances| {
            let settings = PrepareSettings { instances, ..PrepareSettings::default() };
            prepare(scene.clone(), &EnvironmentSource::Studio, &settings, &Control::default()).expect("not stopped")
        });
        assert!(shared.kdtree_statistics().instances > 10 && copied.kdtree_statistics().instances == 0);
        let film = |prepared| render(prepared, &view, &settings, &Control::default()).expect("done").film;
        assert!(film(&shared) == film(&copied), "{integrator:?}");
        assert_eq!(shared.emitters, copied.emitters);
    }
}
