//! Little helpers for linear Rec. 709 colours.

use glam::Vec3;

/// Luminance of linear Rec. 709 primaries. Above 0 for every colour that is not black.
#[inline]
pub fn luminance(colour: Vec3) -> f32 {
    0.2126 * colour.x + 0.7152 * colour.y + 0.0722 * colour.z
}

/// A number in [0, 1]; NaN becomes 0.
#[inline]
#[expect(clippy::manual_clamp, reason = "clamp keeps NaN")]
pub fn unit(x: f32) -> f32 {
    x.max(0.0).min(1.0)
}

/// A colour with every channel in [0, 1]; NaN becomes 0.
#[inline]
pub fn unit_colour(colour: Vec3) -> Vec3 {
    Vec3::new(unit(colour.x), unit(colour.y), unit(colour.z))
}
