//! Kiln in f32 against the path tracer in f64, on random scenes: pictures by their means, and each ray by itself.

use crate::common::{add, cube, lambert, mean_and_error, shoot, view};
use crate::double::{Scatter, Triangle, Twin};
use crate::double_lobes::{Rough, Stuff};
use crate::furnaces::Numbers;
use glam::{DAffine3, DQuat, DVec3};
use kiln::formats::scene::{ColorInput, Material, Mesh, MetalRough, ScalarInput, Surface, Volume};
use kiln::integrate::{PathEvent, View, replay};
use kiln::math::statistics::{normal_two_sided, sidak};
use kiln::prepare::{EnvironmentSource, prepare};
use kiln::settings::{PrepareSettings, RenderSettings};
use kiln::{Control, Scene};

const WORLD: f32 = 0.7;

/// A heap of triangles of many sizes and shapes: needles, slivers, specks and large ones, matte and mirrors, some glowing.
fn heap(numbers: &mut Numbers, count: usize) -> (Scene, Vec<Triangle>) {
    let (mut scene, mut triangles) = (Scene::default(), Vec::new());
    for _ in 0..count {
        let size = 10f64.powf(numbers.within(-3.0, 0.3));
        let place = numbers.vector();
        let squeeze = 10f64.powf(numbers.within(-4.0, 0.0));
        let along = numbers.vector();
        let corner = |numbers: &mut Numbers| {
            (place + (along * numbers.within(-1.0, 1.0) + numbers.vector() * squeeze) * size).as_vec3()
        };
        let corners: [glam::Vec3; 3] = std::array::from_fn(|_| corner(numbers));
        let glows = numbers.next() < 0.2;
        let emission = if glows { numbers.within(0.5, 4.0) as f32 } else { 0.0 };
        let color = numbers.within(0.1, 0.95) as f32;
        let mirror = numbers.next() < 0.3;
        let mut material = lambert(color, emission);
        if mirror {
            material.surface = Surface::MetalRough(MetalRough {
                base_color: ColorInput::constant([color; 3]),
                metallic: ScalarInput::constant(1.0),
                roughness: ScalarInput::constant(0.0),
                ..MetalRough::default()
            });
        }
        let positions = corners.map(|c| c.to_array()).to_vec();
        add(
            &mut scene,
            Mesh { positions, triangles: vec![[0, 1, 2]], ..Mesh::default() },
            material,
            DAffine3::IDENTITY,
        );
        let color = f64::from(color);
        triangles.push(Triangle {
            corners: corners.map(|c| c.as_dvec3()),
            scatter: if mirror { Scatter::Mirror(color) } else { Scatter::Matte(color) },
            emission: f64::from(emission),
        });
    }
    (scene, triangles)
}

fn eye(numbers: &mut Numbers) -> View {
    view(numbers.vector().normalize() * 3.0, DVec3::ZERO, 45.0, 12)
}

#[test]
fn means_of_pictures_agree_with_double_precision() {
    const SCENES: usize = 12;
    let level = sidak(1e-3, SCENES);
    let mut numbers = Numbers(11);
    for case in 0..SCENES {
        let (scene, triangles) = heap(&mut numbers, 30);
        let view = eye(&mut numbers);
        let settings = RenderSettings { spp: 64, max_depth: 8, seed: case as u64, ..RenderSettings::default() };
        let world = EnvironmentSource::Constant([WORLD; 3]);
        let (got, error) = mean_and_error(&shoot(&scene, &world, &PrepareSettings::default(), &settings, &view));
        let twin = Twin { triangles, lobes: vec![], world: f64::from(WORLD), depth: settings.max_depth };
        let (expected, its_error) = twin.mean(&view, 40_000, &mut numbers);
        let z = (got - expected) / error.hypot(its_error);
        assert!(normal_two_sided(z.abs()) > level, "case {case}: {got} ± {error}, in f64 {expected} ± {its_error}");
        assert!(error.hypot(its_error) < 0.02 * expected, "too noisy to tell: {error} {its_error}");
    }
}

