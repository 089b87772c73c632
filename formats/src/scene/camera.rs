use glam::DVec3;

/// How picture points become rays.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Projection {
    /// Rays leave `origin` towards `forward + sx·right + sy·up`.
    Perspective,
    /// Rays leave `origin + sx·right + sy·up` along `forward`.
    Orthographic,
}

/// A camera as an image plane, so that the sheared and scaled planes of `.ray` files need no special case.
///
/// `sx` and `sy` run over [−1, 1] from the left to the right and from the bottom to the top edge of the picture.
#[derive(Clone, Debug, PartialEq)]
pub struct Camera {
    /// Name in the file, or empty.
    pub name: String,
    /// Perspective or orthographic.
    pub projection: Projection,
    /// Eye, world space.
    pub origin: DVec3,
    /// From the eye to the middle of the image plane. Its length counts (`right` and `up` are measured there).
    pub forward: DVec3,
    /// From the middle of the image plane to the middle of its right edge.
    pub right: DVec3,
    /// From the middle of the image plane to the middle of its upper edge. Need not be perpendicular to the others.
    pub up: DVec3,
    /// Width / height of the picture that `right` and `up` are meant for (not |right| : |up| where the plane is sheared or
    /// scaled), if the file fixes it. If not, `up` counts and the width follows the picture.
    pub aspect: Option<f64>,
}

impl Camera {
    /// A perspective camera without shear.
    ///
    /// `vertical_fov` in radians, `aspect` = width / height. `up` need not be perpendicular or of unit length.
    pub fn perspective(origin: DVec3, forward: DVec3, up: DVec3, vertical_fov: f64, aspect: f64) -> Self {
        let forward = forward.normalize();
        let right = forward.cross(up).normalize();
        let half = libm::tan(0.5 * vertical_fov);
        Self {
            name: String::new(),
            projection: Projection::Perspective,
            origin,
            forward,
            right: right * (half * aspect),
            up: right.cross(forward) * half,
            aspect: None,
        }
    }
}
