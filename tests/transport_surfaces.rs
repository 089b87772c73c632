//! Known answers for surfaces: coverage, culling, mirrored placements, cameras, and scenes with next to nothing in them.

#![allow(clippy::disallowed_methods, reason = "expected values may come from std's functions")]

mod common;

use common::{add, cube, lambert, mean_and_error, shoot, sphere, square, view};
use glam::{DAffine3, DVec3};
use kiln::Scene;
use kiln::formats::scene::{
    Alpha, AlphaMode, Camera, ColorInput, ColorSpace, Extent, Falloff, Filter, Image, Light, LightKind, Material, Mesh,
    NormalMap, Pixels, Projection, ScalarInput, Surface, Texture, TextureRef, Wrap,
};
use kiln::integrate::{Rendered, View};
use kiln::prepare::{EnvironmentSource, has_own_light};
use kiln::settings::{Integrator, PrepareSettings, RenderSettings, SamplerKind, Strategy};
use std::f64::consts::PI;

const WHITE: EnvironmentSource = EnvironmentSource::Constant([1.0; 3]);

fn sun(direction: DVec3) -> Light {
    let kind = LightKind::Directional;
    Light { name: String::new(), kind, color: [2.0; 3], position: DVec3::ZERO, direction, through_glass: false }
}

fn shot(scene: &Scene, environment: &EnvironmentSource, view: &View, spp: u32) -> Rendered {
    let settings = RenderSettings { spp, ..RenderSettings::default() };
    let rendered = shoot(scene, environment, &PrepareSettings::default(), &settings, view);
    assert_eq!(rendered.nonfinite, 0);
    rendered
}

fn from_above() -> View {
    view(DVec3::new(0.1, 0.05, 3.0), DVec3::new(0.1, 0.05, 0.0), 1.0, 8)
}

fn sheet(mode: AlphaMode, alpha: f32) -> Material {
    Material { alpha: Alpha { mode, value: ScalarInput::constant(alpha) }, ..lambert(0.0, 0.0) }
}

#[test]
fn sheets_cover_what_their_alpha_says() {
    for (sheets, expected) in [(1, 0.7f64), (2, 0.49)] {
        let mut scene = Scene::default();
        for k in 0..sheets {
            let place = DAffine3::from_translation(DVec3::NEG_Z * f64::from(k) * 0.5);
            add(&mut scene, square(), sheet(AlphaMode::Blend, 0.3), place);
        }
        for show_environment in [true, false] {
            let view = View { show_environment, ..from_above() };
            let rendered = shot(&scene, &WHITE, &view, 256);
            let alpha = rendered.picture.pixels.iter().map(|p| f64::from(p[3])).sum::<f64>() / 64.0;
            let light = mean_and_error(&rendered).0;
            let error = (expected * (1.0 - expected) / 256.0 / 64.0).sqrt();
            if show_environment {
                assert!((light - expected).abs() < 4.0 * error, "{light}, expected {expected}");
                assert_eq!(alpha, 1.0);
            } else {
                assert!((1.0 - alpha - expected).abs() < 4.0 * error, "{alpha}, expected {}", 1.0 - expected);
                assert_eq!(light, 0.0);
            }
        }
    }
}

#[test]
fn masks_are_all_or_nothing() {
    for (alpha, expected) in [(0.49, 0.0), (0.5, 1.0), (0.9, 1.0)] {
        let mut scene = Scene::default();
        add(&mut scene, square(), sheet(AlphaMode::Mask { cutoff: 0.5 }, alpha), DAffine3::IDENTITY);
        let view = View { show_environment: false, ..from_above() };
        let rendered = shot(&scene, &WHITE, &view, 4);
        assert!(rendered.picture.pixels.iter().all(|p| p[3] == expected), "alpha {alpha}");
    }
}

