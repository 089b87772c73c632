//! Absorption inside bodies (Beer–Lambert).

use super::vertex::Place;
use crate::prepare::PreparedScene;
use glam::Vec3;
use kiln_formats::scene::{MaterialId, Surface};

/// Transmittance of a body of this material over a distance in the rays' frame; 1 for materials that bound no body.
///
/// Textures of k_t are read at (0, 0), as the base dialect does for bodies without coordinates.
fn transmittance(prepared: &PreparedScene, material: MaterialId, distance: f32) -> Vec3 {
    let world = f64::from(distance) / prepared.frame.scale();
    let power = |base: f32, exponent: f64| {
        if base >= 1.0 || exponent == 0.0 {
            1.0
        } else {
            // A floor as in ray-format.md, section 11.6: 0 would make even the thinnest body opaque.
            libm::pow(f64::from(base.max(1e-6)), exponent) as f32
        }
    };
    match &prepared.scene.materials[material as usize].surface {
        Surface::MetalRough(m) => match m.volume {
            Some(volume) if volume.attenuation_distance.is_finite() => {
                let exponent = world / f64::from(volume.attenuation_distance);
                Vec3::from(volume.attenuation_color.map(|c| power(c, exponent)))
            }
            _ => Vec3::ONE,
        },
        Surface::Phong(p) => Vec3::from(
            crate::geometry::textures::color(&prepared.scene, &p.transmission, &[[0.0; 2]; 2])
                .to_array()
                .map(|c| power(c, world)),
        ),
        Surface::Unlit(_) => Vec3::ONE,
    }
}

/// Bodies within each other that a path keeps count of; of more, the outermost are forgotten.
const DEEPEST: usize = 4;

/// Which bodies the path is in, the one entered last at the end. Bodies that overlap go by that order too: light is
/// bent and absorbed by the one entered last (priorities as in Schmidt & Budge 2002, given by the order of entering).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Inside {
    bodies: [MaterialId; DEEPEST],
    depth: usize,
}

impl Inside {
    fn last(&self) -> Option<MaterialId> {
        self.bodies[..self.depth].last().copied()
    }

    fn entered(mut self, material: MaterialId) -> Self {
        if self.depth == DEEPEST {
            self.bodies.copy_within(1.., 0);
            self.depth -= 1;
        }
        self.bodies[self.depth] = material;
        self.depth += 1;
        self
    }

    fn left(mut self, material: MaterialId) -> Self {
        if let Some(at) = self.bodies[..self.depth].iter().rposition(|m| *m == material) {
            self.bodies.copy_within(at + 1..self.depth, at);
            self.depth -= 1;
        }
        self
    }

    /// What the path is in, now that it has met `place`.
    ///
    /// A surface met from its back says by itself that the segment before lay inside its body, so a camera inside glass
    /// needs no special case: the path has been in that body all along, outside of what it has entered since.
    pub(super) fn met(mut self, prepared: &PreparedScene, place: &Place) -> Self {
        let known = place.front || !bounds_body(prepared, place.material);
        if !known && self.depth < DEEPEST && !self.bodies[..self.depth].contains(&place.material) {
            self.bodies.copy_within(..self.depth, 1);
            self.bodies[0] = place.material;
            self.depth += 1;
        }
        self
    }

    /// Transmittance of a segment inside, over a distance in the rays' frame.
    pub(super) fn transmittance(self, prepared: &PreparedScene, distance: f32) -> Vec3 {
        self.last().map_or(Vec3::ONE, |material| transmittance(prepared, material, distance))
    }

    /// After the path went through the surface at `place`.
    pub(super) fn crossed(self, prepared: &PreparedScene, place: &Place) -> Self {
        match bounds_body(prepared, place.material) {
            true if place.front => self.entered(place.material),
            true => self.left(place.material),
            false => self,
        }
    }

    /// Index of refraction around the body whose surface is at `place`: what its own index is relative to.
    ///
    /// A body that is left before one entered later has no boundary there: what is around it is as good as itself.
    /// The index of a `.ray` body is relative already (ray-format.md, section 10: the index outside is 1).
    pub(super) fn index_around(self, prepared: &PreparedScene, place: &Place) -> f32 {
        let index = |material: Option<MaterialId>| {
            let surface = material.map(|m| &prepared.scene.materials[m as usize].surface);
            match surface {
                Some(Surface::MetalRough(m)) if m.ior > 0.0 => m.ior,
                _ => 1.0,
            }
        };
        if place.front {
            index(self.last())
        } else if self.last() == Some(place.material) {
            index(self.left(place.material).last())
        } else {
            index(Some(place.material))
        }
    }
}

/// Whether the material is the boundary of a body that absorbs and refracts.
pub(super) fn bounds_body(prepared: &PreparedScene, material: MaterialId) -> bool {
    match &prepared.scene.materials[material as usize].surface {
        Surface::MetalRough(m) => m.volume.is_some(),
        Surface::Phong(p) => !p.transmission.is_black(),
        Surface::Unlit(_) => false,
    }
}
