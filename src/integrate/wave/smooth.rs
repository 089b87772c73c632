//! Smooth surfaces in lanes: interpolated normals, those of normal maps, bent to the viewer's side, and the surface that they
//! stand for above the triangle. Twins of what `integrate/vertex.rs` and `integrate/bend.rs` do for one point.

use crate::integrate::bend::{LEAST_COSINE, LEAST_MIRRORED};
use crate::lanes::{Floats, Lanes, Mask, V3};

/// Sixteen points of triangles with normals at their corners.
pub(super) struct Corners<L: Lanes> {
    /// Seen against this direction.
    pub dir: V3<L::F>,
    pub point: V3<L::F>,
    pub error: V3<L::F>,
    /// Unit normals on the front, and on the viewer's side.
    pub outward: V3<L::F>,
    pub normal: V3<L::F>,
    pub positions: [V3<L::F>; 3],
    /// Of any length; zero where there are none.
    pub normals: [V3<L::F>; 3],
    /// Barycentric weights.
    pub b: [L::F; 3],
}

/// What comes of them.
pub(super) struct Smooth<L: Lanes> {
    /// Unit normal on the front: interpolated where the corners' normals give one, else that of the triangle.
    pub normal: V3<L::F>,
    /// From the triangle to the smooth surface above it, where that is so far that directions below the triangle's plane are
    /// open.
    pub lift: V3<L::F>,
    pub lifted: L::M,
}

impl<L: Lanes> Corners<L> {
    #[inline(always)]
    pub fn smooth(&self, l: L) -> Smooth<L> {
        let [n0, n1, n2] = self.normals;
        let [b0, b1, b2] = self.b;
        let interpolated = (n0 * b0 + n1 * b1 + n2 * b2).normalized();
        let known = interpolated.is_finite();
        let normal = V3::select(known, interpolated, self.outward);
        let lift = self.lift(l, 0) + self.lift(l, 1) + self.lift(l, 2);
        let far = self.normal.abs().dot(self.error) * 2.0;
        let lifted = known & lift.dot(self.normal).gt(far);
        Smooth { normal, lift: lift.only(lifted), lifted }
    }

    /// A corner's part of `vertex::lift`.
    #[inline(always)]
    fn lift(&self, l: L, k: usize) -> V3<L::F> {
        let zero = l.splat(0.0);
        let unit = self.normals[k].normalized();
        let front = self.dir.dot(self.outward).lt(zero);
        let normal = V3::select(front, unit, -unit);
        let agrees = normal.dot(self.normal).gt(zero) & unit.is_finite();
        let below = (self.point - self.positions[k]).dot(normal).min(zero);
        -(normal * (self.b[k] * below)).only(agrees)
    }
}

/// As `bend::visible_normal`, for unit shading normals and unit normals on the viewer's side.
#[inline(always)]
pub(super) fn visible_normal<F: Floats>(shading: V3<F>, normal: V3<F>, wo: V3<F>) -> V3<F> {
    let zero = wo.x.fill(0.0);
    let shading = V3::select(shading.dot(normal).lt(zero), -shading, shading);
    let cosine = shading.dot(wo);
    let least = zero.fill(LEAST_COSINE).min(normal.dot(wo));
    let bent = (shading + wo * (least - cosine)).normalized();
    let usable = bent.is_finite() & bent.dot(wo).gt(zero);
    V3::select(cosine.ge(least), shading, V3::select(usable, bent, normal))
}

/// Where [`visible_normal`] leaves a normal as it is, but for its side.
#[inline(always)]
pub(super) fn stays<F: Floats>(shading: V3<F>, normal: V3<F>, wo: V3<F>) -> F::Mask {
    let cosine = shading.dot(wo);
    let cosine = F::select(shading.dot(normal).lt(cosine.fill(0.0)), -cosine, cosine);
    cosine.ge(cosine.fill(LEAST_COSINE).min(normal.dot(wo)))
}

