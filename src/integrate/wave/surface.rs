//! What shading in lanes knows of the surfaces that sixteen rays hit.

use super::lanes::{FrameLanes, offset_point};
use super::smooth::Corners;
use crate::geometry::{TexturesLanes, Texturing};
use crate::integrate::vertex::SAME_PLANE;
use crate::lanes::{Floats, LANES, Lanes, Mask, V3};
use crate::math::float_error::gamma;
use crate::prepare::PreparedScene;
use crate::shading::{Glass, GlassLanes};
use glam::Vec3;

/// Sixteen surface points, as seen by a path.
pub(super) struct Surface<L: Lanes> {
    /// Where what is reflected starts.
    pub point: V3<L::F>,
    /// Where what is transmitted starts: on the triangle.
    pub place: V3<L::F>,
    pub error: V3<L::F>,
    /// Unit geometric normal on the viewer's side.
    pub normal: V3<L::F>,
    /// Whether `point` is above the triangle, so that directions below its plane are open.
    pub lifted: L::M,
    /// Whether the shading normal is the one that all viewers on this side see, and not bent to this one.
    pub steady: L::M,
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
    /// How rays along world directions begin, whose cosines to the shading normal are `local_z`.
    #[inline(always)]
    pub fn outgoing(&self, wi: V3<L::F>, local_z: L::F) -> Outgoing<L> {
        let zero = local_z.fill(0.0);
        let (above, reflected) = (wi.dot(self.normal).gt(zero), local_z.gt(zero));
        let agree = !(above ^ reflected);
        let from = V3::select(reflected, self.point, self.place);
        let offset = offset_point(from, self.error, self.normal, wi);
        Outgoing { origin: V3::select(agree, offset, self.point), open: agree | reflected & self.lifted }
    }

    /// Takes unit shading normals; the points are seen along `dir`.
    #[inline(always)]
    pub fn turn(&mut self, shading: V3<L::F>, dir: V3<L::F>) {
        self.frame = FrameLanes::from_normal(shading);
        self.wo = self.frame.to_local(-dir);
    }

    /// Has rays start on the triangle itself.
    #[inline(always)]
    pub fn lower(&mut self, there: L::M) {
        self.point = V3::select(there, self.place, self.point);
        self.lifted = self.lifted & !there;
    }

    /// Where directions below the plane of the triangle are not open.
    #[inline(always)]
    pub fn is_flat(&self) -> L::M {
        !self.lifted
    }
}

/// Rows of numbers fetched one path after the other.
#[repr(align(64))]
struct Fetched<const N: usize>([[f32; LANES]; N]);

