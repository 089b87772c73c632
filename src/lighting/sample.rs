//! What is asked of the lights, and what they answer.

use glam::Vec3;

/// Which lights a light sample chooses among.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LightReach {
    /// Punctual lights: what BSDF sampling can never find.
    Punctual,
    /// Those, emissive triangles, and the environment unless it is constant: BSDF sampling does a constant one
    /// better, without any noise where nothing is in the way.
    Mis,
    /// All.
    All,
}

/// What is chosen first.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Group {
    /// A light without a place or a natural fall-off.
    Global(usize),
    /// All other punctual lights.
    Local,
    /// Emissive triangles.
    Triangles,
    /// The environment.
    Environment,
}

/// Where the shadow ray of a light sample ends.
#[derive(Clone, Copy, Debug)]
pub enum Target {
    /// At a point in the open.
    Point(Vec3),
    /// On an emissive triangle, with a bound on the point's rounding error and the geometric normal.
    Triangle {
        /// The triangle.
        triangle: u32,
        /// The point on it.
        point: Vec3,
        /// Bound on each coordinate's error.
        error: Vec3,
        /// Unit normal of the triangle.
        normal: Vec3,
    },
    /// At infinity.
    Infinity,
}

/// Light that may arrive at a point.
#[derive(Clone, Copy, Debug)]
pub struct LightSample {
    /// Unit vector to the light.
    pub direction: Vec3,
    /// Radiance, or the irradiance of a punctual light, already divided by `pdf`.
    pub weight: Vec3,
    /// Solid angle density of `direction` with the choice of the light; `None` for punctual lights.
    pub pdf: Option<f32>,
    /// Where the shadow ray ends.
    pub target: Target,
    /// Shadow rays take on the colour of `.ray` glass.
    pub through_glass: bool,
}
