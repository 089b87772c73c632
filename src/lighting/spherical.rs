//! Spherical triangles: directions to a triangle, uniform in solid angle.
//!
//! Arvo 1995, "Stratified Sampling of Spherical Triangles", with the area by Van Oosterom & Strackee 1983, which has no
//! cancellation where the angles' sum does, and with sines and cosines of angles in place of the angles (as in Peters 2021,
//! "BRDF Importance Sampling for Polygonal Lights"). Double precision: slivers and triangles on the horizon lose half of
//! the digits.

use glam::{DVec3, Vec3};

/// The solid angles within which this is used: below, directions are as good as parallel, and areas as good as solid angles
/// (pbrt 4ed, 6.5.4). Beyond, the point all but touches the triangle, or is on it: the back of a lamp would be lit by its own
/// front, since rounding decides which side a point is on.
const STABLE: std::ops::Range<f64> = 3e-4..6.22;

/// A triangle seen from a point.
#[derive(Clone, Copy, Debug)]
pub(super) struct SphericalTriangle {
    /// Unit vectors to the corners.
    corners: [DVec3; 3],
    /// Solid angle in steradians.
    pub solid_angle: f64,
}

impl SphericalTriangle {
    /// Of a triangle as seen from `point`; `None` where sampling it by area is the better or the only way.
    pub fn new(corners: [Vec3; 3], point: Vec3) -> Option<Self> {
        let point = point.as_dvec3();
        let mut unit = [DVec3::ZERO; 3];
        for (to, corner) in unit.iter_mut().zip(corners) {
            *to = (corner.as_dvec3() - point).try_normalize()?;
        }
        let [a, b, c] = unit;
        // The volume from edges, which are accurate where the corners are nearly the same direction.
        let volume = a.dot((b - a).cross(c - a)).abs();
        let solid_angle = 2.0 * libm::atan2(volume, 1.0 + a.dot(b) + b.dot(c) + c.dot(a));
        STABLE.contains(&solid_angle).then_some(Self { corners: unit, solid_angle })
    }

    /// A direction, uniform over the solid angle. `None` where rounding leaves none.
    pub fn sample(&self, u: [f32; 2]) -> Option<DVec3> {
        let [a, b, c] = self.corners;
        let cos_c = a.dot(b);
        // The angle at `a`, between the great circles to `b` and to `c`.
        let (to_b, to_c) = (a.cross(b).try_normalize()?, a.cross(c).try_normalize()?);
        let cos_alpha = to_b.dot(to_c).clamp(-1.0, 1.0);
        let sin_alpha = to_b.cross(to_c).length();
        let alpha = libm::atan2(sin_alpha, cos_alpha);
        // A part of the area decides where the opposite edge ends.
        let part = f64::from(u[0]) * self.solid_angle;
        let (s, t) = (libm::sin(part - alpha), libm::cos(part - alpha));
        let (p, q) = (t - cos_alpha, s + sin_alpha * cos_c);
        let below = (q * s + p * t) * sin_alpha;
        let cos_b = if below == 0.0 { 1.0 } else { ((q * t - p * s) * cos_alpha - q) / below };
        let cos_b = cos_b.clamp(-1.0, 1.0);
        // At right angles to `a` even where `c` is all but opposite, as seen from a point on the edge between them.
        let towards_c = to_c.cross(a).try_normalize()?;
        let corner = a * cos_b + towards_c * (1.0 - cos_b * cos_b).max(0.0).sqrt();
        // Uniform in height between there and `b`.
        let z = 1.0 - f64::from(u[1]) * (1.0 - corner.dot(b));
        let across = b.cross(corner).try_normalize()?.cross(b).try_normalize()?;
        let direction = b * z + across * (1.0 - z * z).max(0.0).sqrt();
        direction.is_finite().then_some(direction)
    }
}

