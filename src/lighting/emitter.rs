//! What light samples choose among the emissive triangles: one of them, or two that are the halves of a quadrilateral.
//!
//! Points on a quadrilateral are made of both numbers at once, without regard to its diagonal: u, v in the unit square are its sides, and
//! which half they lie in follows. Numbers that are well distributed over the square so are over the lamp. With two triangles instead, of
//! which one number chooses, the shadows of rectangular lamps have a quarter to a third more variance
//! (scripts/runs/2026-11-23-quadrilaterals.md).

use super::area;
use super::spherical::{self, SphericalTriangle};
use crate::geometry::Geometry;
use glam::Vec3;

/// Two triangles are taken together if their areas differ by no more than this factor: each half gets half of the points.
const MOST_UNEVEN: f64 = 1.25;
/// And if the cosine between their normals is no less than this.
const LEAST_FLAT: f64 = 0.999;

/// An emissive triangle, or two.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Emitter {
    /// The halves; both the same one where there is one triangle.
    pub halves: [Half; 2],
}

/// A triangle of an emitter.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Half {
    pub triangle: u32,
    /// Its place among all emissive triangles.
    pub row: u32,
    /// Number of the corner that the other half has not.
    pub apex: u8,
}

/// A point on an emitter that is near.
pub(super) struct NearPoint {
    /// Number of the half that it is on.
    pub half: usize,
    /// Its barycentric weights, in the order of [`Half::corners`].
    pub weights: [f32; 3],
    /// Density over solid angle.
    pub pdf: f32,
}

impl Half {
    /// Its corners, the one that the other half has not before the two that they share.
    pub fn corners(&self, geometry: &Geometry) -> [Vec3; 3] {
        let mut corners = geometry.corners(self.triangle);
        corners.rotate_left(usize::from(self.apex));
        corners
    }
}

impl Emitter {
    /// Of one triangle, at this place among all emissive ones.
    pub fn triangle(triangle: u32, row: u32) -> Self {
        Self { halves: [Half { triangle, row, apex: 0 }; 2] }
    }

    /// Of two if they share an edge, seen from the same side, and are about equally large and in one plane.
    pub fn quadrilateral(geometry: &Geometry, [first, second]: [(u32, u32); 2]) -> Option<Self> {
        let [n, m] = [first, second].map(|(triangle, _)| geometry.front_normal(triangle));
        let [one, other] = [n.length(), m.length()];
        let alike = one <= other * MOST_UNEVEN && other <= one * MOST_UNEVEN && n.dot(m) >= LEAST_FLAT * one * other;
        if !alike || one == 0.0 {
            return None;
        }
        let [a, b] = [first, second].map(|(triangle, _)| geometry.corners(triangle));
        let shared = |i: usize, j: usize| a[(i + 1) % 3] == b[(j + 2) % 3] && a[(i + 2) % 3] == b[(j + 1) % 3];
        let (i, j) = (0..9).map(|k| (k / 3, k % 3)).find(|(i, j)| shared(*i, *j))?;
        let half = |(triangle, row): (u32, u32), apex: usize| Half { triangle, row, apex: apex as u8 };
        Some(Self { halves: [half(first, i), half(second, j)] })
    }

    /// Whether there are two halves.
    pub fn is_pair(&self) -> bool {
        self.halves[0].triangle != self.halves[1].triangle
    }

    /// The middle, and the square of the distance from it within which solid angles are sampled.
    pub fn place(&self, geometry: &Geometry) -> (Vec3, f32) {
        let [first, second] = self.halves.map(|half| half.corners(geometry));
        if !self.is_pair() {
            return ((first[0] + first[1] + first[2]) * (1.0 / 3.0), area::near2(first));
        }
        ((first[1] + first[2]) * 0.5, area::near2(first).max(area::near2(second)))
    }

