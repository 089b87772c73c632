//! Shared by the tests of this module.

use super::MetalRoughParams;
use glam::Vec3;

/// A white dielectric of index 1.5.
pub fn plastic() -> MetalRoughParams {
    MetalRoughParams {
        base_color: Vec3::ONE,
        metallic: 0.0,
        roughness: 0.5,
        specular: 1.0,
        specular_color: Vec3::ONE,
        ior: 1.5,
        transmission: 0.0,
        thin_walled: false,
        entering: true,
    }
}

/// A unit vector by its cosine and azimuth.
pub fn direction(cos: f32, phi: f32) -> Vec3 {
    let sin = (1.0 - cos * cos).max(0.0).sqrt();
    Vec3::new(sin * libm::cosf(phi), sin * libm::sinf(phi), cos)
}
