//! Rays do not meet the triangle that they leave, without being told which one that is.

use super::vertex::Place;
use crate::math::Ray;
use crate::prepare::{EnvironmentSource, PreparedScene, prepare};
use crate::settings::PrepareSettings;
use glam::{DAffine3, Vec3};
use kiln_formats::scene::{Instance, Material, Mesh};
use kiln_formats::{Control, Scene};

/// Numbers in [0, 1), the same ones in each run.
struct Random(u32);

impl Random {
    fn unit(&mut self) -> f32 {
        self.0 = self.0.wrapping_mul(747_796_405).wrapping_add(2_891_336_453);
        let word = ((self.0 >> ((self.0 >> 28) + 4)) ^ self.0).wrapping_mul(277_803_737);
        (((word >> 22) ^ word) >> 8) as f32 / 16_777_216.0
    }

    fn cube(&mut self) -> Vec3 {
        Vec3::new(self.unit(), self.unit(), self.unit()) * 2.0 - 1.0
    }

    /// 10^-x for x up to `most`.
    fn tiny(&mut self, most: f32) -> f32 {
        libm::powf(10.0, -most * self.unit())
    }
}

/// Triangles of all sizes and shapes, some along the axes, all over the world.
fn heap(count: usize) -> PreparedScene {
    let mut random = Random(7);
    let (mut positions, mut triangles) = (Vec::new(), Vec::new());
    for k in 0..count as u32 {
        let (middle, size, thin) = (random.cube(), random.tiny(4.0), random.tiny(5.0));
        let mut edges = [random.cube() * size, random.cube() * (size * thin)];
        if k % 3 == 0 {
            edges.iter_mut().for_each(|edge| edge[k as usize / 3 % 3] = 0.0);
        }
        positions.extend([middle, middle + edges[0], middle + edges[1]].map(|p| p.to_array()));
        triangles.push([3 * k, 3 * k + 1, 3 * k + 2]);
    }
    let mut scene = Scene::default();
    scene.meshes.push(Mesh { positions, triangles, ..Mesh::default() });
    scene.materials.push(Material::default());
    scene.instances.push(Instance { name: String::new(), mesh: 0, transform: DAffine3::IDENTITY });
    scene.validate().expect("a valid scene");
    prepare(scene, &EnvironmentSource::None, &PrepareSettings::default(), &Control::default()).expect("not stopped")
}

#[test]
fn a_ray_does_not_meet_the_triangle_that_it_leaves() {
    let prepared = heap(600);
    let mut random = Random(1);
    let (mut left, mut met) = (0, 0);
    for _ in 0..400_000 {
        let triangle = (random.unit() * prepared.geometry.len() as f32) as u32;
        let [a, b, c] = prepared.geometry.corners(triangle);
        let (u, v) = (random.unit(), random.unit());
        let aim = a.lerp(b, u).lerp(c, 1.0 - v.sqrt());
        let origin = aim + random.cube() * random.tiny(5.0);
        let ray = Ray { origin, dir: (aim - origin).normalize_or(Vec3::X), t_max: f32::INFINITY };
        let own = |r: &Ray| prepared.tree.closest(r, |h| h.triangle == triangle);
        let Some(hit) = own(&ray) else { continue };
        let Some(place) = Place::new(&prepared, &hit, ray.dir) else { continue };
        let normal = prepared.geometry.unit_normal(triangle);
        let along = normal.cross(random.cube()).normalize_or(normal.any_orthonormal_vector());
        let side = if random.unit() < 0.5 { normal } else { -normal };
        let dir = (along + side * random.tiny(9.0)).normalize();
        left += 1;
        met += u32::from(own(&Ray { origin: place.spawn(dir), dir, t_max: f32::INFINITY }).is_some());
    }
    assert!(left > 200_000, "only {left} rays");
    assert_eq!(met, 0, "of {left} rays so many meet the triangle that they leave");
}
