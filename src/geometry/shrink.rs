//! Images at half their size.

use super::textures::{SRGB_8, linear_to_srgb_8, srgb_to_linear};
use kiln_formats::scene::{ColorSpace, Image, Pixels};

/// The image at half its size, rounded down but not below 1: each texel is the mean of what it covers. Images of 8 bits
/// stay so (colours with the transfer function they had); others become linear floats.
///
/// With `weights`, one for each texel in 1/65535, the colours of texels count as much as those say (all alike where all are 0), and the weights of the
/// smaller image come back; alpha is the plain mean all the same.
pub(super) fn half(image: &Image, space: ColorSpace, weights: Option<&[u16]>) -> (Image, Vec<u16>) {
    let size = (image.width, image.height);
    let (width, height) = ((image.width / 2).max(1), (image.height / 2).max(1));
    let texels = width as usize * height as usize;
    let srgb = space == ColorSpace::Srgb;
    let mut made_weights = Vec::with_capacity(if weights.is_some() { texels } else { 0 });
    let pixels = match &image.pixels {
        Pixels::Rgba8(p) => {
            let colours: [f32; 256] = if srgb { *SRGB_8 } else { std::array::from_fn(|i| i as f32 / 255.0) };
            let store = |[r, g, b, a]: [f32; 4]| {
                let linear = |x: f32| (x * 255.0 + 0.5) as u8;
                let colour = |x| if srgb { linear_to_srgb_8(x) } else { linear(x) };
                [colour(r), colour(g), colour(b), linear(a)]
            };
            let mut out = vec![0; 4 * texels];
            if weights.is_none() && size.0.is_multiple_of(2) && size.1.is_multiple_of(2) {
                quarters(p, size.0, &mut out, |four| match srgb {
                    true => store(mean_of_four(four, &colours)),
                    false => std::array::from_fn(|c| {
                        let sum: u16 = four.iter().map(|texel| u16::from(texel[c])).sum();
                        ((sum + 2) >> 2) as u8
                    }),
                });
            } else {
                let mut places = out.as_chunks_mut().0.iter_mut();
                let decode = |c, x: u8| if c < 3 { colours[x as usize] } else { f32::from(x) / 255.0 };
                shrink(p, size, weights, decode, |texel, weight| {
                    places.next().into_iter().for_each(|place| *place = store(texel));
                    made_weights.extend(weight);
                });
            }
            Pixels::Rgba8(out)
        }
        Pixels::Rgba16(p) => {
            let mut out = Vec::with_capacity(4 * texels);
            let decode = |c: usize, x: u16| {
                let x = f32::from(x) / 65535.0;
                if srgb && c < 3 { srgb_to_linear(x) } else { x }
            };
            shrink(p, size, weights, decode, |texel, weight| {
                out.extend(texel);
                made_weights.extend(weight);
            });
            Pixels::RgbaF32(out)
        }
        Pixels::RgbaF32(p) => {
            let mut out = Vec::with_capacity(4 * texels);
            shrink(
                p,
                size,
                weights,
                |_, x| x,
                |texel, weight| {
                    out.extend(texel);
                    made_weights.extend(weight);
                },
            );
            Pixels::RgbaF32(out)
        }
    };
    (Image { name: String::new(), width, height, pixels }, made_weights)
}

/// Makes each texel of `out` from the four that it covers: upper left, upper right, lower left, lower right. Both sides are even.
fn quarters(texels: &[u8], width: u32, out: &mut [u8], make: impl Fn([&[u8; 4]; 4]) -> [u8; 4]) {
    let row = 4 * width as usize;
    for (pair, out) in texels.chunks_exact(2 * row).zip(out.chunks_exact_mut(row / 2)) {
        let (upper, lower) = pair.split_at(row);
        let (upper, lower) = (upper.as_chunks::<8>().0, lower.as_chunks::<8>().0);
        for ((upper, lower), out) in upper.iter().zip(lower).zip(out.as_chunks_mut().0) {
            let ([a, b], [c, d]) = (halves(upper), halves(lower));
            *out = make([a, b, c, d]);
        }
    }
}

fn halves(two: &[u8; 8]) -> [&[u8; 4]; 2] {
    let (left, right) = two.split_at(4);
    [left, right].map(|half| half.first_chunk().unwrap_or(&[0; 4]))
}

/// The mean colour of four texels; alpha is linear.
fn mean_of_four(four: [&[u8; 4]; 4], colours: &[f32; 256]) -> [f32; 4] {
    std::array::from_fn(|c| {
        let decode = |x: u8| if c < 3 { colours[x as usize] } else { f32::from(x) / 255.0 };
        0.25 * (decode(four[0][c]) + decode(four[1][c]) + decode(four[2][c]) + decode(four[3][c]))
    })
}

