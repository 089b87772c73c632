//! Placements of meshes, and which of them a triangle belongs to.

use crate::math::Placement;
use glam::{DAffine3, Mat3, Vec3};

/// One placement of a mesh: a run of triangles with the attributes of one mesh.
#[derive(Clone, Debug)]
pub struct Part {
    /// Index of the mesh in the scene.
    pub mesh: u32,
    /// The first of its triangles in [`super::Geometry`].
    pub first_triangle: u32,
    /// From the mesh's coordinates to the rays' frame.
    pub placement: Placement,
    /// Where its triangles are kept.
    pub(super) store: Store,
    /// Object directions to world directions (for tangents).
    pub(super) direction_matrix: Mat3,
    /// Unit normals of the object to votes for normals in the world.
    pub(super) normal_matrix: Mat3,
    /// −1 where the placement mirrors the mesh and clockwise corners show the front, else 1.
    pub(super) winding: f32,
}

/// Where the triangles of a part are kept.
#[derive(Clone, Copy, Debug)]
pub(super) enum Store {
    /// In the rays' frame, for this part alone.
    Own {
        /// The first of them.
        first: u32,
        /// Where the normals of its vertices begin, if it has any, and where its vertices begin.
        normals_from: Option<(u32, u32)>,
    },
    /// In a shape that several parts share; they are placed when they are asked for.
    Shape {
        /// Its number.
        shape: u32,
        /// The box around them in the rays' frame.
        bounds: (Vec3, Vec3),
    },
}

impl Part {
    /// A placement by `transform` (to the world) and `placement` (to the rays' frame).
    pub(super) fn new(
        mesh: u32,
        first_triangle: u32,
        transform: &DAffine3,
        placement: Placement,
        store: Store,
    ) -> Self {
        // Cofactors, det·M⁻ᵀ, instead of the inverse transpose: right for singular matrices too.
        let m = transform.matrix3;
        let (x, y, z) = (m.x_axis, m.y_axis, m.z_axis);
        let size = x.abs().max(y.abs()).max(z.abs()).max_element();
        let unit = if size > 0.0 && size.is_finite() { 1.0 / size } else { 1.0 };
        let (x, y, z) = (x * unit, y * unit, z * unit);
        let winding = if x.cross(y).dot(z) < 0.0 { -1.0 } else { 1.0 };
        let normals = [y.cross(z), z.cross(x), x.cross(y)].map(|n| n.as_vec3() * winding);
        Self {
            mesh,
            first_triangle,
            placement,
            store,
            direction_matrix: Mat3::from_cols(x.as_vec3(), y.as_vec3(), z.as_vec3()),
            normal_matrix: Mat3::from_cols(normals[0], normals[1], normals[2]),
            winding,
        }
    }
}

/// Finds the part of a triangle by a table of buckets of triangles, each of which begins in a known part.
#[derive(Debug, Default)]
pub(super) struct PartIndex {
    /// The first triangle of each part.
    firsts: Vec<u32>,
    /// For each bucket, and for one behind the last, the part of its first triangle.
    buckets: Vec<u32>,
    /// A bucket has two to the power of this many triangles.
    shift: u32,
}

impl PartIndex {
    /// Of parts in the order of their triangles, of which there are `triangles`.
    pub fn new(parts: &[Part], triangles: u32) -> Self {
        let firsts: Vec<u32> = parts.iter().map(|part| part.first_triangle).collect();
        let wanted = u64::from(triangles).min(4 * parts.len() as u64).max(1);
        let shift = (u64::from(triangles) / wanted).max(1).ilog2();
        let count = (triangles >> shift) + 1;
        let part_at = |triangle: u32| firsts.partition_point(|first| *first <= triangle).saturating_sub(1) as u32;
        let buckets = (0..=count).map(|k| part_at(k.checked_shl(shift).unwrap_or(u32::MAX).min(triangles))).collect();
        Self { firsts, buckets, shift }
    }

    /// The part of a triangle. Parts without triangles have none.
    #[inline]
    pub fn find(&self, triangle: u32) -> u32 {
        let bucket = (triangle >> self.shift) as usize;
        let (first, last) = (self.buckets[bucket], self.buckets[bucket + 1]);
        if first == last {
            return first;
        }
        let later = &self.firsts[first as usize + 1..=last as usize];
        first + later.partition_point(|begin| *begin <= triangle) as u32
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_triangle_is_found_in_its_part() {
        let runs: [&[u32]; 6] =
            [&[5], &[0, 1, 0, 3], &[1000, 1, 1, 0, 1, 2, 700, 0], &[0, 0, 2, 0], &[1; 300], &[2, 3000, 0, 0]];
        for run in runs {
            let store = Store::Own { first: 0, normals_from: None };
            let mut end = 0;
            let part = |count: &u32| {
                let part = Part::new(0, end, &DAffine3::IDENTITY, Placement::IDENTITY, store);
                end += count;
                part
            };
            let parts: Vec<Part> = run.iter().map(part).collect();
            let index = PartIndex::new(&parts, end);
            let expected = run.iter().enumerate().flat_map(|(k, count)| vec![k as u32; *count as usize]);
            assert!(expected.eq((0..end).map(|t| index.find(t))), "{run:?}");
        }
    }
}
