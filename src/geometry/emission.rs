//! Emission of surfaces: a property of the material in the IR, an area light from here on.

use super::Geometry;
use super::coverage;
use super::pyramid::Pyramids;
use super::textures::{Reader, color, lookup};
use crate::math::luminance;
use glam::Vec3;
use kiln_formats::Scene;
use kiln_formats::scene::{AlphaMode, ColorInput, Material, Surface};

/// The emission input of a material and whether its back emits. Unlit surfaces emit what they show.
pub(super) fn input(material: &Material) -> (&ColorInput, bool) {
    match &material.surface {
        Surface::Unlit(shown) => (shown, material.double_sided),
        _ => (&material.emission, material.emission_two_sided),
    }
}

/// What all points of a material's triangles emit to their fronts, and to their backs; `None` where points differ.
pub fn everywhere(material: &Material) -> Option<[Vec3; 2]> {
    let (input, two_sided) = input(material);
    let same = input.texture.is_none() && !matches!(material.surface, Surface::Unlit(_));
    let radiance = Vec3::from(input.factor);
    same.then_some([radiance, if two_sided { radiance } else { Vec3::ZERO }])
}

/// Radiance that a triangle emits at barycentric weights `b` to its front or back, without regard to coverage.
pub fn emitted(scene: &Scene, geometry: &Geometry, triangle: u32, b: [f32; 3], front: bool) -> Vec3 {
    if geometry.is_dark(triangle) {
        return Vec3::ZERO;
    }
    emitted_by(scene, geometry, triangle, b, front, |input, uv| color(scene, input, &uv))
}

/// As [`emitted`], as a ray sees it that covers an area of `footprint` in each set of texture coordinates: also the light of what is beside a
/// dark triangle, which its neighbours lack then.
pub fn seen(
    scene: &Scene,
    geometry: &Geometry,
    pyramids: &Pyramids,
    (triangle, b, front): (u32, [f32; 3], bool),
    footprint: impl FnOnce() -> [f32; 2],
) -> Vec3 {
    emitted_by(scene, geometry, triangle, b, front, |input, uv| {
        let footprint = if input.texture.is_some() { footprint() } else { [0.0; 2] };
        Reader { scene, pyramids, uv, footprint }.color(input)
    })
}

fn emitted_by(
    scene: &Scene,
    geometry: &Geometry,
    triangle: u32,
    b: [f32; 3],
    front: bool,
    look: impl FnOnce(&ColorInput, [[f32; 2]; 2]) -> Vec3,
) -> Vec3 {
    let material = &scene.materials[geometry.material(scene, triangle) as usize];
    let (input, two_sided) = input(material);
    if input.is_black() || !(front || two_sided) {
        return Vec3::ZERO;
    }
    let shown = match material.surface {
        Surface::Unlit(_) => geometry.attributes(scene, triangle, b).color.truncate(),
        _ => Vec3::ONE,
    };
    let uv = if input.texture.is_some() { geometry.uv(scene, triangle, b) } else { [[0.0; 2]; 2] };
    shown * look(input, uv)
}

/// As [`emitted`], times the coverage there: what a ray to that point receives on the average.
pub fn radiance(scene: &Scene, geometry: &Geometry, triangle: u32, b: [f32; 3], front: bool) -> Vec3 {
    let emitted = emitted(scene, geometry, triangle, b, front);
    if emitted == Vec3::ZERO { emitted } else { emitted * coverage(scene, geometry, triangle, b) }
}

/// What the choice among lights needs to know of an emissive material.
#[derive(Debug)]
pub struct Source {
    /// Whether the back emits as well.
    pub two_sided: bool,
    /// Mean luminance over the whole texture.
    mean: f32,
    /// Whether triangles differ.
    textured: bool,
}

impl Source {
    /// `None` when the material does not emit.
    pub fn new(scene: &Scene, material: &Material) -> Option<Self> {
        let (input, two_sided) = input(material);
        if input.is_black() {
            return None;
        }
        let factor = luminance(Vec3::from(input.factor));
        let mean = match &input.texture {
            None => factor,
            Some(reference) => {
                let flat = kiln_formats::scene::TextureRef::new(reference.texture);
                let n = 64;
                let at = |k: u32| [(k % n) as f32 + 0.5, (k / n) as f32 + 0.5].map(|x| x / n as f32);
                let shown = |k| lookup(scene, &flat, &[at(k), at(k)]).truncate() * Vec3::from(input.factor);
                (0..n * n).map(|k| luminance(shown(k))).sum::<f32>() / (n * n) as f32
            }
        };
        let textured = input.texture.is_some() || material.alpha.mode != AlphaMode::Opaque;
        // A texture with a few bright texels may look black to the probe; it must still be found.
        Some(Self { two_sided, mean: mean.max(1e-3 * factor), textured })
    }

    /// Luminance of a triangle's emission, roughly; greater than zero wherever it may emit.
    pub fn mean_radiance(&self, scene: &Scene, geometry: &Geometry, triangle: u32) -> f32 {
        if !self.textured {
            return self.mean;
        }
        const PROBES: [[f32; 3]; 4] = [[0.34, 0.33, 0.33], [0.7, 0.15, 0.15], [0.15, 0.7, 0.15], [0.15, 0.15, 0.7]];
        let probe = |b| luminance(radiance(scene, geometry, triangle, b, true));
        let seen = PROBES.into_iter().map(probe).sum::<f32>() / PROBES.len() as f32;
        seen + 0.05 * self.mean
    }
}
