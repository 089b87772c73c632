//! A smooth interface between two dielectrics: reflects or refracts, both as delta distributions.

use super::colour::luminance;
use super::fresnel::Interface;
use super::lobe::Delta;
use glam::Vec3;

/// Reflects or refracts by the share of each. Refracted radiance carries (η_i/η_t)²: it is spread over another solid
/// angle on the far side (pbr-book 4ed, 9.5.2).
#[inline]
pub fn sample(interface: &Interface, wo: Vec3, u: f32) -> Option<Delta> {
    if interface.is_straight() {
        let value = interface.transmit;
        return Some(Delta { wi: -wo, value, probability: 1.0, eta_scale: 1.0, straight: true });
    }
    let split = interface.split(wo.z);
    let (r, t) = (luminance(split.reflected), luminance(split.transmitted));
    if r + t <= 0.0 {
        return None;
    }
    let probability = r / (r + t);
    if u < probability {
        let wi = Vec3::new(-wo.x, -wo.y, wo.z);
        return Some(Delta { wi, value: split.reflected, probability, eta_scale: 1.0, straight: false });
    }
    if t == 0.0 {
        return None;
    }
    let inverse_eta = 1.0 / interface.eta;
    let wi = Vec3::new(-wo.x * inverse_eta, -wo.y * inverse_eta, -split.cos_t).normalize();
    let eta_scale = inverse_eta * inverse_eta;
    Some(Delta { wi, value: split.transmitted * eta_scale, probability: 1.0 - probability, eta_scale, straight: false })
}
