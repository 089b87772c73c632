use super::{Floats, V3};

/// [`crate::math::Frame`] in lanes.
#[derive(Clone, Copy, Debug)]
pub struct FrameLanes<F> {
    /// First tangents.
    pub x: V3<F>,
    /// Second tangents.
    pub y: V3<F>,
    /// Normals.
    pub z: V3<F>,
}

impl<F: Floats> FrameLanes<F> {
    /// See [`crate::math::Frame::from_normal`].
    #[inline(always)]
    pub fn from_normal(n: V3<F>) -> Self {
        let one = n.z.fill(1.0);
        let sign = one.copysign(n.z);
        let a = -one / (sign + n.z);
        let b = n.x * n.y * a;
        Self {
            x: V3::new(one + sign * n.x * n.x * a, sign * b, -sign * n.x),
            y: V3::new(b, sign + n.y * n.y * a, -n.y),
            z: n,
        }
    }

    /// Components of world vectors along the bases.
    #[inline(always)]
    pub fn to_local(self, v: V3<F>) -> V3<F> {
        V3::new(v.dot(self.x), v.dot(self.y), v.dot(self.z))
    }

    /// The world vectors with these components.
    #[inline(always)]
    pub fn to_world(self, v: V3<F>) -> V3<F> {
        self.x * v.x + self.y * v.y + self.z * v.z
    }
}
