//! Each map sends equal areas of the square to equal expected counts.

use super::chi2::chi2_test;
use super::statistics::sidak;
use super::warp::*;
use glam::Vec3;
use std::f32::consts::{PI, TAU};

/// Side of the square number of points per test.
const SIDE: usize = 700;
/// Cells along each axis of the range.
const CELLS: usize = 16;
/// Calls of `assert_uniform` in all.
const TESTS: usize = 7;

/// Tests that `cell` is uniform over [0, 1]² when its argument is.
fn assert_uniform(name: &str, cell: impl Fn([f32; 2]) -> [f32; 2]) {
    let mut state = 1u64;
    let mut next = || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 40) as f32 / 16_777_216.0
    };
    let mut observed = vec![0.0; CELLS * CELLS];
    for _ in 0..SIDE * SIDE {
        let [x, y] = cell([next(), next()]);
        assert!((-1e-5..=1.000_01).contains(&x) && (-1e-5..=1.000_01).contains(&y), "{name}: {x} {y}");
        let index = |v: f32| ((v.max(0.0) * CELLS as f32) as usize).min(CELLS - 1);
        observed[index(x) * CELLS + index(y)] += 1.0;
    }
    let expected = vec![(SIDE * SIDE) as f64 / (CELLS * CELLS) as f64; CELLS * CELLS];
    let test = chi2_test(&observed, &expected);
    assert!(test.p_value > sidak(0.01, TESTS), "{name}: {test:?}");
}

/// Azimuth of (x, y) in turns.
fn turn(x: f32, y: f32) -> f32 {
    let phi = libm::atan2f(y, x);
    if phi < 0.0 { phi / TAU + 1.0 } else { phi / TAU }
}

fn unit(v: Vec3) -> Vec3 {
    assert!((v.length() - 1.0).abs() < 1e-6, "{v} is not of unit length");
    v
}

#[test]
fn sphere_and_hemisphere_are_uniform_over_solid_angle() {
    assert_uniform("sphere", |u| {
        let v = unit(uniform_sphere(u));
        [0.5 + 0.5 * v.z, turn(v.x, v.y)]
    });
    assert_uniform("hemisphere", |u| {
        let v = unit(uniform_hemisphere(u));
        [v.z, turn(v.x, v.y)]
    });
    assert!((UNIFORM_SPHERE_PDF * 4.0 * PI - 1.0).abs() < 1e-6);
    assert!((UNIFORM_HEMISPHERE_PDF * 2.0 * PI - 1.0).abs() < 1e-6);
}

#[test]
fn cosine_hemisphere_is_uniform_over_projected_solid_angle() {
    assert_uniform("cosine", |u| {
        let v = unit(cosine_hemisphere(u));
        // The distribution function of cos θ with density 2 cos θ is cos² θ.
        [v.z * v.z, turn(v.x, v.y)]
    });
    assert!((cosine_hemisphere_pdf(0.5) - 0.5 / PI).abs() < 1e-7);
    assert_eq!(cosine_hemisphere_pdf(-0.5), 0.0);
}

#[test]
fn discs_are_uniform_over_area() {
    for (name, map) in [("concentric", concentric_disc as fn([f32; 2]) -> [f32; 2]), ("polar", uniform_disc)] {
        assert_uniform(name, |u| {
            let [x, y] = map(u);
            [x * x + y * y, turn(x, y)]
        });
    }
    assert_eq!(concentric_disc([0.5, 0.5]), [0.0, 0.0]);
}

#[test]
fn triangles_are_uniform_over_area() {
    assert_uniform("triangle", |u| {
        let [b1, b2] = uniform_triangle(u);
        let b0 = 1.0 - b1 - b2;
        assert!(b0 >= -1e-6 && b1 >= 0.0 && b2 >= 0.0);
        // The square-root map of a triangle, backwards.
        let rest = 1.0 - b0;
        [rest * rest, if rest > 0.0 { b1 / rest } else { 0.0 }]
    });
}

#[test]
fn cones_are_uniform_over_solid_angle_however_narrow() {
    for versine in [0.4f32, 1e-9] {
        assert_uniform("cone", |u| {
            let v = unit(uniform_cone(u, versine));
            // sin² = v (2 − v), so v = sin² / (1 + cos): what 1 − cos would be without rounding.
            let sin2 = v.x * v.x + v.y * v.y;
            [sin2 / (1.0 + v.z) / versine, turn(v.x, v.y)]
        });
        assert!((uniform_cone_pdf(versine) * TAU * versine - 1.0).abs() < 1e-6);
    }
}

#[test]
fn remaps_never_reach_one() {
    assert!(into_unit(1.0) < 1.0 && into_unit(f32::INFINITY) < 1.0);
    assert_eq!((into_unit(f32::NAN), into_unit(-0.5), into_unit(0.25)), (0.0, 0.0, 0.25));
}