/// The eye looks through the back of a single-sided sheet; the sun does not.
#[test]
fn culled_backs_are_unseen_but_cast_shadows() {
    let floor_seen = |double_sided, with_sheet| {
        let mut scene = Scene::default();
        add(&mut scene, square(), lambert(0.5, 0.0), DAffine3::from_scale(DVec3::splat(3.0)));
        if with_sheet {
            let facing_down = DAffine3::from_translation(DVec3::Z) * DAffine3::from_rotation_x(PI);
            let glowing = Material { double_sided, emission_two_sided: double_sided, ..lambert(0.0, 7.0) };
            add(&mut scene, square(), glowing, facing_down);
        }
        scene.lights.push(sun(DVec3::NEG_Z));
        let settings = RenderSettings { spp: 4, strategy: Strategy::Cosine, max_depth: 1, ..RenderSettings::default() };
        let prepare = PrepareSettings::default();
        let lit = shoot(&scene, &EnvironmentSource::None, &prepare, &settings, &from_above());
        // The floor's direct sunlight alone: what paths of length 0 and a delta light give, without the sheet's glow.
        scene.materials.iter_mut().skip(1).for_each(|m| m.emission = ColorInput::BLACK);
        let dark = shoot(&scene, &EnvironmentSource::None, &prepare, &settings, &from_above());
        (mean_and_error(&lit).0, mean_and_error(&dark).0)
    };
    let (_, lit) = floor_seen(false, false);
    assert!((lit - 0.5 / PI * 2.0).abs() < 1e-4, "{lit}");
    let (glow, shadow) = floor_seen(false, true);
    assert_eq!(shadow, 0.0, "the sheet shades the floor");
    assert!(glow > 0.1 && glow < 4.0, "its front lights the floor below, and the eye sees that: {glow}");
    let (glow, _) = floor_seen(true, true);
    assert!((glow - 7.0).abs() < 1e-4, "a double-sided sheet is seen itself: {glow}");
}

/// A placement that mirrors keeps the front in front: for light that falls on it, and for light that it emits.
#[test]
fn mirrored_placements_keep_their_front() {
    for (scale, front_up) in [
        (DVec3::new(-1.0, 1.0, 1.0), true),
        (DVec3::new(1.0, -1.0, 1.0), true),
        (DVec3::new(1.0, 1.0, -1.0), false),
        (DVec3::new(-1.0, -1.0, -1.0), false),
        (DVec3::ONE, true),
    ] {
        let mut scene = Scene::default();
        let material = Material { double_sided: true, ..lambert(0.5, 3.0) };
        let normals = vec![[0.0, 0.0, 1.0]; 4];
        add(&mut scene, Mesh { normals, ..square() }, material, DAffine3::from_scale(scale));
        scene.lights.push(sun(DVec3::NEG_Z));
        let (seen, error) = mean_and_error(&shot(&scene, &EnvironmentSource::None, &from_above(), 64));
        let expected = 0.5 / PI * 2.0 + if front_up { 3.0 } else { 0.0 };
        // Light samples that choose the surface itself bring nothing: noise.
        assert!((seen - expected).abs() < 4.0 * error + 1e-4, "{scale}: {seen} ± {error}, expected {expected}");
        // What it sends to a floor on its front side, by light samples.
        let lamp_height = if front_up { -1.0 } else { 1.0 };
        let mut scene = Scene::default();
        add(&mut scene, square(), lambert(0.0, 3.0), DAffine3::from_scale(scale));
        let floor = DAffine3::from_translation(DVec3::NEG_Z * lamp_height);
        add(&mut scene, square(), lambert(0.5, 0.0), floor);
        let eye = DVec3::new(0.0, 0.0, -0.5 * lamp_height);
        let view = view(eye, DVec3::NEG_Z * lamp_height, 1.0, 8);
        assert!(mean_and_error(&shot(&scene, &EnvironmentSource::None, &view, 16)).0 > 0.1, "{scale}");
    }
}

/// The bent normal of a mirrored placement is the mirror image of the bent normal.
#[test]
fn mirrored_placements_mirror_their_normal_maps() {
    let bent = DVec3::new(0.3, 0.5, 0.66).normalize();
    let texel = (bent * 0.5 + 0.5).as_vec3();
    for scale in [DVec3::ONE, DVec3::new(-1.0, 1.0, 1.0), DVec3::new(1.0, -1.0, 1.0), DVec3::new(-2.0, -2.0, 2.0)] {
        let mut scene = Scene::default();
        let pixels = Pixels::RgbaF32(vec![texel.x, texel.y, texel.z, 1.0]);
        scene.images.push(Image { name: String::new(), width: 1, height: 1, pixels });
        let (wrap, color_space) = (Wrap::Repeat, ColorSpace::Linear);
        scene.textures.push(Texture { image: 0, wrap_u: wrap, wrap_v: wrap, filter: Filter::Nearest, color_space });
        let mesh = Mesh {
            normals: vec![[0.0, 0.0, 1.0]; 4],
            tangents: vec![[1.0, 0.0, 0.0, 1.0]; 4],
            uvs: [vec![[0.5, 0.5]; 4], Vec::new()],
            ..square()
        };
        let normal_map = Some(NormalMap { texture: TextureRef::new(0), scale: 1.0 });
        add(&mut scene, mesh, Material { normal_map, ..lambert(0.5, 0.0) }, DAffine3::from_scale(scale));
        let to_sun = DVec3::new(0.36, 0.48, 0.8);
        scene.lights.push(sun(-to_sun));
        let seen = mean_and_error(&shot(&scene, &EnvironmentSource::None, &from_above(), 4)).0;
        let world_normal = (bent * scale.signum()).normalize();
        let expected = 0.5 / PI * 2.0 * world_normal.dot(to_sun);
        assert!((seen - expected).abs() < 1e-3 * expected, "{scale}: {seen}, expected {expected}");
    }
}