fn metal_rough(roughness: f64, metallic: f32, color: f64, index: Option<f64>) -> Material {
    let mut material = lambert(0.5, 0.0);
    material.surface = Surface::MetalRough(MetalRough {
        base_color: ColorInput::constant([color as f32; 3]),
        metallic: ScalarInput::constant(metallic),
        roughness: ScalarInput::constant(roughness as f32),
        transmission: ScalarInput::constant(if index.is_some() { 1.0 } else { 0.0 }),
        ior: index.unwrap_or(1.5) as f32,
        volume: index.map(|_| Volume { attenuation_distance: f32::INFINITY, attenuation_color: [1.0; 3] }),
        ..MetalRough::default()
    });
    material
}

/// Boxes of any shape in cells of their own, each of one stuff, among triangles that are matte or glow.
fn boxes(numbers: &mut Numbers, kind: impl Fn(&mut Numbers) -> (Material, Option<Rough>, Scatter)) -> (Scene, Twin) {
    let (mut scene, mut triangles) = heap(numbers, 12);
    let mut lobes = Vec::new();
    for cell in 0..4u32 {
        let (material, lobe, scatter) = kind(numbers);
        let scatter = match scatter {
            Scatter::RoughGlass(_) => Scatter::RoughGlass(lobes.len()),
            Scatter::RoughMetal(_) => Scatter::RoughMetal(lobes.len()),
            other => other,
        };
        lobes.extend(lobe);
        let place = DVec3::new(f64::from(cell % 2) - 0.5, f64::from(cell / 2) - 0.5, numbers.within(-0.5, 0.5)) * 1.4;
        let size = DVec3::new(numbers.within(0.1, 0.6), numbers.within(0.02, 0.6), numbers.within(0.1, 0.6));
        let turn = DQuat::from_axis_angle(numbers.vector().normalize(), numbers.within(0.0, 6.0));
        let transform = DAffine3::from_scale_rotation_translation(size * 0.55, turn, place);
        let mesh = cube(false);
        let corner = |i: u32| transform.transform_point3(glam::Vec3::from(mesh.positions[i as usize]).as_dvec3());
        triangles.extend(mesh.triangles.iter().map(|t| Triangle { corners: t.map(corner), scatter, emission: 0.0 }));
        add(&mut scene, mesh.clone(), material, transform);
    }
    let twin = Twin { triangles, lobes, world: f64::from(WORLD), depth: 24 };
    (scene, twin)
}

/// Renders random boxes of a kind in both; the means may differ by chance, and by `bound` of the value.
fn boxes_agree(seed: u64, bound: f64, kind: impl Fn(&mut Numbers) -> (Material, Option<Rough>, Scatter)) {
    const SCENES: usize = 6;
    let level = sidak(1e-3, SCENES);
    let mut numbers = Numbers(seed);
    for case in 0..SCENES {
        let (scene, twin) = boxes(&mut numbers, &kind);
        let view = eye(&mut numbers);
        let settings =
            RenderSettings { spp: 96, max_depth: twin.depth, seed: case as u64, ..RenderSettings::default() };
        let world = EnvironmentSource::Constant([WORLD; 3]);
        let (got, error) = mean_and_error(&shoot(&scene, &world, &PrepareSettings::default(), &settings, &view));
        let (expected, its_error) = twin.mean(&view, 30_000, &mut numbers);
        let z = ((got - expected).abs() - bound * expected).max(0.0) / error.hypot(its_error);
        assert!(normal_two_sided(z) > level, "case {case}: {got} ± {error}, in f64 {expected} ± {its_error}");
        assert!(error.hypot(its_error) < 0.02 * expected, "too noisy to tell: {error} {its_error}");
    }
}

