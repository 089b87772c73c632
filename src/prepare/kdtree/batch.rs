//! Many rays at once, side by side in memory: what a wavefront of paths calls.
//!
//! A batch finds, bit for bit, what its rays find one by one.

use super::wide::packet::Packets;
use super::wide::packet_exact::Met;
use super::{Form, KdTree};
use crate::lanes::LANES;
use crate::math::{Hit, Ray};
use glam::Vec3;

/// Stands where there is no triangle.
pub const NO_TRIANGLE: u32 = u32::MAX;

/// Trees of up to so many references a pixel are walked in packets by rays of a camera: beyond it, a packet's rays meet different
/// leaves. Measured, like the next two (scripts/runs/2026-11-24-packets.md).
const PACKETS_IF_A_PIXEL: u64 = 32;
/// Trees of up to so many references are walked in packets by shadow rays to few lamps.
const PACKETS_IF_LAMPS: u64 = 1 << 13;
/// Trees of up to so many references are walked in packets by any rays.
const PACKETS_IF_SCATTERED: u64 = 160;

/// Rays side by side. All slices are equally long, but `reaches` and `leaves` may be empty when no ray has such a triangle.
#[derive(Clone, Copy, Debug)]
pub struct RayBatch<'a> {
    /// Where the rays begin: x, y, z.
    pub origin: [&'a [f32]; 3],
    /// Where they go: x, y, z; finite and not zero, of any length.
    pub dir: [&'a [f32]; 3],
    /// Where they end, in units of their directions; may be infinite.
    pub t_max: &'a [f32],
    /// The triangle that each ray ends on and that does not count as met, or [`NO_TRIANGLE`].
    pub reaches: &'a [u32],
    /// The triangle that each ray begins on, or [`NO_TRIANGLE`]: its plane is behind the ray's origin, which was moved off it
    /// to the side where the ray goes. It would not be met; who knows need not look.
    pub leaves: &'a [u32],
}

/// What rays found, in slices as long as their batch. On a miss the triangle is [`NO_TRIANGLE`], the distance where the ray ends,
/// and the weights are zero.
#[derive(Debug)]
pub struct HitBatch<'a> {
    /// Distances in units of the rays' directions.
    pub t: &'a mut [f32],
    /// Barycentric weights of the triangles' second corners.
    pub b1: &'a mut [f32],
    /// Barycentric weights of the triangles' third corners.
    pub b2: &'a mut [f32],
    /// The triangles.
    pub triangle: &'a mut [u32],
}

/// Whether neighbours in a batch go like ways. A hint, which never changes what is found.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Coherence {
    /// They do: rays of a camera in the order of a tile, for a picture of so many pixels.
    Camera {
        /// Width times height.
        pixels: u64,
    },
    /// They do as far as lamps are small: shadow rays of neighbours to one of few.
    Lamps,
    /// They do not: rays after a diffuse bounce.
    Scattered,
}

impl RayBatch<'_> {
    /// Number of rays.
    ///
    /// # Panics
    /// When the slices are not equally long.
    #[inline]
    pub fn len(&self) -> usize {
        let n = self.t_max.len();
        assert!(self.origin.iter().chain(&self.dir).all(|row| row.len() == n), "rows of a batch are equally long");
        assert!([self.reaches, self.leaves].iter().all(|row| row.is_empty() || row.len() == n));
        n
    }

    /// Whether there are no rays.
    #[inline]
    pub fn is_empty(&self) -> bool {
        self.t_max.is_empty()
    }

    /// A ray.
    #[inline(always)]
    pub fn ray(&self, i: usize) -> Ray {
        let at = |rows: &[&[f32]; 3]| Vec3::new(rows[0][i], rows[1][i], rows[2][i]);
        Ray { origin: at(&self.origin), dir: at(&self.dir), t_max: self.t_max[i] }
    }

    /// The triangle that a ray may not meet: what it reaches.
    #[inline(always)]
    pub(super) fn barred(&self, i: usize) -> u32 {
        self.reaches.get(i).copied().unwrap_or(NO_TRIANGLE)
    }
}

/// Is told what rays found.
pub(super) trait Found {
    /// What a ray found.
    fn one(&mut self, i: usize, hit: Option<Hit>);
    /// What sixteen found, from number `first` on.
    fn sixteen(&mut self, first: usize, met: &Met);
}

/// Keeps hits.
struct Hits<'a, 'b> {
    rays: &'a RayBatch<'a>,
    hits: &'a mut HitBatch<'b>,
}

impl Found for Hits<'_, '_> {
    #[inline(always)]
    fn one(&mut self, i: usize, hit: Option<Hit>) {
        let hit = hit.unwrap_or(Hit { t: self.rays.t_max[i], triangle: NO_TRIANGLE, b1: 0.0, b2: 0.0 });
        let to = &mut *self.hits;
        (to.t[i], to.b1[i], to.b2[i], to.triangle[i]) = (hit.t, hit.b1, hit.b2, hit.triangle);
    }

