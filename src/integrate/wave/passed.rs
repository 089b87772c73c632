//! Rays past surfaces that let them pass, where most surfaces do not: traced as if nothing did, and those that then turn out to have met
//! something that lets them pass are traced again, and asked for at every surface on the way.
//!
//! What is found is the same: if the nearest surface of all stops a ray, it is the nearest of those that stop it.

use super::PATHS;
use super::rows::Rows;
use crate::math::Hit;
use crate::prepare::kdtree::{Coherence, HitBatch, KdTree, NO_TRIANGLE, RayBatch};

/// Rows of a ray.
mod ray {
    pub const ORIGIN: usize = 0;
    pub const DIR: usize = 3;
    pub const T_MAX: usize = 6;
    pub const FLOATS: usize = 7;
    /// Its number in the batch that it comes from.
    pub const NUMBER: usize = 0;
    pub const LEAVES: usize = 1;
    pub const WORDS: usize = 2;
}

/// If one ray in so many has to be traced again, it is cheaper to ask on the way.
const WORTH: usize = 4;
/// So many batches are asked about on the way then, until it is tried again.
const PATIENCE: u8 = 16;

/// Room for rays that are traced again, and what was seen of late. What is found does not depend on it.
pub(super) struct Passed {
    rays: Rows<{ ray::FLOATS }, { ray::WORDS }>,
    hits: Rows<3, 1>,
    /// Batches still to be asked about on the way, of camera rays and of others.
    patience: [u8; 2],
    /// All are.
    always: bool,
}

impl Passed {
    /// `always` where most surfaces may let rays pass.
    pub fn new(always: bool) -> Self {
        let room = if always { 0 } else { PATHS };
        Self { rays: Rows::new(room), hits: Rows::new(room), patience: [0; 2], always }
    }

    /// [`KdTree::closest_batch_where`].
    pub fn closest(
        &mut self,
        tree: &KdTree,
        rays: &RayBatch,
        coherence: Coherence,
        found: &mut HitBatch,
        mut stops: impl FnMut(usize, &Hit) -> bool,
    ) {
        debug_assert!(rays.reaches.is_empty(), "rays that are traced again would not know what they reach");
        let kind = usize::from(coherence == Coherence::Scattered);
        let patience = &mut self.patience[kind];
        if self.always || *patience > 0 {
            *patience = patience.saturating_sub(1);
            asked_on_the_way(tree, rays, &[], coherence, found, &mut stops);
            return;
        }
        tree.closest_batch(rays, coherence, found);
        self.rays.len = 0;
        for i in 0..rays.len() {
            let hit = Hit { t: found.t[i], triangle: found.triangle[i], b1: found.b1[i], b2: found.b2[i] };
            if hit.triangle != NO_TRIANGLE && !stops(i, &hit) {
                self.put(rays, i);
            }
        }
        if self.rays.len == 0 {
            return;
        }
        if self.rays.len * WORTH > rays.len() {
            self.patience[kind] = PATIENCE;
        }
        let numbers = self.rays.words(ray::NUMBER);
        let again = RayBatch {
            origin: self.rays.vectors(ray::ORIGIN),
            dir: self.rays.vectors(ray::DIR),
            t_max: self.rays.floats(ray::T_MAX),
            reaches: &[],
            leaves: self.rays.words(ray::LEAVES),
        };
        self.hits.len = self.rays.len;
        let ([t, b1, b2], [triangle]) = self.hits.all_mut();
        let mut hits = HitBatch { t, b1, b2, triangle };
        asked_on_the_way(tree, &again, numbers, coherence, &mut hits, &mut stops);
        for (k, i) in numbers.iter().map(|i| *i as usize).enumerate() {
            (found.t[i], found.triangle[i]) = (hits.t[k], hits.triangle[k]);
            (found.b1[i], found.b2[i]) = (hits.b1[k], hits.b2[k]);
        }
    }

    fn put(&mut self, rays: &RayBatch, i: usize) {
        let at = self.rays.len;
        let own = rays.ray(i);
        self.rays.set_vector(ray::ORIGIN, at, own.origin);
        self.rays.set_vector(ray::DIR, at, own.dir);
        self.rays.set_float(ray::T_MAX, at, own.t_max);
        self.rays.set_word(ray::NUMBER, at, i as u32);
        self.rays.set_word(ray::LEAVES, at, rays.leaves.get(i).copied().unwrap_or(NO_TRIANGLE));
        self.rays.len += 1;
    }
}