/// Barycentric weights of where a direction from `point` meets a triangle's plane, kept inside the triangle; `None` for a
/// direction along the plane.
pub(super) fn weights(corners: [Vec3; 3], point: Vec3, direction: DVec3) -> Option<[f32; 3]> {
    let [a, b, c] = corners.map(|x| x.as_dvec3() - point.as_dvec3());
    let volumes = [direction.dot(b.cross(c)), direction.dot(c.cross(a)), direction.dot(a.cross(b))];
    let sum: f64 = volumes.iter().sum();
    let [wa, wb, _] = volumes.map(|v| (v / sum).clamp(0.0, 1.0) as f32);
    let wb = wb.min(1.0 - wa);
    (sum != 0.0 && wa.is_finite() && wb.is_finite()).then_some([wa, wb, 1.0 - wa - wb])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::chi2::chi2_test;
    use crate::math::statistics::sidak;
    use crate::sampling::{hash_combine, unit_float};

    fn number(i: u32, k: u32) -> f32 {
        unit_float(hash_combine(i, k))
    }

    /// A triangle's corners and a point: plain, close above the middle, beside an edge, a needle, nearly the hemisphere.
    fn cases() -> Vec<([Vec3; 3], Vec3)> {
        let triangle = [Vec3::ZERO, Vec3::X, Vec3::Y];
        let needle = [Vec3::ZERO, Vec3::new(1.0, 1e-3, 0.0), Vec3::new(0.99, 0.0, 1e-3)];
        let far = Vec3::new(1e3, -2e3, 5e2);
        let mut cases = vec![
            (triangle, Vec3::new(0.2, 0.3, 1.0)),
            (triangle, Vec3::new(0.3, 0.3, 1e-2)),
            (triangle, Vec3::new(0.3, 0.3, 3e-2)),
            (triangle, Vec3::new(-1e-3, 0.5, 1e-3)),
            (triangle, Vec3::new(1e-3, 1e-3, -2e-3)),
            (triangle, Vec3::new(0.5, -0.7, 3e-2)),
            (needle, Vec3::new(0.9, 0.02, 0.01)),
            (triangle.map(|c| c * 2048.0 + far), far + Vec3::new(300.0, 400.0, 900.0)),
        ];
        for i in 0..12 {
            let v = |k: u32| Vec3::new(number(i, k), number(i, k + 1), number(i, k + 2)) - 0.5;
            cases.push(([v(0), v(3), v(6)], v(9)));
        }
        cases
    }

    /// Solid angles of the 4ⁿ triangles that halving all edges n times gives, each with the corner weights of its middle.
    fn parts(corners: [DVec3; 3], point: DVec3, n: u32) -> Vec<f64> {
        if n == 0 {
            let [a, b, c] = corners.map(|x| (x - point).normalize());
            let volume = a.dot((b - a).cross(c - a)).abs();
            return vec![2.0 * libm::atan2(volume, 1.0 + a.dot(b) + b.dot(c) + c.dot(a))];
        }
        let [a, b, c] = corners;
        let [ab, bc, ca] = [(a + b) * 0.5, (b + c) * 0.5, (c + a) * 0.5];
        [[a, ab, ca], [ab, b, bc], [ca, bc, c], [bc, ca, ab]].into_iter().flat_map(|t| parts(t, point, n - 1)).collect()
    }

    /// The number of the part, as [`parts`] counts them, that holds barycentric weights.
    fn part_of([a, b, c]: [f64; 3], n: u32) -> usize {
        if n == 0 {
            return 0;
        }
        let size = 1usize << (2 * (n - 1));
        let double = [2.0 * a, 2.0 * b, 2.0 * c];
        let corner = double.iter().position(|w| *w >= 1.0);
        let mut inner = double.map(|w| 1.0 - w);
        if let Some(k) = corner {
            inner = double;
            inner[k] -= 1.0;
        }
        corner.unwrap_or(3) * size + part_of(inner, n - 1)
    }

    #[test]
    fn directions_are_uniform_in_solid_angle() {
        let tries = 40_000u32;
        let cases = cases();
        let level = sidak(1e-3, cases.len());
        let mut tested = 0;
        for (at, (corners, point)) in cases.into_iter().enumerate() {
            let Some(triangle) = SphericalTriangle::new(corners, point) else { continue };
            tested += 1;
            let solid = parts(corners.map(Vec3::as_dvec3), point.as_dvec3(), 3);
            let sum: f64 = solid.iter().sum();
            assert!((sum / triangle.solid_angle - 1.0).abs() < 1e-9, "case {at}: {sum} {}", triangle.solid_angle);
            let mut observed = vec![0.0; solid.len()];
            for i in 0..tries {
                let seed = 1000 * at as u32;
                let u = [number(i, seed + 1), number(i, seed + 2)];
                let direction = triangle.sample(u).expect("a direction");
                let weights = weights(corners, point, direction).expect("a point");
                observed[part_of(weights.map(f64::from), 3)] += 1.0;
            }
            let expected: Vec<f64> = solid.iter().map(|s| s / sum * f64::from(tries)).collect();
            let test = chi2_test(&observed, &expected);
            assert!(test.p_value > level, "case {at}: {test:?}");
        }
        assert!(tested >= 16, "{tested} cases are stable");
    }

    #[test]
    fn what_is_not_stable_is_left_to_areas() {
        let triangle = [Vec3::ZERO, Vec3::X, Vec3::Y];
        for point in
            [Vec3::Z * 1e4, Vec3::ZERO, Vec3::new(0.2, 0.2, 0.0), Vec3::new(2.0, 2.0, 0.0), Vec3::splat(f32::NAN)]
        {
            if let Some(seen) = SphericalTriangle::new(triangle, point) {
                // In its plane and inside: half the sphere, of which every direction is as good.
                assert!((seen.solid_angle - std::f64::consts::TAU).abs() < 1e-6, "{point}: {seen:?}");
            }
        }
    }

    /// The ends of the unit square and triangles at the borders of what is stable give points or none, but no nonsense.
    #[test]
    fn extremes_stay_inside() {
        for i in 0..20_000u32 {
            let v = |k: u32| Vec3::new(number(i, k), number(i, k + 1), number(i, k + 2)) - 0.5;
            let flat = libm::exp2f(-20.0 * number(i, 20));
            let corners = [v(0), v(3), v(6)].map(|c| c * Vec3::new(1.0, flat, 1.0));
            let point = v(9) * Vec3::new(1.0, flat * libm::exp2f(4.0 - 24.0 * number(i, 21)), 1.0);
            let Some(triangle) = SphericalTriangle::new(corners, point) else { continue };
            for u in [[0.0, 0.0], [0.0, 1.0], [1.0, 0.0], [1.0, 1.0], [number(i, 22), number(i, 23)]] {
                let u = u.map(|x: f32| x.min(1.0 - f32::EPSILON));
                let Some(direction) = triangle.sample(u) else { continue };
                assert!((direction.length() - 1.0).abs() < 1e-9);
                let Some(weights) = weights(corners, point, direction) else { continue };
                assert!(weights.iter().all(|w| (-1e-6..=1.0).contains(w)), "{weights:?}");
            }
        }
    }
}
