//! How much work a hit on a part of the scene is, decided once.

use crate::effects::{Knowledge, of_mesh};
use crate::geometry::Geometry;
use crate::settings::{Effect, EffectSet};
use glam::Vec3;
use kiln_formats::Scene;
use kiln_formats::scene::{Material, Mesh, MetalRough, Surface};

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
    /// Whether it bounds a body that another body may touch.
    pub touches: bool,
}

/// The ways of all parts.
pub(crate) fn ways(scene: &Scene, geometry: &Geometry, know: Knowledge) -> Vec<PartWay> {
    let mesh_way = |mesh: &Mesh| {
        let called = of_mesh(scene, mesh);
        let emits = know.asked(called).has_any(&[Effect::Emission, Effect::Unlit]);
        PartWay { way: way(&scene.materials[mesh.material as usize], called, know), emits, touches: false }
    };
    let of_meshes: Vec<_> = scene.meshes.iter().map(mesh_way).collect();
    let mut ways: Vec<_> = geometry.parts.iter().map(|part| of_meshes[part.mesh as usize]).collect();
    for part in touching_parts(scene, geometry) {
        ways[part].touches = true;
    }
    ways
}

/// Whether a material is the boundary of a body that absorbs and refracts.
pub(crate) fn bounds_body(material: &Material) -> bool {
    match &material.surface {
        Surface::MetalRough(m) => m.volume.is_some(),
        Surface::Phong(p) => !p.transmission.is_black(),
        Surface::Unlit(_) => false,
    }
}

/// How near boxes count as touching, in units of the rays' frame: beyond the rounding of its coordinates.
const TOUCHING: f32 = 1e-5;
/// More bodies than this are not compared with each other: all count as touching.
const MOST_BODIES: usize = 2000;

/// The parts that bound bodies and whose boxes touch that of another one.
fn touching_parts(scene: &Scene, geometry: &Geometry) -> Vec<usize> {
    let of_part = |part: &crate::geometry::Part| scene.meshes[part.mesh as usize].material;
    let is_body: Vec<bool> =
        geometry.parts.iter().map(|part| bounds_body(&scene.materials[of_part(part) as usize])).collect();
    let bodies: Vec<usize> = (0..is_body.len()).filter(|part| is_body[*part]).collect();
    if bodies.len() < 2 || bodies.len() > MOST_BODIES {
        return if bodies.len() < 2 { Vec::new() } else { bodies };
    }
    let mut boxes = vec![(Vec3::INFINITY, Vec3::NEG_INFINITY); is_body.len()];
    for triangle in 0..geometry.len() as u32 {
        let part = geometry.part_index(triangle) as usize;
        if is_body[part] {
            for corner in geometry.corners(triangle) {
                boxes[part] = (boxes[part].0.min(corner), boxes[part].1.max(corner));
            }
        }
    }
    let near = |p: usize, q: usize| {
        let gap = (boxes[p].0 - boxes[q].1).max(boxes[q].0 - boxes[p].1);
        gap.max_element() <= TOUCHING
    };
    bodies.iter().copied().filter(|p| bodies.iter().any(|q| p != q && near(*p, *q))).collect()
}

/// The effects that lanes can do; a surface that calls for any other is done one by one.
const IN_LANES: [Effect; 10] = Knowledge::ASKED;
/// What a flat surface of one diffuse colour has not.
const NOT_FLAT: [Effect; 5] =
    [Effect::NormalMaps, Effect::VertexColors, Effect::SmoothNormals, Effect::Specular, Effect::Metal];

fn way(material: &Material, called: EffectSet, know: Knowledge) -> Way {
    let Surface::MetalRough(m) = &material.surface else { return Way::Any };
    let own = know.own(called);
    if m.volume.is_some() || !own.but(IN_LANES.into_iter().collect()).is_empty() {
        return Way::Any;
    }
    match diffuse(m) {
        Some(albedo) if !know.asked(called).has_any(&NOT_FLAT) && !know.forced.has(Effect::Textures) => {
            Way::Diffuse(albedo)
        }
        _ if own.has(Effect::NormalMaps) => Way::Mapped,
        _ => Way::Smooth,
    }
}

/// The albedo of a material without reflection where it is the same everywhere.
fn diffuse(m: &MetalRough) -> Option<Vec3> {
    m.base_color.texture.is_none().then(|| Vec3::from(m.base_color.factor).min(Vec3::ONE))
}