#[test]
fn unlit_surfaces_show_their_colour() {
    let mut scene = Scene::default();
    let surface = Surface::Unlit(ColorInput::constant([0.25, 0.5, 0.75]));
    add(&mut scene, square(), Material { surface, ..Material::default() }, DAffine3::IDENTITY);
    scene.lights.push(sun(DVec3::NEG_Z));
    for pixel in shot(&scene, &WHITE, &from_above(), 4).picture.pixels {
        assert_eq!(pixel, [0.25, 0.5, 0.75, 1.0]);
    }
}

fn orthographic(origin: DVec3, forward: DVec3, half: f64, size: u32) -> View {
    let forward = forward.normalize();
    let right = forward.cross(DVec3::Y).normalize();
    let camera = Camera {
        name: String::new(),
        projection: Projection::Orthographic,
        origin,
        forward: forward * 7.0,
        right: right * half,
        up: right.cross(forward) * half,
        aspect: Some(1.0),
    };
    View { camera, width: size, height: size, show_environment: false }
}

#[test]
fn orthographic_pictures_have_no_perspective() {
    for distance in [0.5, 30.0] {
        let mut scene = Scene::default();
        add(&mut scene, square(), lambert(0.0, 2.0), DAffine3::IDENTITY);
        let view = orthographic(DVec3::Z * distance, DVec3::NEG_Z, 2.0, 16);
        let rendered = shot(&scene, &EnvironmentSource::None, &view, 4);
        for (k, pixel) in rendered.picture.pixels.iter().enumerate() {
            let inside = (4..12).contains(&(k % 16)) && (4..12).contains(&(k / 16));
            assert_eq!(*pixel, if inside { [2.0, 2.0, 2.0, 1.0] } else { [0.0; 4] }, "pixel {k}");
        }
    }
}

/// From ten million units away a perspective picture of a small field is an orthographic one.
#[test]
fn far_cameras_see_sharply() {
    let mut scene = Scene::default();
    add(&mut scene, sphere(4), lambert(0.0, 1.0), DAffine3::IDENTITY);
    let direction = DVec3::new(0.5, 0.6, 0.62).normalize();
    let (distance, half) = (1e7, 1.25f64);
    let far = view(direction * distance, DVec3::ZERO, 2.0 * (half / distance).atan().to_degrees(), 32);
    let far = View { show_environment: false, ..far };
    let near = orthographic(direction * 5.0, -direction, half, 32);
    let [far, near] = [far, near].map(|view| shot(&scene, &EnvironmentSource::None, &view, 16).picture.pixels);
    let off: f32 = far.iter().zip(&near).map(|(a, b)| (a[3] - b[3]).abs()).sum();
    let covered: f32 = near.iter().map(|p| p[3]).sum();
    assert!(covered > 400.0 && off < 0.01 * covered, "{off} of {covered} pixels differ");
}

/// What is black, or on nothing drawn, lights nothing: such an asset needs an environment.
#[test]
fn own_light_is_light_that_can_be_seen() {
    let mut scene = Scene::default();
    add(&mut scene, square(), lambert(0.5, 0.0), DAffine3::IDENTITY);
    scene.materials.push(lambert(0.5, 1.0));
    scene.lights.push(Light { color: [0.0; 3], ..sun(DVec3::NEG_Z) });
    assert!(!has_own_light(&scene, 0.0));
    scene.meshes[0].material = 1;
    assert!(has_own_light(&scene, 0.0));
    scene.meshes[0].material = 0;
    scene.lights.push(sun(DVec3::NEG_Z));
    assert!(has_own_light(&scene, 0.0));
}

