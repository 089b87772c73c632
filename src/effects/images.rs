//! What the texels of an image have in common. Nothing is decoded, and nothing is read further than needed.

use kiln_formats::scene::{Channel, Image, Pixels};

/// Whether a channel has one value everywhere.
pub(super) fn is_constant(image: &Image, channel: Channel) -> bool {
    match &image.pixels {
        Pixels::Rgba8(p) => all_same(p, channel),
        Pixels::Rgba16(p) => all_same(p, channel),
        Pixels::RgbaF32(p) => all_same(p, channel),
    }
}

fn all_same<T: Copy + PartialEq>(values: &[T], channel: Channel) -> bool {
    let mut values = values.iter().skip(channel as usize).step_by(4);
    let first = values.next();
    values.all(|value| Some(value) == first)
}

/// Whether a channel is at least `least` (of [0, 1]) everywhere. Interpolation between texels does not go below that.
pub(super) fn is_at_least(image: &Image, channel: Channel, least: f32) -> bool {
    fn all<T: Copy>(values: &[T], channel: Channel, enough: impl Fn(T) -> bool) -> bool {
        values.iter().skip(channel as usize).step_by(4).all(|value| enough(*value))
    }
    match &image.pixels {
        Pixels::Rgba8(p) => all(p, channel, |v| f32::from(v) / 255.0 >= least),
        Pixels::Rgba16(p) => all(p, channel, |v| f32::from(v) / 65535.0 >= least),
        Pixels::RgbaF32(p) => all(p, channel, |v| v >= least),
    }
}

/// Whether red, green and blue are zero everywhere.
pub(super) fn is_black(image: &Image) -> bool {
    fn all_zero<T: Copy + PartialEq + Default>(values: &[T]) -> bool {
        values.chunks_exact(4).all(|texel| texel[..3].iter().all(|value| *value == T::default()))
    }
    match &image.pixels {
        Pixels::Rgba8(p) => all_zero(p),
        Pixels::Rgba16(p) => all_zero(p),
        Pixels::RgbaF32(p) => all_zero(p),
    }
}

/// Whether a normal map says (0, 0, 1) everywhere, as nearly as its codes can: ½ lies between two of them.
pub(super) fn is_flat(image: &Image) -> bool {
    match &image.pixels {
        Pixels::Rgba8(p) => p.chunks_exact(4).all(|t| matches!(t[..3], [127 | 128, 127 | 128, 254 | 255])),
        Pixels::Rgba16(p) => p.chunks_exact(4).all(|t| matches!(t[..3], [32767 | 32768, 32767 | 32768, 65534 | 65535])),
        Pixels::RgbaF32(p) => p.chunks_exact(4).all(|t| t[..3] == [0.5, 0.5, 1.0]),
    }
}
