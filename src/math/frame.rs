use glam::Vec3;

/// A right-handed orthonormal basis: x and y tangents, z the normal.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Frame {
    /// First tangent.
    pub x: Vec3,
    /// Second tangent.
    pub y: Vec3,
    /// Normal.
    pub z: Vec3,
}

impl Frame {
    /// The basis around a unit normal, without branches that could divide by zero: Duff et al. 2017, "Building an
    /// Orthonormal Basis, Revisited", JCGT 6(1), listing 3.
    #[inline]
    pub fn from_normal(normal: Vec3) -> Self {
        let n = normal;
        let sign = 1f32.copysign(n.z);
        let a = -1.0 / (sign + n.z);
        let b = n.x * n.y * a;
        Self {
            x: Vec3::new(1.0 + sign * n.x * n.x * a, sign * b, -sign * n.x),
            y: Vec3::new(b, sign + n.y * n.y * a, -n.y),
            z: n,
        }
    }

    /// The basis around a unit normal whose x is as near to `tangent` as can be; any basis where that lies along the normal.
    pub fn from_normal_and_tangent(normal: Vec3, tangent: Vec3) -> Self {
        match (tangent - normal * normal.dot(tangent)).try_normalize() {
            Some(x) => Self { x, y: normal.cross(x), z: normal },
            None => Self::from_normal(normal),
        }
    }

    /// Components of a world vector along the basis.
    #[inline]
    pub fn to_local(&self, v_world: Vec3) -> Vec3 {
        Vec3::new(v_world.dot(self.x), v_world.dot(self.y), v_world.dot(self.z))
    }

    /// The world vector with these components.
    #[inline]
    pub fn to_world(&self, v_local: Vec3) -> Vec3 {
        self.x * v_local.x + self.y * v_local.y + self.z * v_local.z
    }
}

#[cfg(test)]
mod tests {
    use super::Frame;
    use crate::math::warp;
    use glam::Vec3;

    #[test]
    fn bases_are_orthonormal_and_right_handed_for_every_normal() {
        let mut normals = vec![Vec3::Z, -Vec3::Z, Vec3::new(0.0, 0.0, -1.0), Vec3::X, -Vec3::Y];
        normals.extend([1e-4f32, 1e-8, 1e-20].map(|e| Vec3::new(e, -e, -1.0).normalize()));
        for i in 0..64u8 {
            for j in 0..64u8 {
                normals.push(warp::uniform_sphere([(f32::from(i) + 0.5) / 64.0, (f32::from(j) + 0.5) / 64.0]));
            }
        }
        for n in normals {
            let f = Frame::from_normal(n);
            for (a, b, expected) in
                [(f.x, f.x, 1.0), (f.y, f.y, 1.0), (f.x, f.y, 0.0), (f.x, f.z, 0.0), (f.y, f.z, 0.0)]
            {
                assert!((a.dot(b) - expected).abs() < 1e-6, "normal {n}: {a}·{b} = {}", a.dot(b));
            }
            assert!(f.x.cross(f.y).dot(f.z) > 0.999_999, "normal {n} gives a left-handed basis");
        }
    }

    #[test]
    fn to_world_undoes_to_local() {
        let f = Frame::from_normal(Vec3::new(0.3, -0.5, 0.2).normalize());
        let v = Vec3::new(0.25, -1.5, 3.0);
        assert!((f.to_world(f.to_local(v)) - v).length() < 1e-6);
        assert!((f.to_local(f.z) - Vec3::Z).length() < 1e-6, "the normal is the local +z");
    }
}
