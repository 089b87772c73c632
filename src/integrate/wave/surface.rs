//! What shading in lanes knows of the surfaces that sixteen rays hit.

use super::lanes::{FrameLanes, offset_point};
use super::smooth::Corners;
use crate::integrate::vertex::{RoughVertex, SAME_PLANE};
use crate::lanes::{Floats, LANES, Lanes, Mask, V3};
use crate::math::float_error::gamma;
use crate::prepare::PreparedScene;
use crate::shading::{RoughLanes, RoughLobes};
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
}

/// How rays leave sixteen points.
pub(super) struct Outgoing<L: Lanes> {
    /// Where the rays begin.
    pub origin: V3<L::F>,
    /// Whether the direction is open at all.
    pub open: L::M,
}

impl<L: Lanes> Surface<L> {
    /// How rays along world directions begin that go up in the frame.
    #[inline(always)]
    pub fn outgoing(&self, wi: V3<L::F>) -> Outgoing<L> {
        let above = wi.dot(self.normal).gt(wi.x.fill(0.0));
        let offset = offset_point(self.point, self.error, self.normal, wi);
        Outgoing { origin: V3::select(above, offset, self.point), open: above | self.lifted }
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
    /// Corners and normal of triangles.
    triangle: Fetched<12>,
    /// Normals at the corners.
    normals: Fetched<9>,
    /// Point, error, normal and shading normal of vertices that were made one by one.
    vertex: Fetched<12>,
    /// Which of the latter are lifted.
    lifted: u32,
    /// Albedo, both reflectances, α and the share of the diffuse lobe.
    lobes: Fetched<11>,
}

impl Fetch {
    pub fn new() -> Self {
        let (triangle, normals) = (Fetched([[0.0; LANES]; 12]), Fetched([[0.0; LANES]; 9]));
        let (vertex, lobes) = (Fetched([[0.0; LANES]; 12]), Fetched([[0.0; LANES]; 11]));
        Self { triangle, normals, vertex, lifted: 0, lobes }
    }

    /// Fetches a triangle for a lane.
    #[inline]
    pub fn put_triangle(&mut self, lane: usize, prepared: &PreparedScene, triangle: u32) {
        for (k, corner) in prepared.geometry.corners(triangle).into_iter().enumerate() {
            self.triangle.put(3 * k, lane, corner);
        }
        self.triangle.put(9, lane, prepared.geometry.unit_normal(triangle));
    }

    /// Fetches the normals at a triangle's corners.
    #[inline]
    pub fn put_normals(&mut self, lane: usize, prepared: &PreparedScene, triangle: u32) {
        let normals = prepared.geometry.corner_normals(triangle).unwrap_or_default();
        for (k, normal) in normals.into_iter().enumerate() {
            self.normals.put(3 * k, lane, normal);
        }
    }

    /// Puts down a diffuse lobe.
    #[inline]
    pub fn put_albedo(&mut self, lane: usize, albedo: Vec3) {
        self.put_lobes(lane, &RoughLobes::lambert(albedo));
    }

    /// Puts down the lobes of a lane.
    #[inline]
    pub fn put_lobes(&mut self, lane: usize, lobes: &RoughLobes) {
        for (k, colour) in [lobes.albedo, lobes.f0, lobes.f90].into_iter().enumerate() {
            self.lobes.put(3 * k, lane, colour.into());
        }
        self.lobes.0[9][lane] = lobes.alpha;
        self.lobes.0[10][lane] = lobes.diffuse_share;
    }

    /// Puts down a vertex for a lane.
    pub fn put_vertex(&mut self, lane: usize, v: &RoughVertex) {
        for (k, vector) in [v.point, v.error, v.normal, v.shading].into_iter().enumerate() {
            self.vertex.put(3 * k, lane, vector);
        }
        self.lifted = self.lifted & !(1 << lane) | u32::from(v.lifted) << lane;
        self.put_lobes(lane, &v.lobes);
    }