#[test]
fn smooth_glass_agrees_with_double_precision() {
    boxes_agree(13, 0.0, |numbers| {
        let index = [1.5, 1.33, 2.4, 1.001, numbers.within(1.0, 2.0)][(numbers.next() * 5.0) as usize];
        (metal_rough(0.0, 0.0, 1.0, Some(index)), None, Scatter::Glass(index))
    });
}

/// The renderer's table of what metal reflects is right to 0.01, at each of a few bounces.
#[test]
fn rough_metal_agrees_with_double_precision() {
    boxes_agree(14, 0.01, |numbers| {
        let (roughness, color) = (numbers.within(0.1, 1.0), numbers.within(0.2, 1.0));
        let lobe = Rough::new(roughness * roughness, Stuff::Metal(color));
        (metal_rough(roughness, 1.0, color, None), Some(lobe), Scatter::RoughMetal(0))
    });
}

/// The renderer's table for rough glass is up to 0.05 too high and so makes the lobe too dark, at each of a few encounters.
#[test]
fn rough_glass_agrees_with_double_precision() {
    boxes_agree(15, 0.05, |numbers| {
        let (roughness, index) = (numbers.within(0.2, 1.0), numbers.within(1.1, 2.0));
        let lobe = Rough::new(roughness * roughness, Stuff::Glass(index));
        (metal_rough(roughness, 0.0, 1.0, Some(index)), Some(lobe), Scatter::RoughGlass(0))
    });
}

/// Every ray of many paths, tried against all triangles in f64 from the same origin along the same direction. The bound is
/// that of `kdtree::slab`, 8u of the way and 7u of the triangle, with what f32 origin and direction leave open (1e-6 of
/// all in sight); beyond it the two must agree on what is met and where.
#[test]
fn every_ray_meets_what_double_precision_says() {
    let mut numbers = Numbers(12);
    let (mut rays, mut edges) = (0, 0);
    for case in 0..40u64 {
        let (scene, triangles) = heap(&mut numbers, 60);
        let view = eye(&mut numbers);
        let settings = RenderSettings { max_depth: 8, seed: case, ..RenderSettings::default() };
        let world = EnvironmentSource::Constant([WORLD; 3]);
        let prepared = prepare(scene, &world, &PrepareSettings::default(), &Control::default()).expect("not stopped");
        for sample in 0..288 {
            let trace = replay(&prepared, &view, &settings, [sample % 12, sample / 12 % 12], sample);
            for pair in trace.events.windows(2) {
                let PathEvent::Ray { origin, direction, .. } = &pair[0] else { continue };
                let met = if let PathEvent::Hit { distance, .. } = &pair[1] { Some(*distance) } else { None };
                rays += 1;
                edges += u32::from(!agrees(&triangles, *origin, direction.as_dvec3(), met));
            }
        }
    }
    assert!(rays > 10_000, "{rays}");
    // Rays within rounding of an edge may go either way; there are next to none.
    assert!(edges * 2000 < rays, "{edges} of {rays} rays");
}

/// Whether a reported distance is one at which f64 meets a triangle too, with none clearly before it.
fn agrees(triangles: &[Triangle], origin: DVec3, dir: DVec3, met: Option<f64>) -> bool {
    const BOUND: f64 = 4e-6;
    let mut found = met.is_none();
    for triangle in triangles {
        let Some((t, inside)) = triangle.meet(origin, dir) else { continue };
        // How much of the distance a shift of the ray by the bound may make, on a triangle seen edge-on.
        let slant = 1.0 / (triangle.normal().normalize().dot(dir)).abs().max(1e-9);
        let bound = BOUND * (1.0 + t.abs()) * slant;
        let size = triangle.normal().length().sqrt();
        let clearly_inside = inside * size > 1e3 * BOUND && inside > 1e-3;
        let before = met.is_none_or(|met| t < met - bound);
        if clearly_inside && t > bound && before {
            return false;
        }
        found |= met.is_some_and(|met| (t - met).abs() <= bound);
    }
    found
}
