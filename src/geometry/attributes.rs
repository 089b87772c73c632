//! What meshes say of the points of triangles: normals, coordinates of textures, colours, tangents.

use super::Geometry;
use super::parts::Store;
use super::triangles::At;
use crate::lanes::prefetch;
use glam::{Vec2, Vec3, Vec4};
use kiln_formats::Scene;
use kiln_formats::scene::Mesh;

/// Attributes of a mesh at a point of a triangle.
#[derive(Clone, Copy, Debug)]
pub struct Attributes {
    /// Both sets of texture coordinates.
    pub uv: [[f32; 2]; 2],
    /// Linear RGBA factor.
    pub color: Vec4,
    /// World-space shading normal of unit length, where the mesh has normals.
    pub normal: Option<Vec3>,
    /// World-space tangent (not of unit length) and handedness, where the mesh has tangents.
    pub tangent: Option<(Vec3, f32)>,
}

/// What a mesh says of a point beside its normal.
#[derive(Clone, Copy, Debug)]
pub struct Texturing {
    /// Both sets of texture coordinates.
    pub uv: [[f32; 2]; 2],
    /// Twice the triangle's area in each of them.
    pub uv_area: [f32; 2],
    /// Linear RGB factor.
    pub color: Vec3,
    /// As in [`Attributes`]; a handedness of 0 where there is none.
    pub tangent: (Vec3, f32),
}

impl Geometry {
    /// Texture coordinates alone, at barycentric weights `b`.
    pub fn uv(&self, scene: &Scene, triangle: u32, b: [f32; 3]) -> [[f32; 2]; 2] {
        let (mesh, v) = self.source(scene, triangle);
        uv_at(mesh, v, b)
    }

    /// Area in each set of texture coordinates over area in the rays' frame; 0 where there are no coordinates.
    pub fn texture_density(&self, scene: &Scene, triangle: u32) -> [f32; 2] {
        let (mesh, v) = self.source(scene, triangle);
        let [a, b, c] = self.corners(triangle);
        let area = (b - a).cross(c - a).length();
        [0, 1].map(|set| {
            let uvs = &mesh.uvs[set];
            if uvs.is_empty() {
                return 0.0;
            }
            uv_area(uvs, v) / area
        })
    }

    /// Normals at the corners of a triangle on its front, in the rays' frame and not of unit length, where the mesh has normals
    /// (zero where they are no vectors).
    #[inline]
    pub fn corner_normals(&self, triangle: u32) -> Option<[Vec3; 3]> {
        if let Some(record) = self.known_record(triangle) {
            let Store::Own { normals_from, .. } = self.parts[record.part as usize].store else { return None };
            let (first, _) = normals_from?;
            return Some(record.vertices.map(|v| self.vertex_normals[(first + v) as usize]));
        }
        match self.at(triangle) {
            At::Own(at) => {
                let Store::Own { normals_from, .. } = self.part(triangle).store else { return None };
                let (first_normal, first_vertex) = normals_from?;
                Some(self.corners[at].map(|i| self.vertex_normals[(i - first_vertex + first_normal) as usize]))
            }
            At::Shared(_, shape, _) if shape.normals.is_empty() => None,
            At::Shared(part, shape, at) => {
                Some(shape.corners[at].map(|i| part.normal_matrix * shape.normals[i as usize]))
            }
        }
    }

    /// Texture coordinates, colour and, where it is wanted, the tangent, at barycentric weights `b`.
    #[inline]
    pub fn texturing(&self, scene: &Scene, triangle: u32, b: [f32; 3], tangents: bool) -> Texturing {
        let (mesh, v) = self.source(scene, triangle);
        let uv_area = [0, 1].map(|set| if mesh.uvs[set].is_empty() { 0.0 } else { uv_area(&mesh.uvs[set], v) });
        let tangent = match tangents && !mesh.tangents.is_empty() {
            true => self.tangent(mesh, triangle, v, b),
            false => (Vec3::ZERO, 0.0),
        };
        let color = if mesh.colors.is_empty() { Vec3::ONE } else { mix4(&mesh.colors, v, b).truncate() };
        Texturing { uv: uv_at(mesh, v, b), uv_area, color, tangent }
    }

    fn tangent(&self, mesh: &Mesh, triangle: u32, v: [usize; 3], b: [f32; 3]) -> (Vec3, f32) {
        let part = self.part(triangle);
        // A mirrored placement turns the cross product of normal and tangent around, but not the bitangent.
        let handedness = mesh.tangents[v[0]][3] * part.winding;
        (part.direction_matrix * mix4(&mesh.tangents, v, b).truncate(), handedness)
    }

    /// Everything that the mesh says about the point with barycentric weights `b`.
    pub fn attributes(&self, scene: &Scene, triangle: u32, b: [f32; 3]) -> Attributes {
        let (mesh, v) = self.source(scene, triangle);
        let votes = self.corner_normals(triangle);
        let normal = votes.and_then(|n| (n[0] * b[0] + n[1] * b[1] + n[2] * b[2]).try_normalize());
        let tangent = (!mesh.tangents.is_empty()).then(|| self.tangent(mesh, triangle, v, b));
        Attributes { uv: uv_at(mesh, v, b), color: color_at(mesh, v, b), normal, tangent }
    }

    /// Has fetched what will be asked of the vertices of a triangle: normals, and coordinates of textures and tangents. A hint, without
    /// which answers are the same.
    #[inline]
    pub fn expect(&self, scene: &Scene, triangle: u32, normals: bool, texturing: bool, tangents: bool) {
        let Some(record) = self.known_record(triangle) else { return };
        let part = &self.parts[record.part as usize];
        if let Store::Own { normals_from: Some((first, _)), .. } = part.store
            && normals
        {
            prefetch::items(&self.vertex_normals, record.vertices.map(|v| (first + v) as usize));
        }
        if texturing {
            let (mesh, vertices) = (&scene.meshes[part.mesh as usize], record.vertices.map(|v| v as usize));
            for uvs in &mesh.uvs {
                prefetch::items(uvs, vertices);
            }
            if tangents {
                prefetch::items(&mesh.tangents, vertices);
            }
        }
    }
}

fn mix4(values: &[[f32; 4]], v: [usize; 3], b: [f32; 3]) -> Vec4 {
    (0..3).map(|k| Vec4::from(values[v[k]]) * b[k]).sum()
}

/// Twice the area of a triangle in texture coordinates.
fn uv_area(uvs: &[[f32; 2]], v: [usize; 3]) -> f32 {
    let [a, b, c] = v.map(|i| Vec2::from(uvs[i]));
    (b - a).perp_dot(c - a).abs()
}

fn color_at(mesh: &Mesh, v: [usize; 3], b: [f32; 3]) -> Vec4 {
    if mesh.colors.is_empty() { Vec4::ONE } else { mix4(&mesh.colors, v, b) }
}

/// Alpha of the vertex colours.
pub(super) fn vertex_alpha(mesh: &Mesh, v: [usize; 3], b: [f32; 3]) -> f32 {
    if mesh.colors.is_empty() { 1.0 } else { (0..3).map(|k| b[k] * mesh.colors[v[k]][3]).sum() }
}

pub(super) fn uv_at(mesh: &Mesh, v: [usize; 3], b: [f32; 3]) -> [[f32; 2]; 2] {
    let set = |uvs: &[[f32; 2]]| {
        if uvs.is_empty() { [0.0; 2] } else { (0..3).map(|k| Vec2::from(uvs[v[k]]) * b[k]).sum::<Vec2>().into() }
    };
    [set(&mesh.uvs[0]), set(&mesh.uvs[1])]
}
