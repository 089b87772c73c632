//! Hit for hit, bit for bit.

use crate::batches;
use crate::meshes::{self, Random, Soup};
use glam::Vec3;
use kiln::Control;
use kiln::math::simd::SimdTier;
use kiln::math::triangle::{Nearest, ShearedRay, corners_of};
use kiln::math::{Hit, Ray};
use kiln::prepare::kdtree::{BuildOptions, KdTree, Triangles};
use kiln::settings::KdTreeBuilder;

const BUILDERS: [KdTreeBuilder; 3] = [KdTreeBuilder::Median, KdTreeBuilder::Sampled, KdTreeBuilder::Sah];

fn brute_force(soup: &Soup, ray: &Ray, accept: impl Fn(&Hit) -> bool) -> Option<Hit> {
    let sheared = ShearedRay::new(ray);
    let mut nearest = Nearest::new(ray);
    for triangle in 0..soup.len() as u32 {
        if let Some(hit) = sheared.meet(corners_of(soup.vertices(triangle)), triangle)
            && nearest.improves(&hit)
            && accept(&hit)
        {
            nearest.take(hit);
        }
    }
    nearest.hit
}

/// The bits of a hit.
fn bits(hit: Option<Hit>) -> Option<[u32; 4]> {
    hit.map(|h| [h.t.to_bits(), h.triangle, h.b1.to_bits(), h.b2.to_bits()])
}

/// Lets through what a checkerboard on the triangle lets through: a cut-out.
pub fn cut_out(hit: &Hit) -> bool {
    ((hit.b1 * 8.0) as u32 + (hit.b2 * 8.0) as u32 + hit.triangle).is_multiple_of(2)
}

/// Compares all ways of tracing a ray through a tree with brute force over its triangles.
pub fn check_ray(name: &str, tree: &KdTree, soup: &Soup, ray: &Ray) {
    let expected = bits(brute_force(soup, ray, |_| true));
    let expected_cut = bits(brute_force(soup, ray, cut_out));
    assert_eq!(bits(tree.closest(ray, |_| true)), expected, "{name} {ray:?}");
    assert_eq!(bits(tree.closest(ray, cut_out)), expected_cut, "{name}, cut out, {ray:?}");
    assert_eq!(tree.occluded(ray, |_| true), expected.is_some(), "{name}, occluded, {ray:?}");
    assert_eq!(tree.occluded(ray, cut_out), expected_cut.is_some(), "{name}, occluded, cut out, {ray:?}");
    assert_eq!(bits(tree.closest_by_planes(ray, |_| true)), expected, "{name}, by planes, {ray:?}");
    assert_eq!(bits(tree.closest_by_planes(ray, cut_out)), expected_cut, "{name}, by planes, cut out, {ray:?}");
    assert_eq!(tree.occluded_by_planes(ray, |_| true), expected.is_some(), "{name}, by planes, {ray:?}");
}

/// The 26 directions of a cube's faces, edges and corners.
fn lattice_directions() -> Vec<Vec3> {
    let digits = |i: i32| Vec3::new((i % 3 - 1) as f32, (i / 3 % 3 - 1) as f32, (i / 9 - 1) as f32);
    (0..27).map(digits).filter(|d| *d != Vec3::ZERO).collect()
}