    /// The halves as seen from `point`, if solid angles are to be sampled there.
    fn seen(&self, geometry: &Geometry, point: Vec3) -> Option<[SphericalTriangle; 2]> {
        let (middle, near2) = self.place(geometry);
        if !((middle - point).length_squared() < near2) {
            return None;
        }
        let first = SphericalTriangle::new(self.halves[0].corners(geometry), point)?;
        let pair = self.is_pair();
        Some([first, if pair { SphericalTriangle::new(self.halves[1].corners(geometry), point)? } else { first }])
    }

    /// Density over solid angle with which points are made as seen from `point`; `None` where areas are sampled.
    pub fn near_pdf(&self, geometry: &Geometry, point: Vec3) -> Option<f32> {
        self.seen(geometry, point).map(|seen| (1.0 / self.solid_angle(&seen)) as f32)
    }

    fn solid_angle(&self, [first, second]: &[SphericalTriangle; 2]) -> f64 {
        if self.is_pair() { first.solid_angle + second.solid_angle } else { first.solid_angle }
    }

    /// A point uniform over the solid angle seen from `point`. The outer `None` where areas are to be sampled, the inner one where rounding
    /// leaves no point.
    pub fn sample_near(&self, geometry: &Geometry, point: Vec3, [u, v]: [f32; 2]) -> Option<Option<NearPoint>> {
        let seen = self.seen(geometry, point)?;
        let all = self.solid_angle(&seen);
        let share = (seen[0].solid_angle / all) as f32;
        let (half, u) = match self.is_pair() {
            false => (0, u),
            true if u < share => (0, u / share),
            true => (1, (u - share) / (1.0 - share)),
        };
        let direction = seen[half].sample([u.min(1.0 - f32::EPSILON), v]);
        let weights = direction.and_then(|d| spherical::weights(self.halves[half].corners(geometry), point, d));
        Some(weights.map(|weights| NearPoint { half, weights, pdf: (1.0 / all) as f32 }))
    }

    /// A point uniform over the area of a half, and of a quadrilateral in as many cases on either: the half, and barycentric weights in the
    /// order of [`Half::corners`].
    pub fn sample_area(&self, [u, v]: [f32; 2]) -> (usize, [f32; 3]) {
        if !self.is_pair() {
            return (0, area::uniform([u, v]));
        }
        let half = usize::from(u + v > 1.0);
        let [u, v] = if half == 1 { [1.0 - u, 1.0 - v] } else { [u, v] };
        (half, [1.0 - u - v, u, v])
    }

    /// How often [`Emitter::sample_area`] chooses a half.
    pub fn share(&self) -> f32 {
        if self.is_pair() { 0.5 } else { 1.0 }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::{WorldFrame, world_bounds};
    use crate::math::chi2::chi2_test;
    use crate::math::statistics::sidak;
    use crate::sampling::{hash_combine, unit_float};
    use glam::DAffine3;
    use kiln_formats::Scene;
    use kiln_formats::scene::{Instance, Mesh};

    fn number(i: u32, k: u32) -> f32 {
        unit_float(hash_combine(i, k))
    }

    fn geometry(positions: &[[f32; 3]], triangles: &[[u32; 3]]) -> Geometry {
        let mesh = Mesh { positions: positions.to_vec(), triangles: triangles.to_vec(), ..Mesh::default() };
        let mut scene = Scene { meshes: vec![mesh], ..Scene::default() };
        scene.materials.push(Default::default());
        scene.instances.push(Instance { name: String::new(), mesh: 0, transform: DAffine3::IDENTITY });
        Geometry::new(&scene, &WorldFrame::new(&scene, world_bounds(&scene)))
    }

    /// A square, one corner of which is moved.
    fn square(last: [f32; 3]) -> [[f32; 3]; 4] {
        [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], last]
    }

