//! No ray from inside a closed mesh gets out, not even at its corners and edges.

use crate::meshes::{self, Mesh, Random};
use glam::Vec3;
use kiln::Control;
use kiln::math::Ray;
use kiln::prepare::kdtree::{BuildOptions, KdTree};

/// Shoots rays from `inside` at corners and edges; counts those that hit nothing.
fn leaks(mesh: &Mesh, scale: f32, offset: Vec3, inside: impl Fn(&mut Random) -> Vec3, count: usize) -> usize {
    let soup = mesh.soup(scale, offset);
    let tree = KdTree::build(&soup, &BuildOptions::default(), &Control::default()).unwrap();
    let mut random = Random(99);
    let escapes = |i: &usize| {
        let origin = inside(&mut random) * scale + offset;
        let corners = soup.0[random.below(soup.0.len())];
        let target = if i.is_multiple_of(2) { corners[i % 3] } else { corners[0].lerp(corners[1], random.unit()) };
        let ray = Ray { origin, dir: target - origin, t_max: f32::INFINITY };
        tree.closest(&ray, |_| true).is_none() || !tree.occluded(&ray, |_| true)
    };
    (0..count).filter(escapes).count()
}

#[test]
fn spheres_and_tori_of_any_size_are_tight() {
    let sphere = meshes::sphere(5);
    let torus = meshes::torus(150, 80);
    let in_sphere = |random: &mut Random| random.cube() * 0.5;
    // The torus' core circle, so that rays cross the tube at all angles.
    let in_torus = |random: &mut Random| {
        let angle = random.unit() * core::f32::consts::TAU;
        Vec3::new(libm::cosf(angle), 0.0, libm::sinf(angle)) + random.cube() * 0.1
    };
    let places = [
        (1.0, Vec3::ZERO),
        (1e-6, Vec3::ZERO),
        (1e6, Vec3::ZERO),
        (1.0, Vec3::new(100.0, -30.0, 7.0)),
        (1000.0, Vec3::new(1.0, 20000.0, -300.0)),
    ];
    for (scale, offset) in places {
        assert_eq!(leaks(&sphere, scale, offset, in_sphere, 100_000), 0, "sphere {scale} {offset}");
        assert_eq!(leaks(&torus, scale, offset, in_torus, 100_000), 0, "torus {scale} {offset}");
    }
}