    #[inline(always)]
    fn sixteen(&mut self, first: usize, met: &Met) {
        let (of, to) = (first..first + LANES, &mut *self.hits);
        let (t, b1, b2) = (&mut to.t[of.clone()], &mut to.b1[of.clone()], &mut to.b2[of.clone()]);
        let t_max = &self.rays.t_max[of.clone()];
        for i in 0..LANES {
            let none = met.triangle[i] == NO_TRIANGLE;
            t[i] = if none { t_max[i] } else { met.t[i] };
            b1[i] = if none { 0.0 } else { met.b1[i] };
            b2[i] = if none { 0.0 } else { met.b2[i] };
        }
        to.triangle[of].copy_from_slice(&met.triangle);
    }
}

impl Found for &mut [bool] {
    #[inline(always)]
    fn one(&mut self, i: usize, hit: Option<Hit>) {
        self[i] = hit.is_some();
    }

    #[inline(always)]
    fn sixteen(&mut self, first: usize, met: &Met) {
        for (blocked, triangle) in self[first..first + LANES].iter_mut().zip(met.triangle) {
            *blocked = triangle != NO_TRIANGLE;
        }
    }
}

impl KdTree {
    /// [`KdTree::closest`] for each ray of a batch.
    ///
    /// # Panics
    /// When slices are not as long as they have to be; likewise for the other calls on batches.
    pub fn closest_batch(&self, rays: &RayBatch, coherence: Coherence, hits: &mut HitBatch) {
        self.closest_of::<true>(rays, coherence, hits, |_, _| true);
    }

    /// [`KdTree::closest_batch`] among the hits that `stops` lets through. It is asked about a ray by its number in the
    /// batch, in any order, perhaps more than once, also about hits that turn out not to be the nearest.
    pub fn closest_batch_where(
        &self,
        rays: &RayBatch,
        coherence: Coherence,
        hits: &mut HitBatch,
        stops: impl FnMut(usize, &Hit) -> bool,
    ) {
        self.closest_of::<false>(rays, coherence, hits, stops);
    }

    fn closest_of<const ALL: bool>(
        &self,
        rays: &RayBatch,
        coherence: Coherence,
        hits: &mut HitBatch,
        stops: impl FnMut(usize, &Hit) -> bool,
    ) {
        assert_eq!([hits.t.len(), hits.b1.len(), hits.b2.len(), hits.triangle.len()], [rays.len(); 4]);
        self.trace::<false, ALL>(rays, coherence, stops, Hits { rays, hits });
    }

    /// [`KdTree::occluded`] for each ray of a batch.
    pub fn occluded_batch(&self, rays: &RayBatch, coherence: Coherence, blocked: &mut [bool]) {
        assert_eq!(rays.len(), blocked.len());
        self.trace::<true, true>(rays, coherence, |_, _| true, blocked);
    }

    /// [`KdTree::occluded_batch`] by the hits that `stops` lets through; see [`KdTree::closest_batch_where`].
    pub fn occluded_batch_where(
        &self,
        rays: &RayBatch,
        coherence: Coherence,
        blocked: &mut [bool],
        stops: impl FnMut(usize, &Hit) -> bool,
    ) {
        assert_eq!(rays.len(), blocked.len());
        self.trace::<true, false>(rays, coherence, stops, blocked);
    }

    /// Whether sixteen neighbours in a batch go through the tree as one packet.
    pub fn packs(&self, coherence: Coherence) -> bool {
        let most = match coherence {
            Coherence::Camera { pixels } => pixels.saturating_mul(PACKETS_IF_A_PIXEL),
            Coherence::Lamps => PACKETS_IF_LAMPS,
            Coherence::Scattered => PACKETS_IF_SCATTERED,
        };
        matches!(self.form, Form::One(_)) && self.statistics.references <= most
    }

    /// Traces a batch in the form that fits the tree and the rays; with `ALL`, every hit counts.
    fn trace<const ANY: bool, const ALL: bool>(
        &self,
        rays: &RayBatch,
        coherence: Coherence,
        stops: impl FnMut(usize, &Hit) -> bool,
        mut found: impl Found,
    ) {
        let kernel = self.kernel;
        match &self.form {
            Form::One(tree) if self.packs(coherence) => {
                let (tree, lines) = (tree.wide(), &self.lines);
                self.lanes.run(Packets::<ANY, ALL, _, _> { kernel, tree, lines, rays, stops, found });
            }
            Form::One(tree) => {
                kernel.trace::<ANY>(self.lanes, tree.wide(), rays, stops, |i, hit| found.one(i, hit));
            }
            Form::Instances(all) => all.trace::<ANY>(kernel, rays, stops, |i, hit| found.one(i, hit)),
        }
    }
}
