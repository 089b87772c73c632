use super::Geometry;
use super::attributes::{uv_at, vertex_alpha};
use super::textures::scalar;
use kiln_formats::Scene;
use kiln_formats::scene::AlphaMode;

/// The share of rays through barycentric weights `b` of a triangle that the surface stops, in [0, 1].
pub fn coverage(scene: &Scene, geometry: &Geometry, triangle: u32, b: [f32; 3]) -> f32 {
    let (mesh, v) = geometry.source(scene, triangle);
    let material = &scene.materials[mesh.material as usize];
    if material.alpha.mode == AlphaMode::Opaque {
        return 1.0;
    }
    let value = &material.alpha.value;
    let uv = if value.texture.is_some() { uv_at(mesh, v, b) } else { [[0.0; 2]; 2] };
    let alpha = scalar(scene, value, &uv) * vertex_alpha(mesh, v, b);
    match material.alpha.mode {
        AlphaMode::Opaque => 1.0,
        AlphaMode::Mask { cutoff } => f32::from(alpha >= cutoff),
        AlphaMode::Blend => alpha.clamp(0.0, 1.0),
    }
}
