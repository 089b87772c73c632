//! How much work a hit on a part of the scene is, decided once.

use crate::geometry::Geometry;
use glam::Vec3;
use kiln_formats::Scene;
use kiln_formats::scene::{Material, Mesh, MetalRough, ScalarInput, Surface};

/// Which way of shading a part's triangles can take.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Way {
    /// Flat triangles of one diffuse colour: all in lanes.
    Diffuse(Vec3),
    /// The geometry in lanes; textures and lobes, which nearly always are diffuse, or rough and reflecting, one by one; the rest
    /// in lanes.
    Smooth,
    /// The same, with a normal map: the whole vertex one by one.
    Mapped,
    /// Everything one by one.
    Any,
}

/// What shading has to know of a part before it looks at anything else.
#[derive(Clone, Copy, Debug)]
pub(crate) struct PartWay {
    /// The way of shading.
    pub way: Way,
    /// Whether its surface may emit.
    pub emits: bool,
}

/// The ways of all parts.
pub(crate) fn ways(scene: &Scene, geometry: &Geometry) -> Vec<PartWay> {
    let part_way = |mesh: &Mesh| {
        let material = &scene.materials[mesh.material as usize];
        let emits = match &material.surface {
            Surface::Unlit(shown) => !shown.is_black(),
            _ => !material.emission.is_black(),
        };
        PartWay { way: way(mesh, material), emits }
    };
    geometry.parts.iter().map(|part| part_way(&scene.meshes[part.mesh as usize])).collect()
}

fn way(mesh: &Mesh, material: &Material) -> Way {
    let Surface::MetalRough(m) = &material.surface else { return Way::Any };
    if m.transmission.factor != 0.0 || m.transmission.bias != 0.0 || m.volume.is_some() || m.layers.is_some() {
        return Way::Any;
    }
    match diffuse(m) {
        Some(albedo) if material.normal_map.is_none() && mesh.normals.is_empty() && mesh.colors.is_empty() => {
            Way::Diffuse(albedo)
        }
        _ if material.normal_map.is_none() => Way::Smooth,
        _ => Way::Mapped,
    }
}

/// The albedo of a material that is Lambert's and the same everywhere.
fn diffuse(m: &MetalRough) -> Option<Vec3> {
    let zero = |s: &ScalarInput| s.factor == 0.0 && s.bias == 0.0;
    let flat = m.base_color.texture.is_none() && zero(&m.metallic) && zero(&m.specular);
    flat.then(|| Vec3::from(m.base_color.factor).min(Vec3::ONE))
}
