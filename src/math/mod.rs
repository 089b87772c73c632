//! Mathematics without policy.

pub mod chi2;
pub mod float_error;
mod frame;
mod placement;
mod ray;
pub mod simd;
pub mod spectrum;
pub mod statistics;
pub mod triangle;
pub mod warp;
#[cfg(test)]
mod warp_tests;

use glam::Vec3;

pub use frame::Frame;
pub use placement::Placement;
pub use ray::{Hit, Ray};

/// Shares of linear Rec. 709 red, green and blue in relative luminance.
pub const LUMINANCE: [f64; 3] = [0.2126, 0.7152, 0.0722];

/// Relative luminance of linear Rec. 709.
pub fn luminance(c: Vec3) -> f32 {
    c.dot(Vec3::from_array(LUMINANCE.map(|share| share as f32)))
}
