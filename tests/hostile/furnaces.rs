//! Closed boxes of any size, place and shape that glow: all light in them is Le · (1 + a + a² + …).

use crate::common::{add, cube, lambert, mean_and_error, shoot};
use glam::{DAffine3, DMat3, DVec3};
use kiln::Scene;
use kiln::formats::scene::{Camera, ColorInput, MetalRough, ScalarInput, Surface};
use kiln::integrate::View;
use kiln::math::statistics::{normal_two_sided, sidak};
use kiln::prepare::EnvironmentSource;
use kiln::settings::{PrepareSettings, RenderSettings};

const CASES: usize = 48;
const DEPTH: u32 = 24;

/// Numbers in [0, 1), the same every time (Steele, Lea & Flood 2014, SplitMix64).
pub struct Numbers(pub u64);

impl Numbers {
    pub fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let z = (self.0 ^ self.0 >> 30).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let z = (z ^ z >> 27).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ z >> 31) >> 11) as f64 / (1u64 << 53) as f64
    }

    pub fn within(&mut self, lo: f64, hi: f64) -> f64 {
        lo + (hi - lo) * self.next()
    }

    /// In the cube [−1, 1]³.
    pub fn vector(&mut self) -> DVec3 {
        DVec3::from_array(std::array::from_fn(|_| self.within(-1.0, 1.0)))
    }
}

/// A box of a size over 24 orders of magnitude, sheared and stretched, up to a thousand sizes from the origin, and a
/// camera in it.
fn box_and_view(numbers: &mut Numbers) -> (DAffine3, View) {
    let size = 10f64.powf(numbers.within(-12.0, 12.0));
    let axes = DMat3::from_cols(
        DVec3::new(numbers.within(0.3, 3.0), 0.3 * numbers.next(), 0.0),
        DVec3::new(0.0, -numbers.within(0.3, 3.0), 0.3 * numbers.next()),
        DVec3::new(0.3 * numbers.next(), 0.0, numbers.within(0.3, 3.0)),
    ) * size;
    let place = numbers.vector() * size * 10f64.powf(numbers.within(-3.0, 3.0));
    let transform = DAffine3::from_mat3_translation(axes, place);
    let (eye, target) = (numbers.vector() * 0.9, numbers.vector());
    let [eye, target] = [eye, target].map(|p| transform.transform_point3(p));
    let forward = (target - eye).normalize();
    let up = forward.any_orthonormal_vector();
    let camera = Camera::perspective(eye, forward, up, 1.0, 1.0);
    (transform, View { camera, width: 8, height: 8, show_environment: true })
}

#[test]
fn closed_boxes_of_any_shape_hold_the_light_that_the_series_says() {
    let mut numbers = Numbers(5);
    let level = sidak(1e-3, CASES);
    for case in 0..CASES {
        let (transform, view) = box_and_view(&mut numbers);
        let albedo = numbers.within(0.0, 0.95) as f32;
        let mut scene = Scene::default();
        add(&mut scene, cube(true), lambert(albedo, 1.0), transform);
        let settings = RenderSettings { spp: 32, max_depth: DEPTH, seed: case as u64, ..RenderSettings::default() };
        let rendered = shoot(&scene, &EnvironmentSource::None, &PrepareSettings::default(), &settings, &view);
        let (mean, error) = mean_and_error(&rendered);
        let expected: f64 = (0..=DEPTH).map(|k| f64::from(albedo).powi(k as i32)).sum();
        let z = (mean - expected).abs().max(1e-5 * expected) / error.max(1e-5 * expected);
        let off = (mean - expected).abs() > 1e-5 * expected && normal_two_sided(z) < level;
        assert!(!off, "case {case}, albedo {albedo}, {transform}: {mean} ± {error}, expected {expected}");
    }
}

/// White metals and white plastics of any roughness reflect all, or lose a little among facets; the tables of rough albedos
/// may be 0.005 too low, at every bounce.
#[test]
fn no_material_makes_a_closed_box_brighter_than_white_walls_would() {
    let mut numbers = Numbers(6);
    let level = sidak(1e-3, CASES);
    for case in 0..CASES {
        let (transform, view) = box_and_view(&mut numbers);
        let mut material = lambert(0.0, 1.0);
        let roughness = (numbers.within(-0.3, 1.3) as f32).clamp(0.0, 1.0);
        let metal = numbers.next() < 0.5;
        material.surface = Surface::MetalRough(MetalRough {
            base_color: ColorInput::constant([1.0; 3]),
            metallic: ScalarInput::constant(if metal { 1.0 } else { 0.0 }),
            roughness: ScalarInput::constant(roughness),
            ..MetalRough::default()
        });
        let mut scene = Scene::default();
        add(&mut scene, cube(true), material, transform);
        let settings = RenderSettings { spp: 32, max_depth: DEPTH, seed: case as u64, ..RenderSettings::default() };
        let rendered = shoot(&scene, &EnvironmentSource::None, &PrepareSettings::default(), &settings, &view);
        let (mean, error) = mean_and_error(&rendered);
        let gain: f64 = if metal && roughness == 0.0 { 1.0 + 1e-6 } else { 1.005 };
        let most: f64 = (0..=DEPTH).map(|k| gain.powi(k as i32)).sum();
        let above = (mean - most) / error.max(1e-9);
        assert!(above <= 0.0 || normal_two_sided(above) > level, "case {case}: {mean} ± {error}, at most {most}");
        if metal && roughness == 0.0 {
            assert!((mean - most).abs() < 1e-4 * most, "case {case}: {mean} among perfect mirrors, expected {most}");
        }
    }
}