/// The nearest hits that stop rays, of which these are the numbers, or which are numbered as they are. One function, so that it is
/// compiled once.
fn asked_on_the_way(
    tree: &KdTree,
    rays: &RayBatch,
    numbers: &[u32],
    coherence: Coherence,
    found: &mut HitBatch,
    stops: &mut impl FnMut(usize, &Hit) -> bool,
) {
    tree.closest_batch_where(rays, coherence, found, |k, hit| stops(numbers.get(k).map_or(k, |i| *i as usize), hit));
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::prepare::{EnvironmentSource, PreparedScene, prepare};
    use crate::sampling::{hash_combine, unit_float};
    use crate::settings::PrepareSettings;
    use glam::{DAffine3, Vec3};
    use kiln_formats::scene::{Instance, Material, Mesh};
    use kiln_formats::{Control, Scene};

    fn vector(i: u32, k: u32) -> Vec3 {
        let number = |k| unit_float(hash_combine(hash_combine(i, 71), k)) * 2.0 - 1.0;
        Vec3::new(number(k), number(k + 1), number(k + 2))
    }

    /// A heap of triangles.
    fn heap() -> PreparedScene {
        let mut mesh = Mesh::default();
        for i in 0..150 {
            let corners = [0, 3, 6].map(|k| (vector(i, 0) + vector(i, 3 + k) * 0.8).to_array());
            mesh.positions.extend(corners);
            mesh.triangles.push([3 * i, 3 * i + 1, 3 * i + 2]);
        }
        let mut scene = Scene { meshes: vec![mesh], materials: vec![Material::default()], ..Scene::default() };
        scene.instances.push(Instance { name: String::new(), mesh: 0, transform: DAffine3::IDENTITY });
        prepare(scene, &EnvironmentSource::None, &PrepareSettings::default(), &Control::default()).expect("not stopped")
    }

    #[test]
    fn finds_what_is_found_by_asking_on_the_way() {
        let prepared = heap();
        let n = 500;
        let rows =
            |k: u32, scale: f32| [0, 1, 2].map(|axis| (0..n).map(|i| vector(i, k)[axis] * scale).collect::<Vec<_>>());
        let (origins, dirs, endless) = (rows(20, 0.9), rows(30, 1.0), vec![f32::INFINITY; n as usize]);
        let leaves = vec![NO_TRIANGLE; n as usize];
        let rays = RayBatch {
            origin: origins.each_ref().map(Vec::as_slice),
            dir: dirs.each_ref().map(Vec::as_slice),
            t_max: &endless,
            reaches: &[],
            leaves: &leaves,
        };
        let find = |by: &mut dyn FnMut(&mut HitBatch)| {
            let (mut floats, mut triangle) = ([0, 1, 2].map(|_| vec![0.0; n as usize]), vec![0; n as usize]);
            let [t, b1, b2] = floats.each_mut().map(Vec::as_mut_slice);
            by(&mut HitBatch { t, b1, b2, triangle: &mut triangle });
            (floats.map(|row| row.into_iter().map(f32::to_bits).collect::<Vec<_>>()), triangle)
        };
        for (always, open) in [(false, 0.0), (false, 0.05), (false, 0.9), (true, 0.3)] {
            let stops = |i: usize, hit: &Hit| unit_float(hash_combine(i as u32, hit.triangle)) >= open;
            let expected =
                find(&mut |found| prepared.tree.closest_batch_where(&rays, Coherence::Scattered, found, stops));
            let mut passed = Passed::new(always);
            let mut asked = Vec::new();
            for _ in 0..3 {
                let mut count = 0;
                let mut counting = |i: usize, hit: &Hit| {
                    count += 1;
                    stops(i, hit)
                };
                let found = find(&mut |found| {
                    passed.closest(&prepared.tree, &rays, Coherence::Scattered, found, &mut counting)
                });
                assert!(found == expected, "{always} {open}");
                asked.push(count);
            }
            let hits = expected.1.iter().filter(|t| **t != NO_TRIANGLE).count();
            match (always, open) {
                (false, 0.0) => assert_eq!(asked, [hits; 3]),
                // Too many pass: the next batches are asked about on the way.
                (false, 0.9) => assert!(asked[1] != asked[0] && asked[1] == asked[2], "{asked:?}"),
                _ => assert!(asked[0] == asked[1], "{asked:?}"),
            }
        }
    }
}
