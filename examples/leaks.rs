//! Rays from inside closed meshes, aimed at their corners and edges: how many get out.
//!
//!     cargo run --release --example leaks -- [MILLIONS OF RAYS]
//!
//! A sphere and a torus of 82 000 and 96 000 triangles, at scales from 1e-6 to 1e6 and offsets to 1e6 (in units of the mesh, as
//! far as f32 can tell its corners apart), closest hit in batches. The tests do the same with fewer rays.

#![allow(clippy::disallowed_methods)]

#[path = "../tests/kdtree/meshes.rs"]
#[allow(dead_code)]
mod meshes;

use glam::Vec3;
use kiln::Control;
use kiln::prepare::kdtree::{BuildOptions, Coherence, HitBatch, KdTree, NO_TRIANGLE, RayBatch};
use meshes::{Mesh, Random};
use rayon::prelude::*;

const BATCH: usize = 1024;

/// A body, by name, and where rays in it begin.
type Body<'a> = (&'a str, Mesh, &'a (dyn Fn(&mut Random) -> Vec3 + Sync));

/// A batch of rays from inside at corners (every other one) and edges; how many hit nothing.
fn leaks(tree: &KdTree, soup: &meshes::Soup, seed: u64, inside: impl Fn(&mut Random) -> Vec3) -> u64 {
    let mut random = Random(seed);
    let mut rows = [[0.0f32; BATCH]; 6];
    for i in 0..BATCH {
        let origin = inside(&mut random);
        let corners = soup.0[random.below(soup.0.len())];
        let target = if i % 2 == 0 { corners[i / 2 % 3] } else { corners[0].lerp(corners[1], random.unit()) };
        for axis in 0..3 {
            rows[axis][i] = origin[axis];
            rows[axis + 3][i] = (target - origin)[axis];
        }
    }
    let [ox, oy, oz, dx, dy, dz] = &rows;
    let t_max = [f32::INFINITY; BATCH];
    let rays = RayBatch { origin: [ox, oy, oz], dir: [dx, dy, dz], t_max: &t_max, reaches: &[], leaves: &[] };
    let (mut t, mut b1, mut b2, mut triangle) = ([0.0; BATCH], [0.0; BATCH], [0.0; BATCH], [0; BATCH]);
    let mut hits = HitBatch { t: &mut t, b1: &mut b1, b2: &mut b2, triangle: &mut triangle };
    tree.closest_batch(&rays, Coherence::Scattered, &mut hits);
    triangle.iter().filter(|id| **id == NO_TRIANGLE).count() as u64
}

fn main() {
    let millions: f64 = std::env::args().nth(1).map_or(1.0, |word| word.parse().expect("a number"));
    let places = [
        (1.0, Vec3::ZERO),
        (1e-6, Vec3::ZERO),
        (1e6, Vec3::ZERO),
        (1.0, Vec3::new(1000.0, -300.0, 70.0)),
        (1000.0, Vec3::new(1.0, 1e6, -300.0)),
    ];
    let in_sphere = |random: &mut Random| random.cube() * 0.5;
    let in_torus = |random: &mut Random| {
        let angle = random.unit() * core::f32::consts::TAU;
        Vec3::new(libm::cosf(angle), 0.0, libm::sinf(angle)) + random.cube() * 0.1
    };
    let bodies: [Body; 2] = [("sphere", meshes::sphere(6), &in_sphere), ("torus", meshes::torus(300, 160), &in_torus)];
    let batches = (millions * 1e6 / (places.len() * bodies.len() * BATCH) as f64).ceil() as u64;
    let (mut rays, mut out) = (0, 0);
    for (name, mesh, inside) in &bodies {
        for (scale, offset) in places {
            let soup = mesh.soup(scale, offset);
            let tree = KdTree::build(&soup, &BuildOptions::default(), &Control::default()).expect("not stopped");
            let batch = |seed: u64| leaks(&tree, &soup, seed << 20, |random| inside(random) * scale + offset);
            let escaped: u64 = (0..batches).into_par_iter().map(batch).sum();
            println!("{name} × {scale} + {offset}: {escaped} of {} rays", batches * BATCH as u64);
            rays += batches * BATCH as u64;
            out += escaped;
        }
    }
    println!("{out} of {rays} rays leak");
}
