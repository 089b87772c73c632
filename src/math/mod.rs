//! Mathematics without policy.

pub mod float_error;
mod frame;
mod ray;
pub mod statistics;
pub mod warp;

use glam::Vec3;

pub use frame::Frame;
pub use ray::{Hit, Ray};

/// Relative luminance of linear Rec. 709.
pub fn luminance(c: Vec3) -> f32 {
    c.dot(Vec3::new(0.2126, 0.7152, 0.0722))
}
