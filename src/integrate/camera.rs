use crate::geometry::WorldFrame;
use glam::Vec3;
use kiln_formats::scene::{Camera, Projection};

/// A camera in the rays' frame.
#[derive(Clone, Copy, Debug)]
pub(super) struct RayCamera {
    projection: Projection,
    origin: Vec3,
    forward: Vec3,
    right: Vec3,
    up: Vec3,
}

impl RayCamera {
    pub(super) fn new(camera: &Camera, frame: &WorldFrame) -> Self {
        // A perspective image plane may be scaled as a whole: only directions count.
        let perspective = camera.projection == Projection::Perspective;
        let unit = if perspective { 1.0 / camera.forward.length() } else { frame.scale() };
        Self {
            projection: camera.projection,
            origin: frame.point(camera.origin),
            forward: if perspective { camera.forward * unit } else { camera.forward.normalize() }.as_vec3(),
            right: (camera.right * unit).as_vec3(),
            up: (camera.up * unit).as_vec3(),
        }
    }

    /// Origin and unit direction of the ray through the picture point (x, y) in [0, 1]², (0, 0) being the upper left.
    pub(super) fn ray(&self, x: f32, y: f32) -> (Vec3, Vec3) {
        let across = self.right * (2.0 * x - 1.0) + self.up * (1.0 - 2.0 * y);
        match self.projection {
            Projection::Perspective => (self.origin, (self.forward + across).normalize()),
            Projection::Orthographic => (self.origin + across, self.forward),
        }
    }
}
