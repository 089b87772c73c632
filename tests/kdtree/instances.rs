//! Trees of instances find what brute force finds on the placed triangles, hit for hit and bit for bit.

use crate::against_brute_force::{check_ray, cut_out, rays};
use crate::batches;
use crate::meshes::{self, Random, Soup};
use glam::{DAffine3, DMat3, DVec3, Vec3};
use kiln::Control;
use kiln::math::simd::SimdTier;
use kiln::math::{Placement, Ray};
use kiln::prepare::kdtree::{BuildOptions, Instanced, KdTree, Placed, Triangles};
use kiln::settings::KdTreeBuilder;

/// Triangles in the common frame with numbers of their own.
struct Own {
    soup: Soup,
    numbers: Vec<u32>,
}

impl Triangles for Own {
    fn len(&self) -> usize {
        self.soup.len()
    }

    fn vertices(&self, triangle: u32) -> [Vec3; 3] {
        self.soup.vertices(triangle)
    }

    fn number(&self, triangle: u32) -> u32 {
        self.numbers[triangle as usize]
    }
}

/// Meshes, where they are placed, and all that as one soup.
struct World {
    meshes: Vec<Soup>,
    placed: Vec<Placed>,
    own: Own,
    all: Soup,
}

impl World {
    fn new(meshes: Vec<Soup>) -> Self {
        let own = Own { soup: Soup(Vec::new()), numbers: Vec::new() };
        Self { meshes, placed: Vec::new(), own, all: Soup(Vec::new()) }
    }

    fn place(&mut self, mesh: usize, map: &DAffine3) {
        let placement = Placement::new(map);
        let corners = |t: &[Vec3; 3]| t.map(|corner| placement.point(corner.to_array()));
        let placed: Vec<[Vec3; 3]> = self.meshes[mesh].0.iter().map(corners).collect();
        let lo = placed.as_flattened().iter().fold(Vec3::INFINITY, |lo, p| lo.min(*p));
        let hi = placed.as_flattened().iter().fold(Vec3::NEG_INFINITY, |hi, p| hi.max(*p));
        let first = self.all.len() as u32;
        self.placed.push(Placed { mesh: mesh as u32, placement, first, bounds: (lo, hi) });
        self.all.0.extend(placed);
    }

    fn add(&mut self, soup: Soup) {
        let first = self.all.len() as u32;
        self.own.numbers.extend(first..first + soup.len() as u32);
        self.all.0.extend(soup.0.iter().copied());
        self.own.soup.0.extend(soup.0);
    }

    fn check(&self, name: &str, ray_count: usize) {
        let scene = Instanced { meshes: &self.meshes, placed: &self.placed, own: &self.own };
        let rays = rays(&self.all, ray_count, 29);
        for builder in [KdTreeBuilder::Sampled, KdTreeBuilder::Sah] {
            for simd in SimdTier::ALL.into_iter().filter(|&tier| tier <= SimdTier::detect()) {
                let options = BuildOptions { builder, seed: 5, simd, ..BuildOptions::default() };
                let tree = KdTree::build_instances(&scene, &options, &Control::default()).unwrap();
                let name = format!("{name}, {builder:?}, {simd}");
                tree.validate_instances(&scene).unwrap_or_else(|e| panic!("{name}: {e}"));
                assert_eq!(tree.statistics().triangles, self.all.len() as u64);
                for ray in &rays {
                    check_ray(&name, &tree, &self.all, ray);
                }
                batches::check(&name, &tree, &rays, cut_out);
            }
        }
    }
}

/// A map that turns, stretches, shears and perhaps mirrors, then moves.
fn some_map(random: &mut Random, size: f64) -> DAffine3 {
    let matrix = loop {
        let column = |random: &mut Random| random.cube().as_dvec3();
        let matrix = DMat3::from_cols(column(random), column(random), column(random));
        if matrix.determinant().abs() > 0.05 {
            break matrix;
        }
    };
    DAffine3 { matrix3: matrix * size, translation: random.cube().as_dvec3() }
}

