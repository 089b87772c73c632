use glam::DVec3;

/// Fall-off of irradiance with the distance d from a punctual light.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Falloff {
    /// 1/d², as light does; with a `range`, times glTF's window `max(min(1 − (d/range)⁴, 1), 0)`.
    InverseSquare {
        /// Distance beyond which the light is zero (KHR_lights_punctual), world units.
        range: Option<f64>,
    },
    /// `min(1, 1 / (constant + linear·d + quadratic·d²))`, the `.ray` rule; not physical, kept for fidelity.
    Clamped {
        /// a, without unit.
        constant: f64,
        /// b, per world unit.
        linear: f64,
        /// c, per world unit squared.
        quadratic: f64,
    },
}

/// Where the shadow rays of a point light end.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Extent {
    /// At the light's position: hard shadows.
    Point,
    /// On a disc around the position that faces the shaded point. Direction, cosine and fall-off are still the
    /// centre's: the `area_light` of `.ray`, "point shading times visible fraction".
    Disc {
        /// Radius in world units, > 0.
        radius: f64,
    },
    /// On the parallelogram `position ± u ± v`; each sampled point shades as a point light there.
    Parallelogram {
        /// Half of one edge.
        u: DVec3,
        /// Half of the other edge.
        v: DVec3,
    },
}

/// The kinds of light that are not surfaces.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum LightKind {
    /// Parallel light; `Light::color` is the irradiance on a surface that faces it.
    Directional,
    /// Light from a place; `Light::color` is the radiant intensity.
    Point {
        /// Fall-off with distance.
        falloff: Falloff,
        /// What makes its shadows soft.
        extent: Extent,
    },
    /// A cone of light; `Light::color` is the radiant intensity on its axis.
    Spot {
        /// Fall-off with distance.
        falloff: Falloff,
        /// Angle from the axis up to which the light is full, radians.
        inner: f64,
        /// Angle from the axis beyond which there is none, radians; `inner < outer ≤ π/2`.
        outer: f64,
    },
}

/// A light that is not a surface.
#[derive(Clone, Debug)]
pub struct Light {
    /// Name in the file, or empty.
    pub name: String,
    /// What kind of light, and its shape.
    pub kind: LightKind,
    /// Linear RGB: intensity (W/sr) of point and spot lights, irradiance (W/m²) of directional ones.
    /// For a Lambert surface of albedo ρ the reflected radiance is ρ/π · color · cos · fall-off.
    pub color: [f32; 3],
    /// Place of point and spot lights, world space.
    pub position: DVec3,
    /// The unit vector along which light travels (directional and spot), world space.
    pub direction: DVec3,
    /// Whether shadow rays of this light go straight through transmissive `.ray` bodies and take on their colour,
    /// as the course tracers do; else transmissive surfaces block them.
    pub through_glass: bool,
}