impl<const N: usize> Fetched<N> {
    fn put(&mut self, row: usize, lane: usize, v: Vec3) {
        for (k, x) in v.to_array().into_iter().enumerate() {
            self.0[row + k][lane % LANES] = x;
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
    /// Both sets of texture coordinates, twice the triangle's area in each, colour, tangent and its handedness.
    look: Fetched<13>,
    /// Albedo of surfaces of one diffuse colour.
    albedo: Fetched<3>,
    /// Of smooth glass: index, reflectance at normal and at grazing incidence, tint.
    glass: Fetched<8>,
    /// Materials of all but diffuse surfaces.
    pub material: [u32; LANES],
}

impl Fetch {
    pub fn new() -> Self {
        Self {
            triangle: Fetched([[0.0; LANES]; 12]),
            normals: Fetched([[0.0; LANES]; 9]),
            look: Fetched([[0.0; LANES]; 13]),
            albedo: Fetched([[0.0; LANES]; 3]),
            glass: Fetched([[0.0; LANES]; 8]),
            material: [0; LANES],
        }
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

    /// Puts down the colour of a diffuse surface.
    #[inline]
    pub fn put_albedo(&mut self, lane: usize, albedo: Vec3) {
        self.albedo.put(0, lane, albedo);
    }

    /// Puts down what smooth glass is like.
    #[inline]
    pub fn put_glass(&mut self, lane: usize, glass: &Glass) {
        self.glass.0[0][lane] = glass.eta;
        self.glass.put(1, lane, glass.f0.into());
        self.glass.0[4][lane] = glass.f90;
        self.glass.put(5, lane, glass.tint.into());
    }

    /// Smooth glass.
    #[inline(always)]
    pub fn glass<L: Lanes>(&self, l: L) -> GlassLanes<L::F> {
        GlassLanes {
            eta: l.load(&self.glass.0[0]),
            f0: self.glass.vector(l, 1),
            f90: l.load(&self.glass.0[4]),
            tint: self.glass.vector(l, 5),
        }
    }

    /// Fetches what textures are looked up by.
    #[inline]
    pub fn put_look(&mut self, lane: usize, of: &Texturing) {
        let ([[u0, v0], [u1, v1]], [area0, area1], (tangent, handedness)) = (of.uv, of.uv_area, of.tangent);
        for (row, x) in [u0, v0, u1, v1, area0, area1].into_iter().enumerate() {
            self.look.0[row][lane] = x;
        }
        self.look.put(6, lane, of.color);
        self.look.put(9, lane, tangent);
        self.look.0[12][lane] = handedness;
    }

    /// The surfaces at hits with the weights `b1` and `b2`, seen along `dir`: flat ones, and where `smooth` those with normals at
    /// their corners. Gives the unit normals on their fronts, too.
    #[inline(always)]
    pub fn surface<L: Lanes>(&self, l: L, dir: V3<L::F>, [b1, b2]: [L::F; 2], smooth: L::M) -> (Surface<L>, V3<L::F>) {
        let mut surface = self.flat(l, dir, b1, b2);
        let mut normal = self.outward(l);
        if smooth.any() {
            let corners = Corners::<L> {
                dir,
                point: surface.point,
                error: surface.error,
                outward: normal,
                normal: surface.normal,
                positions: [self.triangle.vector(l, 0), self.triangle.vector(l, 3), self.triangle.vector(l, 6)],
                normals: [self.normals.vector(l, 0), self.normals.vector(l, 3), self.normals.vector(l, 6)],
                b: [l.splat(1.0) - b1 - b2, b1, b2],
            };
            let own = corners.smooth(l);
            surface.lifted = own.lifted & smooth;
            surface.point = V3::select(surface.lifted, surface.point + own.lift, surface.point);
            normal = V3::select(smooth, own.normal, normal);
        }
        (surface, normal)
    }

    /// Unit normals on the fronts.
    #[inline(always)]
    pub fn outward<L: Lanes>(&self, l: L) -> V3<L::F> {
        self.triangle.vector(l, 9)
    }

    /// The colours of diffuse surfaces.
    #[inline(always)]
    pub fn albedo<L: Lanes>(&self, l: L) -> V3<L::F> {
        self.albedo.vector(l, 0)
    }

    /// Colour factors, where surfaces have textures or colours.
    #[inline(always)]
    pub fn color<L: Lanes>(&self, l: L, textured: L::M) -> V3<L::F> {
        V3::select(textured, self.look.vector(l, 6), V3::splat(l.splat(1.0)))
    }

    /// Tangents, and their handedness, 0 where there are none.
    #[inline(always)]
    pub fn tangent<L: Lanes>(&self, l: L) -> (V3<L::F>, L::F) {
        (self.look.vector(l, 9), l.load(&self.look.0[12]))
    }

    /// Textures as rays of these widths see them.
    #[inline(always)]
    pub fn textures<'a, L: Lanes>(&self, l: L, prepared: &'a PreparedScene, width: L::F) -> TexturesLanes<'a, L> {
        let (a, b, c) = (self.triangle.vector(l, 0), self.triangle.vector(l, 3), self.triangle.vector(l, 6));
        let area = (b - a).cross(c - a).length_squared().sqrt();
        let square = width * width;
        let [u0, v0, u1, v1, area0, area1, ..] = &self.look.0;
        TexturesLanes {
            scene: &prepared.scene,
            pyramids: &prepared.pyramids,
            uv: [[l.load(u0), l.load(v0)], [l.load(u1), l.load(v1)]],
            footprint: [square * (l.load(area0) / area), square * (l.load(area1) / area)],
        }
    }

    /// As `Place` and `Vertex` have it.
    #[inline(always)]
    fn flat<L: Lanes>(&self, l: L, dir: V3<L::F>, b1: L::F, b2: L::F) -> Surface<L> {
        let (zero, one) = (l.splat(0.0), l.splat(1.0));
        let (c0, c1, c2) = (self.triangle.vector(l, 0), self.triangle.vector(l, 3), self.triangle.vector(l, 6));
        let (p0, p1, p2) = (c0 * (one - b1 - b2), c1 * b1, c2 * b2);
        let outward = self.outward(l);
        let normal = V3::select(dir.dot(outward).lt(zero), outward, -outward);
        let extent = extent(c0.x, c1.x, c2.x).max(extent(c0.y, c1.y, c2.y)).max(extent(c0.z, c1.z, c2.z));
        let plane = extent * gamma(SAME_PLANE);
        let rounding = (p0.abs() + p1.abs() + p2.abs()) * l.splat(gamma(7));
        let point = p0 + p1 + p2;
        Surface {
            point,
            place: point,
            error: rounding + V3::splat(plane),
            normal,
            lifted: l.mask(0),
            steady: l.first(LANES),
            frame: FrameLanes { x: normal, y: normal, z: normal },
            wo: dir,
        }
    }
}

#[inline(always)]
fn extent<F: Floats>(a: F, b: F, c: F) -> F {
    a.max(b).max(c) - a.min(b).min(c)
}
