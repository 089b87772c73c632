//! [`ShearedRay::meet_sheared`](crate::math::triangle::ShearedRay::meet_sheared) for sixteen rays: plain loops in double
//! precision, which compilers make vectors of, with the same bits.

use super::super::batch::NO_TRIANGLE;
use crate::lanes::{Floats, LANES, Lanes, Words};
use crate::math::Hit;

/// Where sixteen lines meet triangles.
pub struct Met {
    pub t: [f32; LANES],
    pub b1: [f32; LANES],
    pub b2: [f32; LANES],
    /// The triangles, or [`NO_TRIANGLE`].
    pub triangle: [u32; LANES],
}

impl Met {
    /// Of sheared corners, and the reciprocals of the directions' longest components.
    #[inline(always)]
    pub fn new<L: Lanes>(l: L, corners: &[[L::F; 3]; 3], inv_dir_z: &[f64; LANES], triangle: L::U) -> Self {
        let _ = l;
        let [[ax, ay, az], [bx, by, bz], [cx, cy, cz]] = corners;
        let (ax, ay, az) = (ax.array(), ay.array(), az.array());
        let (bx, by, bz) = (bx.array(), by.array(), bz.array());
        let (cx, cy, cz) = (cx.array(), cy.array(), cz.array());
        let number = triangle.array();
        let (mut t, mut b1, mut b2) = ([0.0; LANES], [0.0; LANES], [0.0; LANES]);
        let mut triangle = [NO_TRIANGLE; LANES];
        for i in 0..LANES {
            let u = exact(cx[i], by[i]) - exact(cy[i], bx[i]);
            let v = exact(ax[i], cy[i]) - exact(ay[i], cx[i]);
            let w = exact(bx[i], ay[i]) - exact(by[i], ax[i]);
            let missed = ((u < 0.0) | (v < 0.0) | (w < 0.0)) & ((u > 0.0) | (v > 0.0) | (w > 0.0));
            let det = u + v + w;
            let inv = 1.0 / det;
            let along = (u * f64::from(az[i]) + v * f64::from(bz[i]) + w * f64::from(cz[i])) * inv;
            t[i] = (along * inv_dir_z[i]) as f32;
            b1[i] = (v * inv) as f32;
            b2[i] = (w * inv) as f32;
            triangle[i] = if missed | (det == 0.0) { NO_TRIANGLE } else { number[i] };
        }
        Self { t, b1, b2, triangle }
    }

    /// Which lines meet their triangles at all.
    #[inline(always)]
    pub fn any<L: Lanes>(&self, l: L) -> L::M {
        !l.load_words(&self.triangle).eq(l.word(NO_TRIANGLE))
    }

    /// A ray's hit.
    #[inline(always)]
    pub fn hit(&self, i: usize) -> Option<Hit> {
        let hit = Hit { t: self.t[i], triangle: self.triangle[i], b1: self.b1[i], b2: self.b2[i] };
        (hit.triangle != NO_TRIANGLE).then_some(hit)
    }
}

#[inline(always)]
fn exact(p: f32, q: f32) -> f64 {
    f64::from(p) * f64::from(q)
}
