use glam::Vec3;

/// A half-open piece of a line: points `origin + t·dir` with `0 < t < t_max`. `dir` need not be of unit length.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ray {
    /// Where it begins.
    pub origin: Vec3,
    /// Where it goes; finite and not zero.
    pub dir: Vec3,
    /// Where it ends, in units of `dir`; may be infinite.
    pub t_max: f32,
}

/// A point of a triangle on a ray.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hit {
    /// Distance in units of the ray's direction.
    pub t: f32,
    /// The triangle.
    pub triangle: u32,
    /// Barycentric weight of the triangle's second corner.
    pub b1: f32,
    /// Barycentric weight of the triangle's third corner.
    pub b2: f32,
}