#[test]
fn placed_bodies() {
    let mut random = Random(11);
    let mut world =
        World::new(vec![meshes::sphere(3).soup(1.0, Vec3::ZERO), meshes::torus(24, 12).soup(1.0, Vec3::ZERO)]);
    for k in 0..12 {
        let map = some_map(&mut random, [0.5, 0.1, 0.02][k % 3]);
        world.place(k % 2, &map);
        if k == 5 {
            world.add(meshes::random_soup(40, 0.3, 3));
        }
    }
    world.check("bodies", 1500);
}

#[test]
fn meshes_of_unusual_scale_and_place() {
    let mut random = Random(12);
    let far = Vec3::new(300.0, -20.0, 1000.0);
    let mut world = World::new(vec![
        meshes::random_soup(60, 0.5, 1).scaled(1e-5),
        meshes::random_soup(60, 0.5, 2).scaled(3e5),
        meshes::sphere(2).soup(1.0, far),
        meshes::coplanar(6),
    ]);
    for k in 0..8 {
        let map = some_map(&mut random, 0.4);
        let scale = [1e5, 1.0 / 3e5, 1.0, 1.0][k % 4];
        let centre = if k % 4 == 2 { far.as_dvec3() } else { DVec3::ZERO };
        let to_origin = DAffine3::from_scale(DVec3::splat(scale)) * DAffine3::from_translation(-centre);
        world.place(k % 4, &(map * to_origin));
    }
    world.check("scales", 1000);
}

/// Placed corners are rounded to f32: here by up to a hundredth of the mesh's size, so that triangles stick out of the cells that hold
/// them in the mesh's coordinates.
#[test]
fn minute_placements_beside_the_origin() {
    let mut random = Random(13);
    let mut world = World::new(vec![meshes::sphere(2).soup(1.0, Vec3::ZERO), meshes::random_soup(40, 0.5, 4)]);
    for k in 0..12 {
        let map = some_map(&mut random, [1e-4, 1e-5, 3e-6][k % 3]);
        let place = DVec3::new(0.9, -0.8, 0.7) + random.cube().as_dvec3() * 1e-4;
        world.place(k % 2, &DAffine3 { translation: place, ..map });
    }
    let scene = Instanced { meshes: &world.meshes, placed: &world.placed, own: &world.own };
    let aimed = |_| {
        let at = world.all.0[random.below(world.all.len())][random.below(3)];
        let origin = at + random.cube();
        Ray { origin, dir: at - origin, t_max: f32::INFINITY }
    };
    let rays: Vec<Ray> = (0..4000).map(aimed).collect();
    for simd in SimdTier::ALL.into_iter().filter(|&tier| tier <= SimdTier::detect()) {
        let options = BuildOptions { builder: KdTreeBuilder::Sah, simd, ..BuildOptions::default() };
        let tree = KdTree::build_instances(&scene, &options, &Control::default()).unwrap();
        rays.iter().for_each(|ray| check_ray("minute", &tree, &world.all, ray));
    }
}

#[test]
fn placements_upon_each_other_and_flat_ones() {
    let mut world = World::new(vec![meshes::lattice_soup(80, 4), meshes::hair(60, 5)]);
    let quarter_turn = DMat3::from_cols(DVec3::Y, DVec3::NEG_X, DVec3::Z);
    let same = DAffine3::IDENTITY;
    let turned = DAffine3 { matrix3: quarter_turn, translation: DVec3::ZERO };
    let mirrored = DAffine3::from_scale(DVec3::new(-1.0, 1.0, 1.0));
    let flat = DAffine3::from_scale(DVec3::new(1.0, 1e-3, 1.0));
    for map in [same, turned, same, mirrored, flat] {
        world.place(0, &map);
        world.place(1, &map);
    }
    world.add(meshes::lattice_soup(30, 9));
    world.check("coincident", 1500);
}

#[test]
fn many_random_worlds() {
    for seed in 0..40u64 {
        let mut random = Random(seed ^ 0x51);
        let soup = |k: usize| {
            let n = 1 + k * 7;
            if k.is_multiple_of(2) { meshes::random_soup(n, 0.4, seed) } else { meshes::lattice_soup(n, seed) }
        };
        let mut world = World::new(vec![soup(random.below(12)), soup(random.below(12))]);
        for k in 0..2 + random.below(40) {
            let size = libm::pow(10.0, -2.5 * f64::from(random.unit()));
            let map = some_map(&mut random, size);
            world.place(k % 2, &map);
        }
        world.check(&format!("world {seed}"), 80);
    }
}
