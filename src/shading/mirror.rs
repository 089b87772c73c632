//! Perfectly specular reflection.

use super::fresnel::Schlick;
use super::lobe::Delta;
use glam::Vec3;

/// The one direction there is.
#[inline]
pub fn sample(fresnel: &Schlick, wo: Vec3) -> Delta {
    Delta {
        wi: Vec3::new(-wo.x, -wo.y, wo.z),
        value: fresnel.at(wo.z),
        probability: 1.0,
        eta_scale: 1.0,
        straight: false,
    }
}
