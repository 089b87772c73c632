use crate::settings::{Effect, EffectSet};
use kiln_formats::Scene;
use kiln_formats::scene::{AlphaMode, ColorInput, Layers, LightKind, Material, MaterialId, Mesh, ScalarInput, Surface};
use serde::Serialize;
use std::collections::BTreeSet;

/// An effect that a scene calls for, and why.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Called {
    /// The effect.
    pub effect: Effect,
    /// The reason, for people: `material 'Glass' on 2 meshes, 1.3 % of the area`.
    pub reason: String,
    /// Share of the drawn area that calls for it, in [0, 1]; `None` where it is no matter of surfaces.
    pub area: Option<f64>,
}

/// The effects that a scene calls for, in the order of [`Effect::ALL`]. `areas` are those of the scene's meshes, all
/// placements of each together, in any unit; what has none is not drawn. The environment is not the scene's.
pub fn called_for(scene: &Scene, areas: &[f64]) -> Vec<Called> {
    let drawn: Vec<(&Mesh, f64)> =
        scene.meshes.iter().zip(areas.iter().copied()).filter(|(_, area)| *area > 0.0).collect();
    let all: f64 = drawn.iter().map(|(_, area)| area).sum();
    Effect::ALL
        .into_iter()
        .filter_map(|effect| by_lights(scene, effect).or_else(|| by_surfaces(scene, &drawn, all, effect)))
        .collect()
}

fn by_surfaces(scene: &Scene, drawn: &[(&Mesh, f64)], all: f64, effect: Effect) -> Option<Called> {
    let mut materials = BTreeSet::new();
    let (mut meshes, mut area) = (0, 0.0);
    for (mesh, own) in drawn {
        let mut calling = materials_of(mesh);
        calling.retain(|id| calls(mesh, &scene.materials[*id as usize], effect));
        if !calling.is_empty() {
            (meshes, area) = (meshes + 1, area + own);
            materials.extend(calling);
        }
    }
    if meshes == 0 {
        return None;
    }
    let share = area / all;
    let on = format!("{meshes} mesh{}, {} of the area", if meshes == 1 { "" } else { "es" }, percent(share));
    let reason = match effect {
        Effect::VertexColors | Effect::SmoothNormals => on,
        _ => format!("{} on {on}", names(scene, &materials)),
    };
    Some(Called { effect, reason, area: Some(share) })
}

/// The effects that a mesh's surfaces call for.
pub fn of_mesh(scene: &Scene, mesh: &Mesh) -> EffectSet {
    let materials: Vec<_> = materials_of(mesh).into_iter().map(|id| &scene.materials[id as usize]).collect();
    Effect::ALL.into_iter().filter(|effect| materials.iter().any(|material| calls(mesh, material, *effect))).collect()
}

fn materials_of(mesh: &Mesh) -> BTreeSet<MaterialId> {
    std::iter::once(mesh.material).chain(mesh.vertex_materials.iter().copied()).collect()
}

fn percent(share: f64) -> String {
    match 100.0 * share {
        p if p < 0.1 => "under 0.1 %".into(),
        p if p > 99.95 => "all".into(),
        p => format!("{p:.1} %"),
    }
}

/// `material 'A'`, `materials 'A', 'B' and 3 more`.
fn names(scene: &Scene, materials: &BTreeSet<MaterialId>) -> String {
    const LISTED: usize = 3;
    let name = |id: &MaterialId| match scene.materials[*id as usize].name.as_str() {
        "" => format!("{id}"),
        name => format!("'{name}'"),
    };
    let listed: Vec<_> = materials.iter().take(LISTED).map(name).collect();
    let more = materials.len() - listed.len();
    let plural = if materials.len() == 1 { "" } else { "s" };
    let rest = if more > 0 { format!(" and {more} more") } else { String::new() };
    format!("material{plural} {}{rest}", listed.join(", "))
}

