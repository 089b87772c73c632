//! The watertight ray-triangle test (Woop, Benthin & Wald, "Watertight Ray/Triangle Intersection", JCGT 2(1), 2013).
//!
//! The triangle is moved so that the ray starts at the origin and sheared so that it runs along the z axis; the ray hits
//! it when the 2D origin lies in its shadow. Two triangles that share an edge shear its corners to the same numbers, so
//! that no ray slips between them as long as the *signs* of the edge functions are exact. The corners are sheared in
//! f32. The edge functions are evaluated in f64, where the products of two f32 are exact and their difference is rounded
//! once: its sign is always right (the paper's f32 with a fall-back to f64 at zero has the same signs), and so the
//! weights and the distance are accurate to a few ulps even on needles seen edge-on. The kd-tree's proof that it loses
//! no hit rests on that last property; see `kdtree::slab`.

use crate::math::{Hit, Ray};
use glam::Vec3;

/// A ray with what the watertight test needs of it.
#[derive(Clone, Copy, Debug)]
pub struct ShearedRay {
    /// Where the ray begins, in the order of `axes`.
    pub origin: [f32; 3],
    /// The axes that play x, y and z: z is the one along which the direction is longest.
    pub axes: [usize; 3],
    /// How far x shifts per unit of z, of magnitude ≤ 1.
    pub shear_x: f32,
    /// How far y shifts per unit of z, of magnitude ≤ 1.
    pub shear_y: f32,
    /// The direction's z.
    pub dir_z: f32,
    /// Its reciprocal.
    pub inv_dir_z: f64,
}

/// The axes that play x, y and z, by the one that plays z. (The last row is nobody's: with four, two bits of a ray's word need no check.)
const AXES: [[usize; 3]; 4] = [[1, 2, 0], [2, 0, 1], [0, 1, 2], [0, 1, 2]];

impl ShearedRay {
    /// Prepares a ray.
    #[inline(always)]
    pub fn new(ray: &Ray) -> Self {
        let d = ray.dir.to_array();
        let a = ray.dir.abs();
        let z = if a.x >= a.y && a.x >= a.z {
            0
        } else if a.y >= a.z {
            1
        } else {
            2
        };
        let [x, y, _] = AXES[z];
        Self::with(ray, z, [d[x] / d[z], d[y] / d[z]])
    }

    /// A ray whose longest axis and shears are known.
    #[inline(always)]
    pub fn with(ray: &Ray, along: usize, [shear_x, shear_y]: [f32; 2]) -> Self {
        let axes = AXES[along];
        let dir_z = ray.dir[along];
        let origin = axes.map(|axis| ray.origin[axis]);
        Self { origin, axes, shear_x, shear_y, dir_z, inv_dir_z: 1.0 / f64::from(dir_z) }
    }

    /// A corner, its coordinates in the order of `axes`, relative to the ray's origin: sheared x and y, and the distance along z. No
    /// fused operations, so that every machine and SIMD tier rounds alike.
    #[inline(always)]
    pub fn shear(&self, [x, y, z]: [f32; 3]) -> [f32; 3] {
        let along = z - self.origin[2];
        let (across_x, across_y) = (x - self.origin[0], y - self.origin[1]);
        [across_x - self.shear_x * along, across_y - self.shear_y * along, along]
    }

    /// Where the line through the ray meets a triangle, before and behind the origin alike.
    #[inline(always)]
    pub fn meet(&self, corners: [[f32; 3]; 3], triangle: u32) -> Option<Hit> {
        self.meet_along(corners.map(|corner| self.axes.map(|axis| corner[axis])), triangle)
    }

    /// [`ShearedRay::meet`] with corners whose coordinates are in the order of `axes`.
    #[inline(always)]
    pub fn meet_along(&self, corners: [[f32; 3]; 3], triangle: u32) -> Option<Hit> {
        let [a, b, c] = corners;
        self.meet_sheared([self.shear(a), self.shear(b), self.shear(c)], triangle)
    }

    /// [`ShearedRay::meet`] with corners that are sheared already.
    #[inline(always)]
    pub fn meet_sheared(&self, corners: [[f32; 3]; 3], triangle: u32) -> Option<Hit> {
        let [[ax, ay, az], [bx, by, bz], [cx, cy, cz]] = corners;
        let exact = |p: f32, q: f32| f64::from(p) * f64::from(q);
        let u = exact(cx, by) - exact(cy, bx);
        let v = exact(ax, cy) - exact(ay, cx);
        let w = exact(bx, ay) - exact(by, ax);
        if ((u < 0.0) | (v < 0.0) | (w < 0.0)) & ((u > 0.0) | (v > 0.0) | (w > 0.0)) {
            return None;
        }
        let det = u + v + w;
        if det == 0.0 {
            return None;
        }
        let inv = 1.0 / det;
        let along = (u * f64::from(az) + v * f64::from(bz) + w * f64::from(cz)) * inv;
        let t = (along * self.inv_dir_z) as f32;
        Some(Hit { t, triangle, b1: (v * inv) as f32, b2: (w * inv) as f32 })
    }
}