/// Scenes with next to nothing in them, tiny pictures, any number of samples: no panic, nothing that is not finite.
#[test]
fn next_to_nothing_renders() {
    let triangle = || Mesh { triangles: vec![[0, 1, 2]], ..square() };
    let no_area = || Mesh { triangles: vec![[0, 0, 1], [1, 1, 1]], ..square() };
    let point = |position| Light {
        kind: LightKind::Point { falloff: Falloff::InverseSquare { range: None }, extent: Extent::Point },
        position,
        ..sun(DVec3::NEG_Z)
    };
    let mut scenes = vec![Scene::default(); 7];
    add(&mut scenes[1], triangle(), lambert(0.5, 1.0), DAffine3::IDENTITY);
    add(&mut scenes[2], no_area(), lambert(0.5, 1.0), DAffine3::IDENTITY);
    add(&mut scenes[3], cube(false), lambert(0.5, 1.0), DAffine3::from_scale(DVec3::new(1.0, 1.0, 0.0)));
    add(&mut scenes[4], cube(false), lambert(0.5, 1.0), DAffine3::from_scale(DVec3::splat(1e300)));
    add(&mut scenes[5], Mesh::default(), lambert(0.5, 1.0), DAffine3::IDENTITY);
    add(&mut scenes[6], cube(true), lambert(0.5, 0.0), DAffine3::from_scale(DVec3::splat(1e-30)));
    for scene in &mut scenes {
        scene.lights.extend([point(DVec3::Z), point(DVec3::ZERO), point(DVec3::splat(1e200)), sun(DVec3::NEG_Z)]);
    }
    // On the surface of the triangle and of the flattened cube, and inside the others.
    let mut on_surface = view(DVec3::ZERO, DVec3::new(0.3, 0.2, 0.1), 90.0, 1);
    let few = View { width: 2, height: 2, ..from_above() };
    on_surface.height = 3;
    for scene in &scenes {
        for environment in [EnvironmentSource::None, WHITE, EnvironmentSource::Studio] {
            for view in [few.clone(), on_surface.clone()] {
                for spp in [0, 1, 2, 3, 5] {
                    for (sampler, strategy) in
                        [(SamplerKind::Sobol, Strategy::Mis), (SamplerKind::Lcg, Strategy::Hemisphere)]
                    {
                        let settings = RenderSettings { spp, sampler, strategy, ..RenderSettings::default() };
                        let rendered = shoot(scene, &environment, &PrepareSettings::default(), &settings, &view);
                        assert_eq!(rendered.nonfinite, 0);
                        assert!(rendered.picture.pixels.iter().flatten().all(|x| x.is_finite()));
                    }
                }
            }
        }
    }
}

/// Lamps on a dark board, seen from afar: as bright on a grid of small triangles, most of which lie under black texels alone, as on two large ones.
#[test]
fn small_lamps_keep_their_light_on_any_mesh() {
    let size = 64u32;
    let lit = |k: u32| (30..34).contains(&(k % size)) && (30..34).contains(&(k / size));
    let pixels = (0..size * size).flat_map(|k| [[u8::from(lit(k)) * 255; 3].as_slice(), &[255]].concat()).collect();
    let scene = Scene {
        images: vec![Image { name: String::new(), width: size, height: size, pixels: Pixels::Rgba8(pixels) }],
        textures: vec![Texture {
            image: 0,
            wrap_u: Wrap::Clamp,
            wrap_v: Wrap::Clamp,
            filter: Filter::Linear,
            color_space: ColorSpace::Srgb,
        }],
        ..Scene::default()
    };
    let grid = |n: u32| {
        let at = |k: u32| [(k % (n + 1)) as f32 / n as f32, (k / (n + 1)) as f32 / n as f32];
        let uvs: Vec<[f32; 2]> = (0..(n + 1) * (n + 1)).map(at).collect();
        let positions = uvs.iter().map(|[u, v]| [2.0 * u - 1.0, 2.0 * v - 1.0, 0.0]).collect();
        let quad = |k: u32| {
            let a = k / n * (n + 1) + k % n;
            [[a, a + 1, a + n + 2], [a, a + n + 2, a + n + 1]]
        };
        Mesh { positions, uvs: [uvs, Vec::new()], triangles: (0..n * n).flat_map(quad).collect(), ..Mesh::default() }
    };
    let shown = ColorInput { factor: [100.0; 3], texture: Some(TextureRef::new(0)) };
    let screen = Material { emission: shown, emission_two_sided: true, ..lambert(0.0, 0.0) };
    for integrator in [Integrator::Path, Integrator::Plain] {
        let light = |n: u32| {
            let mut scene = scene.clone();
            add(&mut scene, grid(n), screen.clone(), DAffine3::IDENTITY);
            let settings = RenderSettings { spp: 64, integrator, ..RenderSettings::default() };
            let view = view(DVec3::new(0.0, 0.0, 8.0), DVec3::ZERO, 20.0, 6);
            let rendered = shoot(&scene, &EnvironmentSource::None, &PrepareSettings::default(), &settings, &view);
            rendered.picture.pixels.iter().map(|p| f64::from(p[1])).sum::<f64>()
        };
        let (coarse, fine) = (light(1), light(16));
        assert!(coarse > 1.0 && (fine / coarse - 1.0).abs() < 0.02, "{coarse} {fine}");
    }
}

