//! How much work a hit on a part of the scene is, decided once.

use super::Filters;
use crate::effects::{Knowledge, of_mesh};
use crate::geometry::{Geometry, emission};
use crate::settings::{Effect, EffectSet};
use glam::Vec3;
use kiln_formats::Scene;
use kiln_formats::scene::{Material, Mesh, MetalRough, ScalarInput, Surface};

/// Which way of shading a part's triangles can take.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Way {
    /// Flat triangles of one diffuse colour: all in lanes.
    Diffuse(Vec3),
    /// Normals, textures and lobes that are looked up in lanes, too.
    Rough,
    /// Smooth glass that bounds a solid and is the same everywhere: the bodies that a path is in one by one, all else in lanes.
    Glass,
    /// Everything one by one.
    Any,
}

/// What shading has to know of a part before it looks at anything else.
#[derive(Clone, Copy, Debug)]
pub(crate) struct PartWay {
    /// The way of shading.
    pub way: Way,
    /// What a traversal has to ask about its triangles.
    pub filters: Filters,
    /// Whether its surface may emit.
    pub emits: bool,
    /// What its fronts emit, and its backs, where that is the same everywhere.
    pub glow: Option<[Vec3; 2]>,
    /// Whether its normals are interpolated between corners.
    pub smooth: bool,
    /// Whether its look needs coordinates or colours of a point.
    pub textured: bool,
    /// Whether it has a normal map.
    pub mapped: bool,
    /// Whether it may have a clear coat.
    pub coated: bool,
    /// Whether it bounds a body that another body may touch.
    pub touches: bool,
}

/// The ways of all parts.
pub(crate) fn ways(scene: &Scene, geometry: &Geometry, know: Knowledge, filters: &[Filters]) -> Vec<PartWay> {
    let disperses = scene.materials.iter().any(disperses);
    let mesh_way = |mesh: &Mesh| {
        let called = of_mesh(scene, mesh);
        let (asked, material) = (know.asked(called), &scene.materials[mesh.material as usize]);
        let way = if !disperses && smooth_glass(material, called) { Way::Glass } else { way(material, called, know) };
        PartWay {
            way,
            filters: filters[mesh.material as usize],
            emits: asked.has_any(&[Effect::Emission, Effect::Unlit]),
            glow: if know.forced.has(Effect::Textures) { None } else { emission::everywhere(material) },
            smooth: asked.has(Effect::SmoothNormals),
            textured: asked.has_any(&[Effect::Textures, Effect::NormalMaps, Effect::VertexColors]),
            mapped: asked.has(Effect::NormalMaps),
            // With layers of no strength lobes are chosen in another order, whoever is beside them.
            coated: asked.has(Effect::Clearcoat) || material.layers().is_some(),
            touches: false,
        }
    };
    let of_meshes: Vec<_> = scene.meshes.iter().map(mesh_way).collect();
    let mut ways: Vec<_> = geometry.parts.iter().map(|part| of_meshes[part.mesh as usize]).collect();
    for part in touching_parts(scene, geometry) {
        ways[part].touches = true;
        if ways[part].way == Way::Glass {
            ways[part].way = Way::Any;
        }
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

/// What a flat surface of one diffuse colour has not.
const NOT_FLAT: [Effect; 7] = [
    Effect::NormalMaps,
    Effect::VertexColors,
    Effect::SmoothNormals,
    Effect::Specular,
    Effect::Metal,
    Effect::Transmission,
    Effect::Clearcoat,
];

/// The effects that lanes can do; a surface that calls for any other is done one by one.
fn in_lanes() -> EffectSet {
    Knowledge::ASKED.into_iter().chain([Effect::Transmission]).collect()
}

fn way(material: &Material, called: EffectSet, know: Knowledge) -> Way {
    let Surface::MetalRough(m) = &material.surface else { return Way::Any };
    let own = know.own(called);
    if m.volume.is_some() || !own.but(in_lanes()).is_empty() {
        return Way::Any;
    }
    match diffuse(m) {
        Some(albedo) if !know.asked(called).has_any(&NOT_FLAT) && !know.forced.has(Effect::Textures) => {
            Way::Diffuse(albedo)
        }
        _ => Way::Rough,
    }
}

/// Whether a mesh that is drawn is diffuse and nothing else, and can be shaded in lanes.
pub(crate) fn has_diffuse(scene: &Scene) -> bool {
    scene.instances.iter().any(|instance| {
        let mesh = &scene.meshes[instance.mesh as usize];
        let (surface, called) = (&scene.materials[mesh.material as usize].surface, of_mesh(scene, mesh));
        let lanes = matches!(surface, Surface::MetalRough(m) if m.volume.is_none());
        lanes
            && called.but(in_lanes()).is_empty()
            && !called.has_any(&[Effect::Specular, Effect::Metal, Effect::Transmission, Effect::Clearcoat])
    })
}

/// Whether a material spreads light by wavelength.
fn disperses(material: &Material) -> bool {
    matches!(&material.surface, Surface::MetalRough(m) if m.volume.is_some() && m.dispersion > 0.0)
}

/// Roughnesses below this are smooth for the renderer, and some above.
const SMOOTH: f32 = 0.03;

/// Whether a material is glass that bounds a solid, smooth, and reads no texture.
fn smooth_glass(material: &Material, called: EffectSet) -> bool {
    let Surface::MetalRough(m) = &material.surface else { return false };
    let constant = |s: &ScalarInput| s.bias + s.factor;
    let clear = m.volume.is_some() && m.layers.is_none() && m.ior > 0.0;
    let pure = constant(&m.transmission) == 1.0 && constant(&m.metallic) == 0.0 && constant(&m.roughness) < SMOOTH;
    clear && pure && !called.has_any(&[Effect::Textures, Effect::NormalMaps, Effect::VertexColors])
}

/// The albedo of a material without reflection where it is the same everywhere.
fn diffuse(m: &MetalRough) -> Option<Vec3> {
    m.base_color.texture.is_none().then(|| Vec3::from(m.base_color.factor).min(Vec3::ONE))
}
