//! Light that path tracing hardly finds, known from the scene alone.

use crate::shading::is_smooth;
use kiln_formats::scene::{Extent, Light, LightKind, Material, Scene, Surface};
use std::collections::BTreeSet;
use std::fmt;

/// Perceptual roughness (GGX α = its square) up to which a surface sends light without extent into so narrow a cone that paths rarely
/// go back along it.
const SMOOTH: f32 = 0.25;
/// The share of light that has to pass, or of metal, to be worth a word.
const LEAST: f32 = 0.1;

/// Light from where no path can end by chance, bent or mirrored by a surface that is smooth or nearly so: highlights smaller than a
/// pixel, and caustics.
#[derive(Clone, Debug, PartialEq)]
pub struct RareLight {
    /// Name of the light in the file; may be empty.
    pub light: String,
    /// Name of the surface's material; may be empty.
    pub material: String,
    /// Whether the light goes through the surface: a body of glass.
    pub through: bool,
    /// The surface's perceptual roughness. A perfectly smooth one (0) lets no path find the light, and the picture converges without
    /// it; a nearly smooth one lets it come as specks, the rarer the smoother it is, and the samples do not tell how much there is.
    pub roughness: f32,
}

impl RareLight {
    /// The worst of a scene: by the smoothest of the surfaces that are not perfectly smooth, if there is one.
    pub(super) fn of(scene: &Scene) -> Option<Self> {
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
        let of = |material: &Material| {
            let (light, way) = lights.iter().find_map(|light| Some((light, sends(material, light.through_glass)?)))?;
            let (light, material) = (light.name.clone(), material.name.clone());
            Some(Self { light, material, through: way.through, roughness: way.roughness })
        };
        let all = materials.into_iter().filter_map(|id| of(&scene.materials[id as usize]));
        let rough = |rare: &Self| if rare.roughness > 0.0 { rare.roughness } else { f32::INFINITY };
        all.reduce(|worst, next| if rough(&next) < rough(&worst) { next } else { worst })
    }
}

impl fmt::Display for RareLight {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let quoted =
            |what: &str, name: &str| if name.is_empty() { format!("a {what}") } else { format!("{what} '{name}'") };
        let (light, material) = (quoted("light", &self.light), quoted("material", &self.material));
        write!(f, "what {light} sends {} {material}", if self.through { "through" } else { "by way of" })
    }
}

fn is_punctual(light: &Light) -> bool {
    let point = match light.kind {
        LightKind::Directional | LightKind::Spot { .. } => true,
        LightKind::Point { extent, .. } => extent == Extent::Point,
    };
    point && light.color != [0.0; 3]
}

struct Way {
    through: bool,
    roughness: f32,
}

/// How a surface sends light on in a narrow cone, if it does; `through_glass`: of a lamp that shines straight through bodies.
fn sends(material: &Material, through_glass: bool) -> Option<Way> {
    match &material.surface {
        Surface::MetalRough(m) => {
            let through = m.volume.is_some() && m.transmission.most() >= LEAST;
            let metal = m.metallic.most() >= LEAST && m.metallic.texture.is_none() && m.roughness.texture.is_none();
            let smooth = m.roughness.most() <= SMOOTH;
            (smooth && (through || metal)).then(|| Way {
                through,
                roughness: if is_smooth(m.roughness.most()) { 0.0 } else { m.roughness.most() },
            })
        }
        Surface::Phong(p) => {
            let through = !through_glass && p.transmission.factor.iter().any(|t| *t >= LEAST);
            through.then_some(Way { through, roughness: 0.0 })
        }
        Surface::Unlit(_) => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::{DAffine3, DVec3};
    use kiln_formats::scene::{Falloff, Instance, Mesh, MetalRough, ScalarInput, Volume};

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

    /// A mesh of each material, without lights.
    fn dark(materials: &[Material]) -> Scene {
        let mut scene = Scene::default();
        for (k, material) in (0..).zip(materials) {
            scene.materials.push(material.clone());
            scene.meshes.push(Mesh { material: k, ..Mesh::default() });
            scene.instances.push(Instance { name: String::new(), mesh: k, transform: DAffine3::IDENTITY });
        }
        scene
    }

    fn sun(kind: LightKind, color: [f32; 3]) -> Light {
        let (position, direction) = (DVec3::Y, DVec3::NEG_Y);
        Light { name: "Sun".into(), kind, color, position, direction, through_glass: false }
    }

    fn said(material: Material, kind: LightKind, color: [f32; 3]) -> Option<String> {
        let mut scene = dark(&[Material::default(), material]);
        scene.lights.push(sun(kind, color));
        RareLight::of(&scene).map(|rare| format!("{rare}{}", if rare.roughness > 0.0 { "" } else { ": never" }))
    }

    #[test]
    fn lights_without_extent_through_smooth_bodies_are_named() {
        let sun = LightKind::Directional;
        let message = said(glass(0.1, 1.0, true), sun, [1.0; 3]).expect("a warning");
        assert_eq!(message, "what light 'Sun' sends through material 'Glass'");
        let falloff = Falloff::InverseSquare { range: None };
        let lamp = |extent| LightKind::Point { falloff, extent };
        let message = said(glass(0.0, 1.0, true), lamp(Extent::Point), [1.0; 3]).expect("never found");
        assert!(message.ends_with(": never"), "{message}");
        // Paths end at lamps with an extent; rough glass spreads; thin walls do not bend; what is dark or opaque sends nothing.
        assert_eq!(said(glass(0.0, 1.0, true), lamp(Extent::Disc { radius: 0.1 }), [1.0; 3]), None);
        assert_eq!(said(glass(0.5, 1.0, true), sun, [1.0; 3]), None);
        assert_eq!(said(glass(0.1, 1.0, false), sun, [1.0; 3]), None);
        assert_eq!(said(glass(0.1, 0.0, true), sun, [1.0; 3]), None);
        assert_eq!(said(glass(0.1, 1.0, true), sun, [0.0; 3]), None);
    }

    #[test]
    fn mirrors_are_named_too() {
        let metal = |roughness, metallic| {
            let surface = MetalRough {
                roughness: ScalarInput::constant(roughness),
                metallic: ScalarInput::constant(metallic),
                ..MetalRough::default()
            };
            Material { surface: Surface::MetalRough(surface), ..Material::default() }
        };
        let message = said(metal(0.1, 1.0), LightKind::Directional, [1.0; 3]).expect("a mirror");
        assert_eq!(message, "what light 'Sun' sends by way of a material");
        let mut scene = dark(&[0.0, 0.03, 0.2, 0.1, 0.15].map(|roughness| metal(roughness, 1.0)));
        scene.lights.push(sun(LightKind::Directional, [1.0; 3]));
        assert_eq!(RareLight::of(&scene).map(|rare| rare.roughness), Some(0.1));
        assert_eq!(said(metal(0.5, 1.0), LightKind::Directional, [1.0; 3]), None);
        assert_eq!(said(metal(0.1, 0.0), LightKind::Directional, [1.0; 3]), None);
    }
}
