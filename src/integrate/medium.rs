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

/// Which body the path is in.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Inside(Option<MaterialId>);

impl Inside {
    /// What the path is in, now that it has met `place`.
    ///
    /// A surface met from its back says by itself that the segment before lay inside its body, so a camera inside glass
    /// needs no special case.
    pub(super) fn met(self, prepared: &PreparedScene, place: &Place) -> Self {
        let behind = (!place.front && bounds_body(prepared, place.material)).then_some(place.material);
        Self(self.0.or(behind))
    }

    /// Transmittance of a segment inside, over a distance in the rays' frame.
    pub(super) fn transmittance(self, prepared: &PreparedScene, distance: f32) -> Vec3 {
        self.0.map_or(Vec3::ONE, |material| transmittance(prepared, material, distance))
    }

    /// After the path went through the surface at `place`.
    pub(super) fn crossed(self, prepared: &PreparedScene, place: &Place) -> Self {
        match bounds_body(prepared, place.material) {
            true if place.front => Self(Some(place.material)),
            true => Self(None),
            false => self,
        }
    }
}

fn bounds_body(prepared: &PreparedScene, material: MaterialId) -> bool {
    match &prepared.scene.materials[material as usize].surface {
        Surface::MetalRough(m) => m.volume.is_some(),
        Surface::Phong(p) => !p.transmission.is_black(),
        Surface::Unlit(_) => false,
    }
}
