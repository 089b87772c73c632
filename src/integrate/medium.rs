//! Bodies that a path is in: absorption (Beer–Lambert), refraction, and dispersion.

use super::touching::Touching;
use super::vertex::Place;
use crate::math::spectrum::{self, Wavelength};
use crate::prepare::{self, PreparedScene};
use glam::Vec3;
use kiln_formats::scene::{MaterialId, Surface};

/// Transmittance of a body of this material over a distance in the rays' frame; 1 for materials that bound no body.
///
/// Textures of k_t are read at (0, 0), as the base dialect does for bodies without coordinates.
fn transmittance(prepared: &PreparedScene, material: MaterialId, distance: f32) -> Vec3 {
    let world = f64::from(distance) / prepared.frame.scale();
    let power = |base: f32, exponent: f64| {
        if base >= 1.0 || exponent == 0.0 { 1.0 } else { libm::pow(f64::from(base), exponent) as f32 }
    };
    match &prepared.scene.materials[material as usize].surface {
        Surface::MetalRough(m) => match m.volume {
            Some(volume) if volume.attenuation_distance.is_finite() => {
                let exponent = world / f64::from(volume.attenuation_distance);
                Vec3::from(volume.attenuation_color.map(|c| power(c, exponent)))
            }
            _ => Vec3::ONE,
        },
        Surface::Phong(p) if p.transmission_at_surfaces => Vec3::ONE,
        Surface::Phong(p) => Vec3::from(
            crate::geometry::textures::color(&prepared.scene, &p.transmission, &[[0.0; 2]; 2])
                .to_array()
                // A floor as in ray-format.md, section 11.6: 0 would make even the thinnest body opaque.
                .map(|c| power(c.max(1e-6), world)),
        ),
        Surface::Unlit(_) => Vec3::ONE,
    }
}

/// What a surface that is crossed lets through by itself: k_t in the dialect where it counts surfaces, and not lengths.
pub(super) fn through_surface(prepared: &PreparedScene, material: MaterialId) -> Vec3 {
    match &prepared.scene.materials[material as usize].surface {
        Surface::Phong(p) if p.transmission_at_surfaces => {
            crate::geometry::textures::color(&prepared.scene, &p.transmission, &[[0.0; 2]; 2]).min(Vec3::ONE)
        }
        _ => Vec3::ONE,
    }
}

/// Bodies within each other that a path keeps count of; of more, the outermost are forgotten.
const DEEPEST: usize = 4;