fn by_lights(scene: &Scene, effect: Effect) -> Option<Called> {
    let directional = |kind: &LightKind| *kind == LightKind::Directional;
    let count = |wanted: &dyn Fn(&kiln_formats::scene::Light) -> bool| {
        scene.lights.iter().filter(|light| light.color != [0.0; 3] && wanted(light)).count()
    };
    let (number, what) = match effect {
        Effect::PointLights => (count(&|l| !directional(&l.kind)), "point or spot light"),
        Effect::DirectionalLights => (count(&|l| directional(&l.kind)), "directional light"),
        Effect::SoftShadows => (count(&is_soft), "light with an extent"),
        Effect::TintedShadows if scene.materials.iter().any(transmits) => {
            (count(&|l| l.through_glass), "light that shines through bodies")
        }
        _ => return None,
    };
    let plural = if number == 1 { "" } else { "s" };
    let what = match what.split_once(' ') {
        Some(("light", rest)) => format!("light{plural} {rest}"),
        _ => format!("{what}{plural}"),
    };
    (number > 0).then(|| Called { effect, reason: format!("{number} {what}"), area: None })
}

fn is_soft(light: &kiln_formats::scene::Light) -> bool {
    use kiln_formats::scene::Extent;
    matches!(&light.kind, LightKind::Point { extent, .. } if *extent != Extent::Point)
}

fn is_some(input: &ScalarInput) -> bool {
    input.factor != 0.0 || input.bias != 0.0
}

fn shows(color: &ColorInput) -> bool {
    !color.is_black()
}

fn transmits(material: &Material) -> bool {
    match &material.surface {
        Surface::MetalRough(m) => is_some(&m.transmission),
        Surface::Phong(p) => shows(&p.transmission),
        Surface::Unlit(_) => false,
    }
}

/// Whether a mesh with a material calls for an effect.
fn calls(mesh: &Mesh, material: &Material, effect: Effect) -> bool {
    let layer = |of: fn(&Layers) -> bool| material.layers().is_some_and(of);
    let metal_rough = match &material.surface {
        Surface::MetalRough(m) => Some(m),
        _ => None,
    };
    let phong = match &material.surface {
        Surface::Phong(p) => Some(p),
        _ => None,
    };
    match effect {
        Effect::Textures => !material.textures().is_empty(),
        Effect::NormalMaps => material.normal_map.is_some() || layer(|l| l.clearcoat_normal_map.is_some()),
        Effect::VertexColors => !mesh.colors.is_empty(),
        Effect::SmoothNormals => !mesh.normals.is_empty() && !matches!(material.surface, Surface::Unlit(_)),
        Effect::AlphaCutouts => matches!(material.alpha.mode, AlphaMode::Mask { .. }),
        Effect::AlphaBlending => material.alpha.mode == AlphaMode::Blend,
        Effect::Culling => !material.double_sided,
        Effect::Specular => {
            metal_rough.is_some_and(|m| is_some(&m.specular)) || phong.is_some_and(|p| shows(&p.specular))
        }
        Effect::Metal => metal_rough.is_some_and(|m| is_some(&m.metallic)),
        Effect::Mirror => phong.is_some_and(|p| shows(&p.mirror)),
        Effect::Transmission => transmits(material),
        Effect::Refraction => {
            transmits(material)
                && (metal_rough.is_some_and(|m| m.volume.is_some())
                    || phong.is_some_and(|p| p.ior != ScalarInput::constant(1.0)))
        }
        Effect::Absorption => {
            let absorbs = |m: &kiln_formats::scene::MetalRough| {
                m.volume.is_some_and(|v| v.attenuation_distance.is_finite() && v.attenuation_color != [1.0; 3])
            };
            transmits(material)
                && (metal_rough.is_some_and(absorbs) || phong.is_some_and(|p| p.transmission != ColorInput::WHITE))
        }
        Effect::Dispersion => {
            transmits(material) && metal_rough.is_some_and(|m| m.volume.is_some() && m.dispersion > 0.0)
        }
        Effect::Clearcoat => layer(|l| is_some(&l.clearcoat)),
        Effect::Sheen => layer(|l| shows(&l.sheen_color)),
        Effect::Iridescence => layer(|l| is_some(&l.iridescence)),
        Effect::Anisotropy => layer(|l| l.anisotropy > 0.0),
        Effect::DiffuseTransmission => layer(|l| is_some(&l.diffuse_transmission)),
        Effect::DiffuseRoughness => layer(|l| is_some(&l.diffuse_roughness)),
        Effect::Unlit => matches!(material.surface, Surface::Unlit(_)),
        Effect::Emission => shows(&material.emission),
        Effect::PointLights
        | Effect::DirectionalLights
        | Effect::SoftShadows
        | Effect::TintedShadows
        | Effect::Environment => false,
    }
}
