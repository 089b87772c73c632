use kiln_formats::Scene;
use kiln_formats::scene::{Mesh, Pixels};
use serde::Serialize;

/// What a scene holds beside positions and triangles.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct AttributeBytes {
    /// Normals, tangents, texture coordinates and colours of vertices.
    pub held: u64,
    /// What these would be if every vertex had all of them.
    pub full: u64,
    /// Pixels of images.
    pub images: u64,
}

/// Counts them.
pub fn attribute_bytes(scene: &Scene) -> AttributeBytes {
    let of_mesh = |mesh: &Mesh| {
        let Mesh { normals, tangents, uvs, colors, .. } = mesh;
        size_of_val(normals.as_slice())
            + size_of_val(tangents.as_slice())
            + uvs.iter().map(|set| size_of_val(set.as_slice())).sum::<usize>()
            + size_of_val(colors.as_slice())
    };
    // Normal, tangent, two sets of coordinates, colour.
    let whole = size_of::<[f32; 3 + 4 + 2 + 2 + 4]>();
    let of_pixels = |pixels: &Pixels| match pixels {
        Pixels::Rgba8(p) => size_of_val(p.as_slice()),
        Pixels::Rgba16(p) => size_of_val(p.as_slice()),
        Pixels::RgbaF32(p) => size_of_val(p.as_slice()),
    };
    AttributeBytes {
        held: scene.meshes.iter().map(of_mesh).sum::<usize>() as u64,
        full: scene.meshes.iter().map(|mesh| mesh.positions.len() * whole).sum::<usize>() as u64,
        images: scene.images.iter().map(|image| of_pixels(&image.pixels)).sum::<usize>() as u64,
    }
}
