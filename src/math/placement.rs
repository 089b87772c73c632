use glam::{DAffine3, Vec3};

/// An affine map from the coordinates of a mesh to the rays' frame, in double precision.
///
/// Whoever needs the place of a vertex asks this one: shading, and traversal that places triangles as it meets them, have the same
/// bits.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Placement {
    /// For each coordinate of a result: three factors and an addend.
    pub rows: [[f64; 4]; 3],
}

impl Placement {
    /// Leaves points where they are.
    pub const IDENTITY: Self = Self { rows: [[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]] };

    /// A map of matrix and translation.
    pub fn new(map: &DAffine3) -> Self {
        let (x, y, z, from) = (map.matrix3.x_axis, map.matrix3.y_axis, map.matrix3.z_axis, map.translation);
        Self { rows: [0, 1, 2].map(|i| [x[i], y[i], z[i], from[i]]) }
    }

    /// The same as matrix and translation.
    pub fn affine(&self) -> DAffine3 {
        let column = |k: usize| [0, 1, 2].map(|i| self.rows[i][k]).into();
        DAffine3::from_cols(column(0), column(1), column(2), column(3))
    }

    /// One coordinate of the place of a point. No fused operations, so that every machine and SIMD tier rounds alike.
    #[inline(always)]
    pub fn coordinate(row: &[f64; 4], x: f32, y: f32, z: f32) -> f32 {
        (row[0] * f64::from(x) + row[1] * f64::from(y) + row[2] * f64::from(z) + row[3]) as f32
    }

    /// The place of a point.
    #[inline(always)]
    pub fn point(&self, [x, y, z]: [f32; 3]) -> Vec3 {
        let [a, b, c] = &self.rows;
        Vec3::new(Self::coordinate(a, x, y, z), Self::coordinate(b, x, y, z), Self::coordinate(c, x, y, z))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::{DMat3, DVec3};

    #[test]
    fn points_go_where_the_affine_map_takes_them() {
        let matrix =
            DMat3::from_cols(DVec3::new(1.0, 2.0, -0.5), DVec3::new(0.0, -3.0, 1.0), DVec3::new(4.0, 0.25, 1.0));
        let map = DAffine3 { matrix3: matrix, translation: DVec3::new(10.0, -20.0, 30.0) };
        let placement = Placement::new(&map);
        assert_eq!(placement.affine(), map);
        let p = [0.5f32, -1.5, 2.0];
        let expected = map.transform_point3(Vec3::from(p).as_dvec3()).as_vec3();
        assert_eq!(placement.point(p), expected, "exact numbers");
        assert_eq!(Placement::IDENTITY.point(p), Vec3::from(p));
    }
}
