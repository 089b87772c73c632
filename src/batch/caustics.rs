//! Light that path tracing hardly finds, known from the scene alone.

use kiln_formats::Warning;
use kiln_formats::scene::{Extent, Light, LightKind, Material, ScalarInput, Scene, Surface};
use std::collections::BTreeSet;

/// Perceptual roughness (GGX α = its square) up to which a surface sends light without extent into so narrow a cone that paths rarely
/// go back along it.
const SMOOTH: f32 = 0.25;
/// The share of light that has to pass to be worth a word.
const LEAST: f32 = 0.1;

/// Warns of caustics that cannot be sampled well: light from where no path can end by chance, through a body that is smooth or nearly
/// so. A perfectly smooth one lets none of it be found, and the picture converges without it; through a nearly smooth one it comes
/// as rare specks, so that neither the picture nor the error that it states know how much there is.
pub(super) fn unsampled(scene: &Scene) -> Option<Warning> {
    let lights: Vec<&Light> = scene.lights.iter().filter(|light| is_punctual(light)).collect();
    if lights.is_empty() {
        return None;
    }
    let meshes: BTreeSet<_> = scene.instances.iter().map(|instance| instance.mesh).collect();
    let materials: BTreeSet<_> = meshes
        .into_iter()
        .map(|mesh| &scene.meshes[mesh as usize])
        .flat_map(|mesh| std::iter::once(mesh.material).chain(mesh.vertex_materials.iter().copied()))
        .collect();
    let (body, light) = materials.into_iter().map(|id| &scene.materials[id as usize]).find_map(|body| {
        let through = lights.iter().find(|light| focuses(body, light.through_glass));
        through.map(|light| (body, light))
    })?;
    let quoted =
        |what: &str, name: &str| if name.is_empty() { format!("a {what}") } else { format!("{what} '{name}'") };
    let message = format!(
        "what {} sends through {} is hardly found by paths: it is missing or comes as specks, and the stated error does not know of it",
        quoted("light", &light.name),
        quoted("material", &body.name),
    );
    Some(Warning::new("unsampled-caustics", "", message))
}

fn is_punctual(light: &Light) -> bool {
    let point = match light.kind {
        LightKind::Directional | LightKind::Spot { .. } => true,
        LightKind::Point { extent, .. } => extent == Extent::Point,
    };
    point && light.color != [0.0; 3]
}

/// Whether a surface bends light and leaves it in a narrow cone; `through_glass`: of a lamp that shines straight through bodies.
fn focuses(material: &Material, through_glass: bool) -> bool {
    match &material.surface {
        Surface::MetalRough(m) => {
            let most = |input: &ScalarInput| {
                input.bias + if input.texture.is_some() { input.factor.max(0.0) } else { input.factor }
            };
            m.volume.is_some() && most(&m.transmission) >= LEAST && most(&m.roughness) <= SMOOTH
        }
        Surface::Phong(p) => !through_glass && p.transmission.factor.iter().any(|t| *t >= LEAST),
        Surface::Unlit(_) => false,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::{DAffine3, DVec3};
    use kiln_formats::scene::{Falloff, Instance, Mesh, MetalRough, Volume};

    fn glass(roughness: f32, transmission: f32, solid: bool) -> Material {
        let clear = Volume { attenuation_color: [1.0; 3], attenuation_distance: f32::INFINITY };
        let surface = MetalRough {
            roughness: ScalarInput::constant(roughness),
            transmission: ScalarInput::constant(transmission),
            volume: solid.then_some(clear),
            ..MetalRough::default()
        };
        Material { name: "Glass".into(), surface: Surface::MetalRough(surface), ..Material::default() }
    }

    fn said(material: Material, kind: LightKind, color: [f32; 3]) -> Option<String> {
        let mut scene = Scene::default();
        scene.materials.extend([Material::default(), material]);
        scene.meshes.push(Mesh { material: 1, ..Mesh::default() });
        scene.instances.push(Instance { name: String::new(), mesh: 0, transform: DAffine3::IDENTITY });
        let (position, direction) = (DVec3::Y, DVec3::NEG_Y);
        scene.lights.push(Light { name: "Sun".into(), kind, color, position, direction, through_glass: false });
        unsampled(&scene).map(|warning| warning.message)
    }

    #[test]
    fn lights_without_extent_through_smooth_bodies_are_named() {
        let sun = LightKind::Directional;
        let message = said(glass(0.1, 1.0, true), sun, [1.0; 3]).expect("a warning");
        assert!(message.starts_with("what light 'Sun' sends through material 'Glass'"), "{message}");
        let falloff = Falloff::InverseSquare { range: None };
        let lamp = |extent| LightKind::Point { falloff, extent };
        assert!(said(glass(0.0, 1.0, true), lamp(Extent::Point), [1.0; 3]).is_some());
        // Paths end at lamps with an extent; rough glass spreads; thin walls do not bend; what is dark or opaque sends nothing.
        assert_eq!(said(glass(0.0, 1.0, true), lamp(Extent::Disc { radius: 0.1 }), [1.0; 3]), None);
        assert_eq!(said(glass(0.5, 1.0, true), sun, [1.0; 3]), None);
        assert_eq!(said(glass(0.1, 1.0, false), sun, [1.0; 3]), None);
        assert_eq!(said(glass(0.1, 0.0, true), sun, [1.0; 3]), None);
        assert_eq!(said(glass(0.1, 1.0, true), sun, [0.0; 3]), None);
    }
}
