//! Mathematics without policy.

pub mod float_error;
pub mod frame;
mod ray;

use glam::Vec3;
pub use ray::{Hit, Ray};

/// Relative luminance of linear Rec. 709.
pub fn luminance(c: Vec3) -> f32 {
    c.dot(Vec3::new(0.2126, 0.7152, 0.0722))
}
