//! Height maps as normal maps.

use crate::scene::{Channel, Image, Pixels};

/// How high white is above black, in widths of the texture, at `-bm 1`. The format does not say; in world units, as some
/// read it, hardly any file's bumps would look like bumps.
const HEIGHT: f32 = 0.01;

/// A tangent-space normal map (y against v) of the heights in one channel of an image. Colours in a height map count as
/// they are stored.
pub fn to_normals(image: &Image, channel: Channel, clamp: bool) -> Image {
    let (width, height) = (image.width as usize, image.height as usize);
    let c = channel as usize;
    let at = |x: usize, y: usize| {
        let i = 4 * (y * width + x) + c;
        match &image.pixels {
            Pixels::Rgba8(p) => p.get(i).map_or(0.0, |v| f32::from(*v) / 255.0),
            Pixels::Rgba16(p) => p.get(i).map_or(0.0, |v| f32::from(*v) / 65535.0),
            Pixels::RgbaF32(p) => p.get(i).copied().unwrap_or(0.0),
        }
    };
    let before = |i: usize, n: usize| {
        if i > 0 {
            i - 1
        } else if clamp {
            0
        } else {
            n - 1
        }
    };
    let after = |i: usize, n: usize| {
        if i + 1 < n {
            i + 1
        } else if clamp {
            n - 1
        } else {
            0
        }
    };
    // Slopes in texels of the width; texels are taken as square.
    let scale = 0.5 * HEIGHT * width as f32;
    let mut pixels = Vec::with_capacity(4 * width * height);
    for y in 0..height {
        for x in 0..width {
            let across = scale * (at(after(x, width), y) - at(before(x, width), y));
            let up = scale * (at(x, before(y, height)) - at(x, after(y, height)));
            let length = (1.0 + across * across + up * up).sqrt();
            let stored = |n: f32| ((n / length * 0.5 + 0.5) * 65535.0 + 0.5) as u16;
            pixels.extend([stored(-across), stored(-up), stored(1.0), u16::MAX]);
        }
    }
    Image { name: image.name.clone(), width: image.width, height: image.height, pixels: Pixels::Rgba16(pixels) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn slopes_lean_away_from_what_is_higher() {
        // 100 wide: one unit of height is one texel. A ramp up to the right, then one up to the top.
        let ramp = |f: &dyn Fn(u32, u32) -> f32| {
            let values = (0..3).flat_map(|y| (0..100).map(move |x| (x, y))).flat_map(|(x, y)| [f(x, y), 0.0, 0.0, 1.0]);
            Image { name: String::new(), width: 100, height: 3, pixels: Pixels::RgbaF32(values.collect()) }
        };
        let middle = |image: &Image| {
            let Pixels::Rgba16(p) = &to_normals(image, Channel::R, true).pixels else { panic!() };
            [0, 1, 2].map(|c| f32::from(p[4 * 150 + c]) / 65535.0 * 2.0 - 1.0)
        };
        let h = 0.5_f32.sqrt();
        for (got, want) in [
            (middle(&ramp(&|x, _| x as f32)), [-h, 0.0, h]),
            (middle(&ramp(&|_, y| -(y as f32))), [0.0, -h, h]),
            (middle(&ramp(&|_, _| 0.3)), [0.0, 0.0, 1.0]),
        ] {
            assert!(got.iter().zip(want).all(|(a, b)| (a - b).abs() < 1e-4), "{got:?} for {want:?}");
        }
    }
}
