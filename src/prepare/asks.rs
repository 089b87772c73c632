//! What has to be asked at hits: decided once, from the effects that the scene calls for.

use super::Filters;
use crate::effects::{Knowledge, called_for};
use crate::geometry::Geometry;
use crate::settings::{Effect, EffectSet};
use crate::shading::is_smooth;
use kiln_formats::Scene;
use kiln_formats::scene::{AlphaMode, Material, Surface};

/// Questions to be asked at hits, for the whole scene.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Asks {
    /// Whether a surface covers what is behind it.
    pub covers: bool,
    /// Whether camera rays pass through its back.
    pub culls: bool,
    /// Whether light shines through it and takes on colour.
    pub tints: bool,
    /// Whether light samples pass through a smooth wall.
    pub walls: bool,
    /// Whether anything is read from an image.
    pub textured: bool,
    /// Whether shading asks the vertices of any triangle for normals, coordinates or colours.
    pub vertices: bool,
    /// Whether coverage is asked of every material.
    every_cover: bool,
}

impl Asks {
    /// By the effects of what is drawn.
    pub fn new(scene: &Scene, geometry: &Geometry, know: Knowledge) -> Self {
        let called: EffectSet = called_for(scene, &drawn(scene, geometry)).iter().map(|called| called.effect).collect();
        let asked = know.asked(called);
        let covers = asked.has_any(&[Effect::AlphaCutouts, Effect::AlphaBlending]);
        let culls = asked.has(Effect::Culling);
        // It decides whether lanes can follow shadow rays, and so how numbers are rounded: never forced.
        let tints = know.own(called).has(Effect::TintedShadows);
        let walls = know.own(called).has(Effect::Transmission);
        let every_cover = know.forced.has_any(&[Effect::AlphaCutouts, Effect::AlphaBlending]);
        let textured = asked.has(Effect::Textures);
        let of_vertices = [Effect::SmoothNormals, Effect::NormalMaps, Effect::VertexColors];
        Self { covers, culls, tints, walls, textured, vertices: textured || asked.has_any(&of_vertices), every_cover }
    }

    /// Whether it may be made use of that a triangle lets every ray through: not where every surface is reckoned to be like that.
    pub fn knows_open(&self) -> bool {
        self.covers && !self.every_cover
    }

    /// What a traversal has to ask about a material's triangles.
    pub fn of(&self, material: &Material) -> Filters {
        let bounds_solid = match &material.surface {
            Surface::MetalRough(m) => m.volume.is_some(),
            Surface::Phong(_) | Surface::Unlit(_) => false,
        };
        Filters {
            coverage: self.covers && (self.every_cover || material.alpha.mode != AlphaMode::Opaque),
            // From inside a glass body its back is the way out.
            culled: self.culls && !material.double_sided && !bounds_solid,
            tints: matches!(&material.surface, Surface::Phong(p) if !p.transmission.is_black()),
            walls: self.walls && is_smooth_wall(material),
        }
    }
}

/// Whether light may go straight through a surface that bounds no body.
fn is_smooth_wall(material: &Material) -> bool {
    let Surface::MetalRough(m) = &material.surface else { return false };
    m.volume.is_none() && m.transmission.most() > 0.0 && is_smooth(m.roughness.least())
}

/// 1 for each mesh that has a triangle in the world, 0 for the others.
pub(super) fn drawn(scene: &Scene, geometry: &Geometry) -> Vec<f64> {
    let ends = geometry.parts.iter().skip(1).map(|part| part.first_triangle);
    let mut drawn = vec![0.0; scene.meshes.len()];
    for (part, end) in geometry.parts.iter().zip(ends.chain([geometry.len() as u32])) {
        if end > part.first_triangle {
            drawn[part.mesh as usize] = 1.0;
        }
    }
    drawn
}