/// Which texels a texel of half size covers along an axis of `size` texels, and their shares: two where the size is even,
/// three where it is odd, one where it is 1.
fn covered(at: u32, size: u32) -> ([usize; 3], [f32; 3]) {
    if size == 1 {
        return ([0; 3], [1.0, 0.0, 0.0]);
    }
    let first = 2 * at as usize;
    if size.is_multiple_of(2) {
        return ([first, first + 1, first], [0.5, 0.5, 0.0]);
    }
    // A texel of the half covers 2 + 1/(size/2) texels, moved on by that fraction each time.
    let n = (size / 2) as f32;
    let whole = size as f32;
    let shares = [(n - at as f32) / whole, n / whole, (at as f32 + 1.0) / whole];
    ([first, first + 1, first + 2], shares)
}

/// Gives `store` the mean of each texel of half size, row by row, and its weight where there are weights.
fn shrink<T: Copy>(
    pixels: &[T],
    (width, height): (u32, u32),
    weights: Option<&[u16]>,
    decode: impl Fn(usize, T) -> f32,
    mut store: impl FnMut([f32; 4], Option<u16>),
) {
    let texels: &[[T; 4]] = pixels.as_chunks().0;
    let columns: Vec<_> = (0..(width / 2).max(1)).map(|x| covered(x, width)).collect();
    for y in 0..(height / 2).max(1) {
        let (rows, row_shares) = covered(y, height);
        for (across, shares) in &columns {
            let (mut sum, mut weighted, mut weight) = ([0.0; 4], [0.0; 3], 0.0);
            for (row, row_share) in rows.iter().zip(row_shares) {
                if row_share == 0.0 {
                    continue;
                }
                for (column, share) in across.iter().zip(shares) {
                    if *share == 0.0 {
                        continue;
                    }
                    let at = row * width as usize + column;
                    let (texel, share) = (texels[at], row_share * share);
                    let texel: [f32; 4] = std::array::from_fn(|c| decode(c, texel[c]));
                    sum.iter_mut().zip(texel).for_each(|(sum, x)| *sum += share * x);
                    if let Some(weights) = weights {
                        let part = share * f32::from(weights[at]);
                        weighted.iter_mut().zip(texel).for_each(|(sum, x)| *sum += part * x);
                        weight += part;
                    }
                }
            }
            if weight > 0.0 {
                sum[..3].copy_from_slice(&weighted.map(|x| x / weight));
            }
            // Rounded up: what is there at all still counts when it is alone.
            store(sum, weights.map(|_| weight.ceil() as u16));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_texel_of_an_odd_image_counts_the_same() {
        for (width, height) in [(5, 3), (7, 1), (1, 9), (3, 4)] {
            for spot in 0..width * height {
                let values = (0..width * height).flat_map(|k| [if k == spot { 1.0 } else { 0.0 }; 4]).collect();
                let source = Image { name: String::new(), width, height, pixels: Pixels::RgbaF32(values) };
                let (smaller, _) = half(&source, ColorSpace::Linear, None);
                let Pixels::RgbaF32(p) = &smaller.pixels else { panic!("floats stay floats") };
                let mean = p.iter().sum::<f32>() / p.len() as f32;
                assert!((mean * (width * height) as f32 - 1.0).abs() < 1e-5, "{width}×{height}, {spot}: {mean}");
            }
        }
    }

    #[test]
    fn even_images_of_bytes_have_the_means_that_floats_have() {
        let bytes: Vec<u8> = (0..4 * 64 * 32u32).map(|k| (k.wrapping_mul(2_654_435_761) >> 23) as u8).collect();
        for space in [ColorSpace::Srgb, ColorSpace::Linear] {
            let decode = |c: usize, x: u8| match space {
                ColorSpace::Srgb if c < 3 => SRGB_8[x as usize],
                _ => f32::from(x) / 255.0,
            };
            let floats = bytes.iter().enumerate().map(|(k, x)| decode(k % 4, *x)).collect();
            let image = |pixels| Image { name: String::new(), width: 64, height: 32, pixels };
            let (got, _) = half(&image(Pixels::Rgba8(bytes.clone())), space, None);
            let (want, _) = half(&image(Pixels::RgbaF32(floats)), ColorSpace::Linear, None);
            let (Pixels::Rgba8(got), Pixels::RgbaF32(want)) = (got.pixels, want.pixels) else { panic!("kinds stay") };
            assert_eq!((got.len(), want.len()), (4 * 32 * 16, 4 * 32 * 16));
            for (k, (got, want)) in got.iter().zip(want).enumerate() {
                let near = decode(k % 4, got.saturating_sub(1))..=decode(k % 4, got.saturating_add(1));
                let step = decode(k % 4, *got) - want;
                assert!(near.contains(&want) && step.abs() < 0.505 * (near.end() - near.start()), "{space:?}, {k}");
            }
        }
    }
}