/// A board of a million squares in sixteen pixels: four samples a pixel see grey, where single texels would be black or
/// white; so do rays that a mirror turns, and the picture stays sharp where the texture is large.
#[test]
fn fine_textures_are_seen_as_their_mean() {
    let size = 1024u32;
    let value = |x: u32, y: u32| if (x ^ y) & 1 == 0 { 255 } else { 0 };
    let pixels = (0..size * size).flat_map(|k| [[value(k % size, k / size); 3].as_slice(), &[255]].concat()).collect();
    let mut scene = Scene {
        images: vec![Image { name: String::new(), width: size, height: size, pixels: Pixels::Rgba8(pixels) }],
        textures: vec![Texture {
            image: 0,
            wrap_u: Wrap::Repeat,
            wrap_v: Wrap::Repeat,
            filter: Filter::Linear,
            color_space: ColorSpace::Srgb,
        }],
        ..Scene::default()
    };
    let mesh = Mesh { uvs: [vec![[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]], Vec::new()], ..square() };
    let shown = ColorInput { factor: [1.0; 3], texture: Some(TextureRef::new(0)) };
    let mut board = lambert(1.0, 0.0);
    let Surface::MetalRough(m) = &mut board.surface else { panic!("lambert() is metal-rough") };
    m.base_color = shown;
    let unlit = Material { surface: Surface::Unlit(shown), ..Material::default() };
    let screen = Material { emission: shown, emission_two_sided: true, ..lambert(0.0, 0.0) };
    for board in [unlit, screen] {
        let mut scene = scene.clone();
        add(&mut scene, mesh.clone(), board, DAffine3::IDENTITY);
        for integrator in [Integrator::Path, Integrator::Plain] {
            let view = view(DVec3::new(0.1, 0.05, 3.0), DVec3::ZERO, 30.0, 4);
            let settings = RenderSettings { spp: 4, integrator, ..RenderSettings::default() };
            let rendered = shoot(&scene, &WHITE, &PrepareSettings::default(), &settings, &view);
            let grey = rendered.picture.pixels.iter().map(|p| f64::from(p[1]));
            let spread = grey.fold(0.0f64, |most, g| most.max((g - 0.5).abs()));
            assert!(spread < 0.01, "{spread}");
        }
    }
    add(&mut scene, mesh, board, DAffine3::IDENTITY);
    let spread = |eye: DVec3, degrees: f64| {
        let rendered = shot(&scene, &WHITE, &view(eye, DVec3::ZERO, degrees, 4), 4);
        let grey = rendered.picture.pixels.iter().map(|p| f64::from(p[1]));
        grey.fold(0.0f64, |most, g| most.max((g - 0.5).abs()))
    };
    assert!(spread(DVec3::new(0.1, 0.05, 3.0), 30.0) < 0.01);
    assert!(spread(DVec3::new(2.0, 0.3, 2.0), 14.0) < 0.01);
    // Five pixels to a texel: black is dark and white is bright.
    let (eye, target) = (DVec3::new(1e-3, 5e-4, 0.008), DVec3::new(1e-3, 5e-4, 0.0));
    let near = shot(&scene, &WHITE, &view(eye, target, 40.0, 16), 4);
    let (dark, bright) = near.picture.pixels.iter().fold((1.0f32, 0.0f32), |(d, b), p| (d.min(p[1]), b.max(p[1])));
    assert!(dark < 0.25 && bright > 0.75, "from {dark} to {bright}");
}
