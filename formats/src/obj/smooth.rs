//! Smoothing groups: normals for faces that have none.

use crate::scene::Mesh;
use glam::DVec3;
use std::collections::HashMap;

/// A corner of the surface: faces of one group that meet at a position share a normal there.
type Corner = (u32, [u32; 3]);

fn at(group: u32, position: [f32; 3]) -> Corner {
    // Both zeros are one place.
    (group, position.map(|x| (x + 0.0).to_bits()))
}

/// Gives meshes normals by the groups of their triangles, which `groups` lists for each mesh: the mean of the faces'
/// normals at a corner, weighted by their angles there (Thürmer & Wüthrich 1998), over all meshes, so that a change of
/// material is no crease. An empty list leaves its mesh as it is. Vertices on the borders of groups are doubled.
pub(super) fn smooth(meshes: &mut [Mesh], groups: &[Vec<u32>]) {
    let mut sums: HashMap<Corner, DVec3> = HashMap::new();
    for (mesh, groups) in meshes.iter().zip(groups) {
        for (triangle, group) in mesh.triangles.iter().zip(groups) {
            let places = triangle.map(|i| mesh.positions.get(i as usize).copied().unwrap_or_default());
            let [a, b, c] = places.map(|p| DVec3::from_array(p.map(f64::from)));
            let Some(normal) = (b - a).cross(c - a).try_normalize() else { continue };
            let angles = [angle(a, b, c), angle(b, c, a), angle(c, a, b)];
            for (place, angle) in places.into_iter().zip(angles) {
                *sums.entry(at(*group, place)).or_default() += normal * angle;
            }
        }
    }
    for (mesh, groups) in meshes.iter_mut().zip(groups).filter(|(_, groups)| !groups.is_empty()) {
        split(mesh, groups);
        // Opposite faces cancel out: what is left has no normal that is better than another.
        let mut normals = vec![[0.0, 0.0, 1.0]; mesh.positions.len()];
        for (triangle, group) in mesh.triangles.iter().zip(groups) {
            for i in triangle {
                let sum = mesh.positions.get(*i as usize).and_then(|p| sums.get(&at(*group, *p)));
                if let (Some(normal), Some(slot)) = (sum.and_then(|s| s.try_normalize()), normals.get_mut(*i as usize))
                {
                    *slot = normal.as_vec3().to_array();
                }
            }
        }
        mesh.normals = normals;
    }
}

/// The angle at `a`.
fn angle(a: DVec3, b: DVec3, c: DVec3) -> f64 {
    let (u, v) = (b - a, c - a);
    libm::atan2(u.cross(v).length(), u.dot(v))
}

/// Doubles the vertices that triangles of several groups share.
fn split(mesh: &mut Mesh, groups: &[u32]) {
    let mut owners: Vec<Option<u32>> = vec![None; mesh.positions.len()];
    let mut copies: HashMap<(u32, u32), u32> = HashMap::new();
    for (triangle, group) in mesh.triangles.iter_mut().zip(groups) {
        for corner in triangle {
            let vertex = *corner as usize;
            let Some(owner) = owners.get_mut(vertex) else { continue };
            if *owner.get_or_insert(*group) == *group {
                continue;
            }
            *corner = *copies.entry((*corner, *group)).or_insert_with(|| {
                mesh.positions.extend_from_within(vertex..=vertex);
                for list in &mut mesh.uvs {
                    if !list.is_empty() {
                        list.extend_from_within(vertex..=vertex);
                    }
                }
                if !mesh.colors.is_empty() {
                    mesh.colors.extend_from_within(vertex..=vertex);
                }
                (mesh.positions.len() - 1) as u32
            });
        }
    }
}