    #[test]
    fn only_flat_and_even_neighbours_are_taken_together() {
        let pair = |last, triangles: [[u32; 3]; 2]| {
            let geometry = geometry(&square(last), &triangles);
            Emitter::quadrilateral(&geometry, [(0, 0), (1, 1)])
        };
        let good = pair([1.0, 1.0, 0.0], [[0, 1, 2], [3, 2, 1]]).expect("a square");
        assert!(good.is_pair() && good.halves.map(|half| half.apex) == [0, 0]);
        let turned = pair([1.0, 1.0, 0.0], [[1, 2, 0], [2, 1, 3]]).expect("a square");
        assert_eq!(turned.halves.map(|half| half.apex), [2, 2]);
        assert!(pair([1.05, 1.1, 0.01], [[0, 1, 2], [3, 2, 1]]).is_some(), "nearly");
        assert!(pair([1.0, 1.0, 0.0], [[0, 1, 2], [1, 2, 3]]).is_none(), "seen from different sides");
        assert!(pair([1.0, 1.0, 0.3], [[0, 1, 2], [3, 2, 1]]).is_none(), "folded");
        assert!(pair([2.0, 2.0, 0.0], [[0, 1, 2], [3, 2, 1]]).is_none(), "uneven");
        assert!(pair([1.0, 1.0, 0.0], [[0, 1, 2], [0, 1, 2]]).is_none(), "the same twice");
    }

    /// Points are spread evenly over the area, and from near over the solid angle: by cells of the square, in each as many as it has of either.
    #[test]
    fn points_are_uniform() {
        let geometry = geometry(&square([1.0, 1.0, 0.0]), &[[0, 1, 2], [2, 1, 3]]);
        let pair = Emitter::quadrilateral(&geometry, [(0, 0), (1, 1)]).expect("a square");
        let corners = geometry.corners(0);
        let (origin, sides) = (corners[0], [corners[1] - corners[0], corners[2] - corners[0]]);
        let at = |x: f32, y: f32| origin + sides[0] * x + sides[1] * y;
        let up = sides[0].cross(sides[1]).normalize();
        let n = 6;
        let cell = |point: Vec3| {
            let along =
                |side: Vec3| (((point - origin).dot(side) / side.length_squared() * n as f32) as usize).min(n - 1);
            along(sides[1]) * n + along(sides[0])
        };
        let level = sidak(0.01, 3);
        for (k, near) in [None, Some(at(0.3, 0.6) + up * 0.1), Some(at(-0.2, 0.5) + up * 0.3)].into_iter().enumerate() {
            let tries = 40_000u32;
            let (mut found, mut expected) = (vec![0.0; n * n], vec![0.0; n * n]);
            for i in 0..tries {
                let u = [number(i, 3 * k as u32), number(i, 3 * k as u32 + 1)];
                let (half, weights) = match near {
                    None => pair.sample_area(u),
                    Some(point) => {
                        let own = pair.sample_near(&geometry, point, u).expect("near").expect("a point");
                        assert!((own.pdf / pair.near_pdf(&geometry, point).expect("near") - 1.0).abs() < 1e-6);
                        (own.half, own.weights)
                    }
                };
                let [a, b, c] = pair.halves[half].corners(&geometry);
                found[cell(a * weights[0] + b * weights[1] + c * weights[2])] += 1.0;
            }
            let fine = 40;
            for i in 0..(n * fine) * (n * fine) {
                let [x, y] = [i % (n * fine), i / (n * fine)].map(|k| (k as f32 + 0.5) / (n * fine) as f32);
                let point = at(x, y);
                let to = near.map(|near| point - near);
                let share = to.map_or(1.0, |to| f64::from(to.dot(up).abs() / (to.length_squared() * to.length())));
                expected[cell(point)] += share;
            }
            let all: f64 = expected.iter().sum();
            expected.iter_mut().for_each(|e| *e *= f64::from(tries) / all);
            assert!(chi2_test(&found, &expected).p_value > level, "{k}");
        }
    }
}
