//! Triangles that nobody would model, drawn at random: every builder, tier and batch against brute force.

use crate::against_brute_force::check;
use crate::meshes::Soup;
use glam::Vec3;
use proptest::prelude::*;
use proptest::test_runner::RngSeed;

/// Coordinates that coincide, vanish, or differ by many orders of magnitude.
fn coordinate() -> impl Strategy<Value = f32> {
    prop_oneof![
        4 => (-4i8..=4).prop_map(|k| f32::from(k) * 0.25),
        3 => -1.0f32..1.0,
        1 => Just(0.0f32),
        1 => Just(-0.0f32),
        1 => (-30i32..=12, -1.0f32..1.0).prop_map(|(k, x)| x * libm::powf(10.0, k as f32)),
        1 => Just(f32::MIN_POSITIVE),
        1 => Just(1.0f32.next_up()),
    ]
}

fn point() -> impl Strategy<Value = Vec3> {
    [coordinate(), coordinate(), coordinate()].prop_map(Vec3::from_array)
}

fn triangle() -> impl Strategy<Value = [Vec3; 3]> {
    prop_oneof![
        6 => [point(), point(), point()],
        1 => point().prop_map(|p| [p; 3]),
        1 => [point(), point()].prop_map(|[p, q]| [p, q, p]),
        1 => (point(), point(), 0.0f32..1.0).prop_map(|(p, q, s)| [p, q, p.lerp(q, s)]),
    ]
}

proptest! {
    #![proptest_config(ProptestConfig {
        cases: 48,
        rng_seed: RngSeed::Fixed(3),
        failure_persistence: None,
        ..ProptestConfig::default()
    })]

    #[test]
    fn hostile_triangles(triangles in prop::collection::vec(triangle(), 1..70), copies in 1usize..3) {
        check("hostile", &Soup(triangles.repeat(copies)), 60);
    }
}