/// The nearest hit so far: the test that every traversal, brute force included, applies to a candidate.
#[derive(Clone, Copy, Debug)]
pub struct Nearest {
    /// Distance of the hit, or where the ray ends.
    pub t: f32,
    /// The hit.
    pub hit: Option<Hit>,
}

impl Nearest {
    /// Nothing found yet on a ray.
    pub fn new(ray: &Ray) -> Self {
        Self { t: ray.t_max, hit: None }
    }

    /// Whether a point would be the new nearest: before the ray's end, before the hit so far, or at the same distance on
    /// a triangle of lower number. Not a number is never nearest.
    #[inline(always)]
    pub fn improves(&self, point: &Hit) -> bool {
        point.t > 0.0
            && (point.t < self.t || (point.t == self.t && self.hit.is_some_and(|h| point.triangle < h.triangle)))
    }

    /// Takes a point as the nearest so far.
    #[inline(always)]
    pub fn take(&mut self, point: Hit) {
        self.t = point.t;
        self.hit = Some(point);
    }
}

/// Corners as plain numbers.
pub fn corners_of(vertices: [Vec3; 3]) -> [[f32; 3]; 3] {
    vertices.map(|v| v.to_array())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ray(origin: Vec3, dir: Vec3) -> Ray {
        Ray { origin, dir, t_max: f32::INFINITY }
    }

    #[test]
    fn hits_where_the_algebra_says() {
        let corners = corners_of([Vec3::ZERO, Vec3::X * 4.0, Vec3::Y * 2.0]);
        let hit = ShearedRay::new(&ray(Vec3::new(1.0, 0.5, 3.0), Vec3::NEG_Z * 2.0)).meet(corners, 7).unwrap();
        assert_eq!(hit, Hit { t: 1.5, triangle: 7, b1: 0.25, b2: 0.25 });
        assert!(ShearedRay::new(&ray(Vec3::new(3.0, 1.0, 3.0), Vec3::NEG_Z)).meet(corners, 0).is_none());
        assert!(ShearedRay::new(&ray(Vec3::new(-1.0, 0.0, 0.0), Vec3::X)).meet(corners, 0).is_none(), "edge-on");
    }

    #[test]
    fn an_edge_belongs_to_both_its_triangles_and_a_corner_to_its_whole_fan() {
        let fan: Vec<Vec3> = (0..6)
            .map(|i| {
                let angle = i as f32 * core::f32::consts::FRAC_PI_3 + 0.1;
                Vec3::new(libm::cosf(angle), libm::sinf(angle), 0.1 * (i % 2) as f32)
            })
            .collect();
        for step in 0..1000u32 {
            let from = Vec3::new(step as f32 * 0.004 - 2.0, 1.7, 3.3 - step as f32 * 0.001);
            let edge_point = fan[0] * (step as f32 / 1000.0);
            let sheared = ShearedRay::new(&ray(from, edge_point - from));
            let hits = (0..6).filter(|&i| {
                let corners = corners_of([Vec3::ZERO, fan[i], fan[(i + 1) % 6]]);
                sheared.meet(corners, i as u32).is_some()
            });
            assert!(hits.count() >= 1, "a ray at the shared edge or corner is lost at step {step}");
        }
    }

    #[test]
    fn distances_stay_accurate_on_needles_seen_edge_on() {
        let corners = corners_of([Vec3::ZERO, Vec3::new(100.0, 1e-7, 1e-6), Vec3::new(50.0, 2e-6, 1e-7)]);
        let target = (Vec3::from(corners[0]) + Vec3::from(corners[1]) + Vec3::from(corners[2])) / 3.0;
        let from = target + Vec3::new(10.0, 1e-3, 1e-3);
        let sheared = ShearedRay::new(&ray(from, target - from));
        if let Some(hit) = sheared.meet(corners, 0) {
            // The line may meet the needle anywhere along it; the weights must agree with the distance.
            let by_weights = corners[1][0] * hit.b1 + corners[2][0] * hit.b2;
            let by_distance = from.x + (target - from).x * hit.t;
            assert!((by_weights - by_distance).abs() < 1e-4, "{by_weights} {by_distance}");
        }
    }

    #[test]
    fn ties_go_to_the_lower_number_and_the_end_is_exclusive() {
        let mut nearest = Nearest::new(&Ray { origin: Vec3::ZERO, dir: Vec3::X, t_max: 2.0 });
        let at = |t, triangle| Hit { t, triangle, b1: 0.0, b2: 0.0 };
        assert!(
            !nearest.improves(&at(2.0, 0)) && !nearest.improves(&at(0.0, 0)) && !nearest.improves(&at(f32::NAN, 0))
        );
        nearest.take(at(1.0, 5));
        assert!(nearest.improves(&at(1.0, 4)) && !nearest.improves(&at(1.0, 5)) && !nearest.improves(&at(1.0, 6)));
    }
}
