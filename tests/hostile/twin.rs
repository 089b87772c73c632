//! Kiln in f32 against the path tracer in f64, on random scenes: pictures by their means, and each ray by itself.

use crate::common::{add, lambert, mean_and_error, shoot, view};
use crate::double::{Scatter, Triangle, Twin};
use crate::furnaces::Numbers;
use glam::{DAffine3, DVec3};
use kiln::formats::scene::{ColorInput, Mesh, MetalRough, ScalarInput, Surface};
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
        let twin = Twin { triangles, world: f64::from(WORLD), depth: settings.max_depth };
        let (expected, its_error) = twin.mean(&view, 40_000, &mut numbers);
        let z = (got - expected) / error.hypot(its_error);
        assert!(normal_two_sided(z.abs()) > level, "case {case}: {got} ± {error}, in f64 {expected} ± {its_error}");
        assert!(error.hypot(its_error) < 0.02 * expected, "too noisy to tell: {error} {its_error}");
    }
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