/// As `bend::reflecting_normal`, where `wanted`; the shading normals elsewhere.
#[inline(always)]
pub(super) fn reflecting_normal<F: Floats>(wanted: F::Mask, shading: V3<F>, normal: V3<F>, wo: V3<F>) -> V3<F> {
    let zero = wo.x.fill(0.0);
    let z = wo.dot(normal);
    let least = zero.fill(LEAST_MIRRORED).min(z * 0.9);
    let mirrored = shading.dot(wo) * 2.0 * shading.dot(normal) - z;
    let bends = wanted & mirrored.lt(least) & z.gt(zero);
    if bends.none() {
        return shading;
    }
    let along = (shading - normal * shading.dot(normal)).normalized();
    let x = wo.dot(along);
    let a = x * x + z * z;
    let b = (a + z * least) * 2.0;
    let c = (z + least) * (z + least);
    let root = (b * b - a * c * 4.0).max(zero).sqrt();
    let cos2 = (F::select(x.lt(zero), b + root, b - root) * 0.25 / a).max(zero).min(zero.fill(1.0));
    let bent = (along * (zero.fill(1.0) - cos2).sqrt() + normal * cos2.sqrt()).normalized();
    V3::select(bends & bent.is_finite() & bent.dot(wo).gt(zero), bent, shading)
}

/// As `material::Point::mapped_normal`: `texel` is what the map says, between −1 and 1 and scaled; the normals themselves where
/// there is no tangent (a handedness of 0).
#[inline(always)]
pub(super) fn mapped_normal<F: Floats>(normal: V3<F>, (tangent, handedness): (V3<F>, F), texel: V3<F>) -> V3<F> {
    let tangent = (tangent - normal * normal.dot(tangent)).normalized();
    let bitangent = normal.cross(tangent) * handedness;
    let mapped = (tangent * texel.x + bitangent * texel.y + normal * texel.z).normalized();
    let usable = tangent.is_finite() & mapped.is_finite() & !handedness.eq(handedness.fill(0.0));
    V3::select(usable, mapped, normal)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::integrate::bend;
    use crate::lanes::{AnyLanes, LANES, Work};
    use crate::math::simd::SimdTier;
    use crate::math::warp::{uniform_hemisphere, uniform_sphere};
    use crate::sampling::{hash_combine, unit_float};
    use glam::Vec3;

    /// Shading normal, normal, viewer.
    struct Bend([[Vec3; LANES]; 3]);

    impl Work for Bend {
        type Output = [[[f32; LANES]; 3]; 2];

        #[inline(always)]
        fn run<L: Lanes>(self, l: L) -> Self::Output {
            let vector = |k: usize| {
                let row = |c: usize| l.load(&self.0[k].map(|v| v[c]));
                V3::new(row(0), row(1), row(2))
            };
            let visible = visible_normal(vector(0), vector(1), vector(2));
            [visible.arrays(), reflecting_normal(l.first(LANES), visible, vector(1), vector(2)).arrays()]
        }
    }

    #[test]
    fn normals_bend_as_one_by_one() {
        let mut bent = 0;
        for round in 0..400u32 {
            let number = |i: usize, k: u32| unit_float(hash_combine(round * 16 + i as u32, k));
            let all = std::array::from_fn(|i| {
                let wo = uniform_hemisphere([number(i, 0), number(i, 1)]);
                (uniform_sphere([number(i, 2), number(i, 3)]), Vec3::Z, wo)
            });
            let [visible, reflecting] =
                AnyLanes::new(SimdTier::detect()).run(Bend([all.map(|v| v.0), all.map(|v| v.1), all.map(|v| v.2)]));
            for (i, (shading, normal, wo)) in all.into_iter().enumerate() {
                let lane = |v: &[[f32; LANES]; 3]| Vec3::new(v[0][i], v[1][i], v[2][i]);
                let one = bend::visible_normal(shading, normal, wo);
                assert!((lane(&visible) - one).length() < 1e-5, "{} {one}", lane(&visible));
                let turned = bend::reflecting_normal(one, normal, wo);
                bent += u32::from(turned.is_some());
                // The root cancels where the normals nearly agree.
                let (one, off) = (turned.unwrap_or(one), if turned.is_some() { 2e-3 } else { 1e-4 });
                assert!((lane(&reflecting) - one).length() < off, "{} {one}", lane(&reflecting));
            }
        }
        assert!(bent > 800, "{bent}");
    }
}
