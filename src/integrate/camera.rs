use super::cone::{Cone, SHARPNESS};
use crate::geometry::WorldFrame;
use crate::lanes::{Floats, V3};
use glam::{DMat3, DVec3, Vec3};
use kiln_formats::scene::{Camera, Projection};

/// All geometry lies within this distance of the origin of the rays' frame (√3, as its extent lies below 2).
const BEYOND_SCENE: f64 = 2.0;

/// A camera in the rays' frame. Double precision, as it may be far away.
#[derive(Clone, Copy, Debug)]
pub(super) struct RayCamera {
    projection: Projection,
    origin: DVec3,
    forward: DVec3,
    right: DVec3,
    up: DVec3,
}

impl RayCamera {
    pub(super) fn new(camera: &Camera, frame: &WorldFrame) -> Self {
        // A perspective image plane may be scaled as a whole: only directions count.
        let perspective = camera.projection == Projection::Perspective;
        let unit = if perspective { 1.0 / camera.forward.length() } else { frame.scale() };
        Self {
            projection: camera.projection,
            origin: frame.exact_point(camera.origin),
            forward: if perspective { camera.forward * unit } else { camera.forward.normalize() },
            right: camera.right * unit,
            up: camera.up * unit,
        }
    }

    /// Origin and unit direction of the ray through the picture point (x, y) in [0, 1]², (0, 0) being the upper left.
    /// From a distant camera it begins just before it can meet anything, where `f32` is fine enough.
    pub(super) fn ray(&self, x: f64, y: f64) -> (Vec3, Vec3) {
        let across = self.right * (2.0 * x - 1.0) + self.up * (1.0 - 2.0 * y);
        let (origin, dir) = match self.projection {
            Projection::Perspective => (self.origin, (self.forward + across).normalize()),
            Projection::Orthographic => (self.origin + across, self.forward),
        };
        let skipped = (-origin.dot(dir) - BEYOND_SCENE).max(0.0);
        ((origin + dir * skipped).as_vec3(), dir.as_vec3())
    }

    /// Gives for points in the rays' frame how far away they are along the axis, and where in the picture they lie, as
    /// [`Self::ray`] takes it; `None` for a camera whose axes lie in one plane.
    pub(super) fn projector(&self) -> Option<impl Fn(DVec3) -> (f64, [f64; 2])> {
        let to_axes = DMat3::from_cols(self.forward, self.right, self.up).try_inverse()?;
        let Self { projection, origin, .. } = *self;
        Some(move |point: DVec3| {
            let along = to_axes * (point - origin);
            let [a, b] = match projection {
                Projection::Perspective => [along.y / along.x, along.z / along.x],
                Projection::Orthographic => [along.y, along.z],
            };
            (along.x, [0.5 * (1.0 + a), 0.5 * (1.0 - b)])
        })
    }

    /// Of a perspective camera, its place and what takes points as seen from there to how far away they are along the axis, and to how far to the
    /// right and above, in units of the picture's half sides and times that distance. As [`Self::projector`], in single precision.
    /// `None` where that is not fine enough, or overflows.
    pub(super) fn near_axes(&self) -> Option<(Vec3, [Vec3; 3])> {
        let NearCamera { origin, .. } = self.near()?;
        let to_axes = DMat3::from_cols(self.forward, self.right, self.up).try_inverse()?.as_mat3();
        let axes = [to_axes.row(0), to_axes.row(1), to_axes.row(2)];
        axes.iter().all(|axis| axis.length() < LONGEST).then_some((origin, axes))
    }

    /// The cone of a ray that begins at `origin`, in a picture of `height` pixels.
    pub(super) fn cone(&self, origin: Vec3, height: u32) -> Cone {
        let pixel = SHARPNESS * (2.0 * self.up.length() / f64::from(height)) as f32;
        match self.projection {
            Projection::Perspective => {
                let before = (origin.as_dvec3() - self.origin).length() as f32;
                Cone { width: 0.0, spread: pixel }.at(before)
            }
            Projection::Orthographic => Cone { width: pixel, spread: 0.0 },
        }
    }
}

/// Within this distance of the origin of the rays' frame, `f32` is fine enough for a camera, too: rays are off by a millionth of the
/// scene, all that meet a surface alike.
const NEAR: f64 = 16.0;
/// Axes of cameras with narrower views overflow in single precision, or nearly so.
const LONGEST: f32 = 1e15;
/// From within this distance rays begin at the camera itself: packets of rays with one origin are traced a little faster.
const AT_CAMERA: f64 = 4.0;

/// A perspective camera that is near enough for `f32`: for rays in lanes.
#[derive(Clone, Copy, Debug)]
pub(super) struct NearCamera {
    /// Where it is.
    pub origin: Vec3,
    forward: Vec3,
    right: Vec3,
    up: Vec3,
    /// Rays begin where they are nearer than this to the origin of the rays' frame.
    begin: f32,
}

impl RayCamera {
    /// The camera for lanes, if it is one.
    pub(super) fn near(&self) -> Option<NearCamera> {
        (self.projection == Projection::Perspective && self.origin.length() < NEAR).then(|| NearCamera {
            origin: self.origin.as_vec3(),
            forward: self.forward.as_vec3(),
            right: self.right.as_vec3(),
            up: self.up.as_vec3(),
            begin: if self.origin.length() < AT_CAMERA { f32::INFINITY } else { BEYOND_SCENE as f32 },
        })
    }
}

impl NearCamera {
    /// Origins and unit directions of the rays through picture points in [0, 1]², as [`RayCamera::ray`], and how far from the
    /// camera they begin.
    #[inline(always)]
    pub(super) fn rays<F: Floats>(&self, x: F, y: F) -> (V3<F>, V3<F>, F) {
        let splat = |v: Vec3| V3::new(x.fill(v.x), x.fill(v.y), x.fill(v.z));
        let (across, above) = (x * 2.0 - 1.0, x.fill(1.0) - y * 2.0);
        let dir = splat(self.forward) + splat(self.right) * across + splat(self.up) * above;
        let (origin, dir) = (splat(self.origin), dir.normalized());
        let skipped = (-origin.dot(dir) - self.begin).max(x.fill(0.0));
        (origin + dir * skipped, dir, skipped)
    }
}
