//! What shading in lanes knows of the surfaces that sixteen rays hit.

use super::lanes::{FrameLanes, offset_point};
use crate::integrate::vertex::RoughVertex;
use crate::lanes::{Floats, LANES, Lanes, V3};
use crate::math::float_error::gamma;
use crate::prepare::PreparedScene;
use crate::shading::RoughLanes;
use glam::Vec3;

/// Sixteen surface points that scatter diffusely or by rough reflection, as seen by a path.
pub(super) struct Surface<L: Lanes> {
    /// Where what is reflected starts.
    pub point: V3<L::F>,
    error: V3<L::F>,
    /// Unit geometric normal on the viewer's side.
    normal: V3<L::F>,
    /// Whether `point` is above the triangle, so that directions below its plane are open.
    lifted: L::M,
    pub frame: FrameLanes<L::F>,
    /// Unit vector to the viewer in the frame.
    pub wo: V3<L::F>,
    pub lobes: RoughLanes<L::F>,
}

/// How rays leave sixteen points.
pub(super) struct Outgoing<L: Lanes> {
    /// Where the rays begin.
    pub origin: V3<L::F>,
    /// Whether they leave the triangle itself, and not a point above it.
    pub above: L::M,
    /// Whether the direction is open at all.
    pub open: L::M,
}

impl<L: Lanes> Surface<L> {
    /// How rays along world directions begin that go up in the frame.
    #[inline(always)]
    pub fn outgoing(&self, wi: V3<L::F>) -> Outgoing<L> {
        let above = wi.dot(self.normal).gt(wi.x.fill(0.0));
        let offset = offset_point(self.point, self.error, self.normal, wi);
        Outgoing { origin: V3::select(above, offset, self.point), above, open: above | self.lifted }
    }
}

/// Rows of numbers fetched one path after the other.
#[repr(align(64))]
struct Fetched<const N: usize>([[f32; LANES]; N]);

impl<const N: usize> Fetched<N> {
    fn put(&mut self, row: usize, lane: usize, v: Vec3) {
        for (k, x) in v.to_array().into_iter().enumerate() {
            self.0[row + k][lane] = x;
        }
    }

    #[inline(always)]
    fn vector<L: Lanes>(&self, l: L, row: usize) -> V3<L::F> {
        V3::new(l.load(&self.0[row]), l.load(&self.0[row + 1]), l.load(&self.0[row + 2]))
    }
}

/// Room for what is fetched.
pub(super) struct Fetch {
    /// Corners, normal and albedo.
    flat: Fetched<15>,
    /// Point, error, normal, shading normal, albedo, both reflectances, α and the share of the diffuse lobe.
    rough: Fetched<23>,
    /// Which of the latter are lifted.
    lifted: u32,
}

impl Fetch {
    pub fn new() -> Self {
        Self { flat: Fetched([[0.0; LANES]; 15]), rough: Fetched([[0.0; LANES]; 23]), lifted: 0 }
    }

    /// Fetches a flat, diffuse triangle for a lane.
    #[inline]
    pub fn put_flat(&mut self, lane: usize, prepared: &PreparedScene, triangle: u32, albedo: Vec3) {
        for (k, corner) in prepared.geometry.corners(triangle).into_iter().enumerate() {
            self.flat.put(3 * k, lane, corner);
        }
        self.flat.put(9, lane, prepared.geometry.unit_normal(triangle));
        self.flat.put(12, lane, albedo);
    }

    /// Fetches a vertex for a lane.
    pub fn put_rough(&mut self, lane: usize, v: &RoughVertex) {
        let vectors =
            [v.point, v.error, v.normal, v.shading, v.lobes.albedo.into(), v.lobes.f0.into(), v.lobes.f90.into()];
        for (k, vector) in vectors.into_iter().enumerate() {
            self.rough.put(3 * k, lane, vector);
        }
        self.rough.0[21][lane] = v.lobes.alpha;
        self.rough.0[22][lane] = v.lobes.diffuse_share;
        self.lifted = self.lifted & !(1 << lane) | u32::from(v.lifted) << lane;
    }

    /// The surfaces at hits with the weights `b1` and `b2`, seen along `dir`: where `rough` says so those fetched as
    /// vertices, else flat ones.
    #[inline(always)]
    pub fn surface<L: Lanes>(&self, l: L, dir: V3<L::F>, b1: L::F, b2: L::F, rough: L::M) -> Surface<L> {
        use crate::lanes::Mask;
        let mut surface = self.flat(l, dir, b1, b2);
        if rough.any() {
            surface.point = V3::select(rough, self.rough.vector(l, 0), surface.point);
            surface.error = V3::select(rough, self.rough.vector(l, 3), surface.error);
            surface.normal = V3::select(rough, self.rough.vector(l, 6), surface.normal);
            surface.frame = FrameLanes::from_normal(V3::select(rough, self.rough.vector(l, 9), surface.frame.z));
            surface.lobes.albedo = V3::select(rough, self.rough.vector(l, 12), surface.lobes.albedo);
            (surface.lobes.f0, surface.lobes.f90) = (self.rough.vector(l, 15), self.rough.vector(l, 18));
            surface.lobes.alpha = l.load(&self.rough.0[21]);
            let share = L::F::select(rough, l.load(&self.rough.0[22]), l.splat(1.0));
            surface.lobes.diffuse_share = share;
            surface.lobes.reflects = share.lt(l.splat(1.0)).any();
            surface.lifted = l.mask(self.lifted) & rough;
        }
        surface.wo = surface.frame.to_local(-dir);
        surface
    }

    /// As `Place` and `Vertex` have it.
    #[inline(always)]
    fn flat<L: Lanes>(&self, l: L, dir: V3<L::F>, b1: L::F, b2: L::F) -> Surface<L> {
        let (zero, one) = (l.splat(0.0), l.splat(1.0));
        let [c0, c1, c2]: [V3<L::F>; 3] = [self.flat.vector(l, 0), self.flat.vector(l, 3), self.flat.vector(l, 6)];
        let [p0, p1, p2] = [c0 * (one - b1 - b2), c1 * b1, c2 * b2];
        let outward = self.flat.vector(l, 9);
        let normal = V3::select(dir.dot(outward).lt(zero), outward, -outward);
        let extent = extent(c0.x, c1.x, c2.x).max(extent(c0.y, c1.y, c2.y)).max(extent(c0.z, c1.z, c2.z));
        let neighbours = extent * gamma(15);
        let rounding = (p0.abs() + p1.abs() + p2.abs()) * l.splat(gamma(7));
        Surface {
            point: p0 + p1 + p2,
            error: rounding + V3::splat(neighbours),
            normal,
            lifted: l.mask(0),
            frame: FrameLanes::from_normal(normal),
            wo: -dir,
            lobes: RoughLanes {
                albedo: self.flat.vector(l, 12),
                alpha: one,
                f0: V3::splat(zero),
                f90: V3::splat(zero),
                diffuse_share: one,
                reflects: false,
            },
        }
    }
}

#[inline(always)]
fn extent<F: Floats>(a: F, b: F, c: F) -> F {
    a.max(b).max(c) - a.min(b).min(c)
}