/// Which bodies the path is in, the one entered last at the end. Bodies that overlap go by that order too: light is
/// bent and absorbed by the one entered last (priorities as in Schmidt & Budge 2002, given by the order of entering).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Inside {
    bodies: [MaterialId; DEEPEST],
    depth: usize,
    /// The one wavelength that the path carries since it met a body that disperses light, nanometres.
    wavelength: Option<f32>,
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
            // Who has left everything is as if never inside.
            self.bodies[self.depth] = MaterialId::default();
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

    /// After the path went through the surface at `place`, and with it through those of other bodies that touch it there.
    pub(super) fn crossed(self, prepared: &PreparedScene, place: &Place) -> Self {
        if !bounds_body(prepared, place.material) {
            return self;
        }
        let through = |inside: Self, (material, front)| inside.through(material, front);
        let touching = Touching::at(prepared, place);
        touching.surfaces().fold(self.through(place.material, place.front), through)
    }

    /// After the path went through the surface of a body, met from its front or from inside.
    pub(super) fn through(self, material: MaterialId, front: bool) -> Self {
        if front { self.entered(material) } else { self.left(material) }
    }

    /// Leaves one wavelength of the path's light, by a number in [0, 1), before it goes through a surface that bends each
    /// differently; `None` where none does, or the path has only one already. Its weight is for the throughput.
    pub(super) fn disperse(
        &mut self,
        prepared: &PreparedScene,
        place: &Place,
        number: impl FnOnce() -> f32,
    ) -> Option<Wavelength> {
        let disperses = |id: &MaterialId| match &prepared.scene.materials[*id as usize].surface {
            Surface::MetalRough(m) => m.volume.is_some() && m.dispersion > 0.0,
            Surface::Phong(_) | Surface::Unlit(_) => false,
        };
        let bounds = bounds_body(prepared, place.material);
        if self.wavelength.is_some() || !bounds {
            return None;
        }
        if !disperses(&place.material) && !self.bodies[..self.depth].iter().any(disperses) {
            return None;
        }
        let wavelength = spectrum::wavelength(number());
        self.wavelength = Some(wavelength.nanometres);
        Some(wavelength)
    }

    /// What the index of the body whose surface is at `place` has to be divided by: the index of refraction around it, and
    /// where it disperses light also its own nominal index by that for the path's wavelength.
    ///
    /// A body that is left before one entered later has no boundary there: what is around it is as good as itself.
    /// The index of a `.ray` body is relative already (ray-format.md, section 10: the index outside is 1).
    pub(super) fn index_around(self, prepared: &PreparedScene, place: &Place) -> f32 {
        let index = |material: Option<MaterialId>, wavelength: Option<f32>| {
            let surface = material.map(|m| &prepared.scene.materials[m as usize].surface);
            match (surface, wavelength) {
                (Some(Surface::MetalRough(m)), None) if m.ior > 0.0 => m.ior,
                (Some(Surface::MetalRough(m)), Some(nm)) if m.ior > 0.0 => dispersed(m.ior, m.dispersion, nm),
                _ => 1.0,
            }
        };
        let own = Some(place.material);
        // Bodies that touch have no air between them.
        let around = if let Some(other) = Touching::at(prepared, place).other_way(place.front) {
            index(Some(other), self.wavelength)
        } else if place.front {
            index(self.last(), self.wavelength)
        } else if self.last() == own {
            index(self.left(place.material).last(), self.wavelength)
        } else {
            index(own, self.wavelength)
        };
        match self.wavelength {
            None => around,
            some => around * (index(own, None) / index(own, some)),
        }
    }
}

/// Index at a wavelength by Cauchy's formula through the index at the d line (587.6 nm) and the Abbe number 20 /
/// `dispersion` (KHR_materials_dispersion).
fn dispersed(ior: f32, dispersion: f32, nanometres: f32) -> f32 {
    let cauchy = 523_655.0 / (nanometres * nanometres) - 1.5168;
    (ior + (ior - 1.0) * (dispersion / 20.0) * cauchy).max(1.0)
}

/// Whether the material is the boundary of a body that absorbs and refracts.
pub(super) fn bounds_body(prepared: &PreparedScene, material: MaterialId) -> bool {
    prepare::bounds_body(&prepared.scene.materials[material as usize])
}

#[cfg(test)]
mod tests {
    use super::{Inside, dispersed};

    /// Lanes follow paths that are in nothing: whoever is taken to be inside for ever goes one by one for ever.
    #[test]
    fn what_has_been_left_leaves_no_trace() {
        let outside = Inside::default();
        assert_ne!(outside.entered(5), outside);
        assert_eq!(outside.entered(5).left(5), outside);
        assert_eq!(outside.entered(5).entered(3).left(5), outside.entered(3));
        assert_eq!(outside.entered(5).entered(3).entered(4).left(5).left(3).left(4), outside);
        let deep = (1..40).fold(outside, Inside::entered);
        assert_eq!((1..40).fold(deep, Inside::left), outside);
    }

    #[test]
    fn indices_are_those_of_the_abbe_number() {
        // Its definition by the d, F and C lines; BK7 has 64.2.
        for (ior, abbe) in [(1.5168f32, 64.2f32), (2.42, 55.3), (1.6, 20.0)] {
            let [d, f, c] = [587.56, 486.13, 656.27].map(|line| dispersed(ior, 20.0 / abbe, line));
            assert!((d - ior).abs() < 1e-5 && c < d && d < f);
            assert!(((d - 1.0) / (f - c) / abbe - 1.0).abs() < 2e-3, "{}", (d - 1.0) / (f - c));
        }
        assert_eq!(dispersed(1.5, 0.0, 400.0), 1.5);
        assert_eq!(dispersed(1.0, 5.0, 400.0), 1.0);
        assert_eq!(dispersed(1.5, 100.0, 700.0), 1.0);
    }
}
