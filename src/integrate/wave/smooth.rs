//! Smooth surfaces in lanes: interpolated normals, bent to the viewer's side, and the surface that they stand for above the
//! triangle. Twins of what `integrate/vertex.rs` does for one point.

use crate::integrate::bend::LEAST_COSINE;
use crate::lanes::{Floats, Lanes, V3};

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
    /// Unit shading normal.
    pub shading: V3<L::F>,
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
        let shading = self.visible(l, V3::select(known, interpolated, self.outward));
        let lift = self.lift(l, 0) + self.lift(l, 1) + self.lift(l, 2);
        let far = self.normal.abs().dot(self.error) * 2.0;
        let lifted = known & lift.dot(self.normal).gt(far);
        Smooth { shading, lift: lift.only(lifted), lifted }
    }

    /// As `bend::visible_normal`.
    #[inline(always)]
    fn visible(&self, l: L, shading: V3<L::F>) -> V3<L::F> {
        let (zero, wo) = (l.splat(0.0), -self.dir);
        let shading = V3::select(shading.dot(self.normal).lt(zero), -shading, shading);
        let cosine = shading.dot(wo);
        let least = l.splat(LEAST_COSINE).min(self.normal.dot(wo));
        let bent = (shading + wo * (least - cosine)).normalized();
        let usable = bent.is_finite() & bent.dot(wo).gt(zero);
        V3::select(cosine.ge(least), shading, V3::select(usable, bent, self.normal))
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
