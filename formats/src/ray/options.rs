use serde::{Deserialize, Serialize};

/// Which family of course tracers a `.ray` file was written for. Nothing in the file says so.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Dialect {
    /// UT Austin, 2016 on.
    #[default]
    Ut,
    /// University of Washington, and UT up to 2015: without `reflective`, `specular` is what mirrors.
    Uw,
    /// HKUST: that, and `shininess` is 0 … 1 for exponents up to 128, materials inherit nothing, and the camera's
    /// directions are brought to unit length.
    Hk,
}

/// What the camera's image plane is made of.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Basis {
    /// `viewdir` and `updir` as they are written, sheared and stretched as in the course tracers.
    #[default]
    Raw,
    /// Perpendicular axes of unit length.
    Orthonormal,
}

/// How `.ray` files are taken.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct RayOptions {
    /// Who wrote the file.
    pub dialect: Dialect,
    /// The camera's axes.
    pub basis: Basis,
    /// The product of `ambient` and the ambient lights is emitted, for pictures like those of course tracers. Those
    /// have nothing else in the place of indirect light, path tracing has.
    pub emit_ambient: bool,
    /// Shadow rays stop at glass instead of going straight through it and taking on its colour.
    pub opaque_glass: bool,
}