/// Rays of all kinds, many of them at corners and edges and parallel to axes.
pub fn rays(soup: &Soup, count: usize, seed: u64) -> Vec<Ray> {
    let mut random = Random(seed);
    let directions = lattice_directions();
    let ends = [f32::INFINITY, 1e30, 1.0, 0.3];
    let ray = |i: usize| {
        let some_point = |random: &mut Random| {
            let corners = soup.0[random.below(soup.0.len())];
            match random.below(4) {
                0 => corners[random.below(3)],
                1 => corners[0].lerp(corners[1], random.unit()),
                2 => corners[0] + (corners[1] - corners[0]) * 0.3 + (corners[2] - corners[0]) * 0.4,
                _ => random.cube() * 1.5,
            }
        };
        let lattice = random.lattice();
        let origin = match i % 5 {
            0 => random.cube() * 1.5,
            1 => random.cube() * 1000.0,
            2 => some_point(&mut random),
            _ => lattice,
        };
        let dir = match (i / 5) % 4 {
            0 => random.cube(),
            1 => some_point(&mut random) - origin,
            2 => directions[random.below(26)] * if random.below(2) == 0 { 1.0 } else { 7.3 },
            _ => {
                let mut dir = random.cube() * libm::powf(10.0, random.below(9) as f32 - 4.0);
                dir[random.below(3)] *= [0.0, -0.0, 1e-30, -1e-42, 1e-9][random.below(5)];
                dir
            }
        };
        let dir = if dir == Vec3::ZERO { Vec3::X } else { dir };
        Ray { origin, dir, t_max: ends[random.below(4)] }
    };
    (0..count).map(ray).collect()
}

pub fn check(name: &str, soup: &Soup, ray_count: usize) {
    for builder in BUILDERS {
        for simd in SimdTier::ALL.into_iter().filter(|&tier| tier <= SimdTier::detect()) {
            let options = BuildOptions { builder, seed: 5, simd, ..BuildOptions::default() };
            let tree = KdTree::build(soup, &options, &Control::default()).unwrap();
            let name = format!("{name}, {builder:?}, {simd}");
            tree.validate(soup).unwrap_or_else(|e| panic!("{name}: {e}"));
            let rays = rays(soup, ray_count, 17);
            for ray in &rays {
                check_ray(&name, &tree, soup, ray);
            }
            batches::check(&name, &tree, &rays, cut_out);
        }
    }
}

#[test]
fn random_soups() {
    check("one triangle", &meshes::random_soup(1, 1.0, 1), 400);
    check("few", &meshes::random_soup(30, 0.5, 2), 1000);
    check("small triangles", &meshes::random_soup(3000, 0.05, 3), 1000);
    check("large triangles", &meshes::random_soup(500, 1.0, 4), 1000);
}

#[test]
fn closed_meshes() {
    check("sphere", &meshes::sphere(4).soup(1.0, Vec3::ZERO), 1000);
    check("torus", &meshes::torus(60, 30).soup(1.0, Vec3::ZERO), 1000);
    check("small far torus", &meshes::torus(40, 20).soup(1e-3, Vec3::new(1.0, -0.5, 0.25)), 1000);
}

#[test]
fn coincident_axis_parallel_and_degenerate_triangles() {
    check("lattice", &meshes::lattice_soup(400, 5), 2000);
    check("coplanar", &meshes::coplanar(24), 1000);
    check("collinear", &meshes::collinear(500, 6), 500);
    check("identical", &meshes::identical(700), 300);
}

#[test]
fn hair_and_mixed_sizes() {
    check("hair", &meshes::hair(800, 7), 1000);
    check("all sizes", &meshes::all_sizes(1500, 8), 1500);
}

#[test]
fn many_random_scenes() {
    for seed in 0..150u64 {
        let mut random = Random(seed ^ 0xabc);
        let n = 1 + random.below(120);
        let soup = match random.below(3) {
            0 => meshes::random_soup(n, libm::powf(2.0, -(random.below(8) as f32)), seed),
            1 => meshes::lattice_soup(n, seed),
            _ => meshes::all_sizes(n, seed),
        };
        check(&format!("scene {seed}"), &soup, 100);
    }
}

#[test]
fn an_empty_tree_is_missed() {
    let tree = KdTree::build(&Soup(Vec::new()), &BuildOptions::default(), &Control::default()).unwrap();
    tree.validate(&Soup(Vec::new())).unwrap();
    let ray = Ray { origin: Vec3::ZERO, dir: Vec3::X, t_max: f32::INFINITY };
    assert!(tree.closest(&ray, |_| true).is_none() && !tree.occluded(&ray, |_| true));
}