    /// The surfaces at hits with the weights `b1` and `b2`, seen along `dir`, without their lobes: flat ones, those with normals
    /// at their corners where `smooth`, and those that are vertices already where `made`.
    #[inline(always)]
    pub fn surface<L: Lanes>(&self, l: L, dir: V3<L::F>, [b1, b2]: [L::F; 2], [smooth, made]: [L::M; 2]) -> Surface<L> {
        let mut surface = self.flat(l, dir, b1, b2);
        let mut shading = surface.normal;
        if smooth.any() {
            let corners = Corners::<L> {
                dir,
                point: surface.point,
                error: surface.error,
                outward: self.triangle.vector(l, 9),
                normal: surface.normal,
                positions: [self.triangle.vector(l, 0), self.triangle.vector(l, 3), self.triangle.vector(l, 6)],
                normals: [self.normals.vector(l, 0), self.normals.vector(l, 3), self.normals.vector(l, 6)],
                b: [l.splat(1.0) - b1 - b2, b1, b2],
            };
            let own = corners.smooth(l);
            surface.lifted = own.lifted & smooth;
            surface.point = V3::select(surface.lifted, surface.point + own.lift, surface.point);
            shading = V3::select(smooth, own.shading, shading);
        }
        if made.any() {
            surface.point = V3::select(made, self.vertex.vector(l, 0), surface.point);
            surface.error = V3::select(made, self.vertex.vector(l, 3), surface.error);
            surface.normal = V3::select(made, self.vertex.vector(l, 6), surface.normal);
            shading = V3::select(made, self.vertex.vector(l, 9), shading);
            surface.lifted = surface.lifted & !made | l.mask(self.lifted) & made;
        }
        surface.frame = FrameLanes::from_normal(shading);
        surface.wo = surface.frame.to_local(-dir);
        surface
    }

    /// The lobes that were put down.
    #[inline(always)]
    pub fn lobes<L: Lanes>(&self, l: L, active: L::M) -> RoughLanes<L::F> {
        let diffuse_share = l.load(&self.lobes.0[10]);
        RoughLanes {
            albedo: self.lobes.vector(l, 0),
            f0: self.lobes.vector(l, 3),
            f90: self.lobes.vector(l, 6),
            alpha: l.load(&self.lobes.0[9]),
            diffuse_share,
            reflects: (diffuse_share.lt(l.splat(1.0)) & active).any(),
        }
    }

    /// As `Place` and `Vertex` have it.
    #[inline(always)]
    fn flat<L: Lanes>(&self, l: L, dir: V3<L::F>, b1: L::F, b2: L::F) -> Surface<L> {
        let (zero, one) = (l.splat(0.0), l.splat(1.0));
        let (c0, c1, c2) = (self.triangle.vector(l, 0), self.triangle.vector(l, 3), self.triangle.vector(l, 6));
        let (p0, p1, p2) = (c0 * (one - b1 - b2), c1 * b1, c2 * b2);
        let outward = self.triangle.vector(l, 9);
        let normal = V3::select(dir.dot(outward).lt(zero), outward, -outward);
        let extent = extent(c0.x, c1.x, c2.x).max(extent(c0.y, c1.y, c2.y)).max(extent(c0.z, c1.z, c2.z));
        let plane = extent * gamma(SAME_PLANE);
        let rounding = (p0.abs() + p1.abs() + p2.abs()) * l.splat(gamma(7));
        Surface {
            point: p0 + p1 + p2,
            error: rounding + V3::splat(plane),
            normal,
            lifted: l.mask(0),
            frame: FrameLanes { x: normal, y: normal, z: normal },
            wo: dir,
        }
    }
}

#[inline(always)]
fn extent<F: Floats>(a: F, b: F, c: F) -> F {
    a.max(b).max(c) - a.min(b).min(c)
}
