//! Textures at half, a quarter, … of their size (Williams 1983), for rays that see many texels at once.

use super::textures::{SRGB_8, linear_to_srgb_8, srgb_to_linear};
use kiln_formats::scene::{ColorSpace, Image, ImageId, Pixels};
use kiln_formats::{Control, Scene, parallel};
use std::collections::BTreeMap;

/// The smaller versions of all images that the scene's textures use. Averages are taken of linear values.
#[derive(Debug, Default)]
pub struct Pyramids {
    /// Each image in each colour space that it is used in, from half size down to one texel.
    chains: Vec<Vec<Image>>,
    /// The chain of each texture.
    of_texture: Vec<u32>,
}

impl Pyramids {
    /// Makes them, on the current rayon pool; `control` is told what that takes there.
    pub fn new(scene: &Scene, control: &Control) -> Self {
        let mut ids: BTreeMap<(ImageId, bool), u32> = BTreeMap::new();
        let mut sources = Vec::new();
        let of_texture = scene.textures.iter().map(|texture| {
            *ids.entry((texture.image, texture.color_space == ColorSpace::Srgb)).or_insert_with(|| {
                sources.push((texture.image, texture.color_space));
                sources.len() as u32 - 1
            })
        });
        let of_texture = of_texture.collect();
        let chain = |(image, space): &(ImageId, ColorSpace)| chain(&scene.images[*image as usize], *space);
        Self { chains: parallel::map(&sources, control, chain), of_texture }
    }

    /// A texture's image at 1/2^`level` of its size, or its smallest one.
    #[inline]
    pub fn level<'a>(&'a self, scene: &'a Scene, texture: u32, level: u32) -> &'a Image {
        match self.chain(texture) {
            chain if level > 0 && !chain.is_empty() => &chain[(level as usize - 1).min(chain.len() - 1)],
            _ => &scene.images[scene.textures[texture as usize].image as usize],
        }
    }

    /// The smaller versions of a texture's image, the largest first.
    #[inline]
    pub fn chain(&self, texture: u32) -> &[Image] {
        self.of_texture.get(texture as usize).map_or(&[], |chain| self.chains[*chain as usize].as_slice())
    }
}

fn chain(image: &Image, space: ColorSpace) -> Vec<Image> {
    let mut chain: Vec<Image> = Vec::new();
    loop {
        let last = chain.last().unwrap_or(image);
        if last.width == 1 && last.height == 1 {
            return chain;
        }
        chain.push(half(last, space));
    }
}

/// The image at half its size, rounded down but not below 1: each texel is the mean of what it covers. Images of 8 bits
/// stay so (colours with the transfer function they had); others become linear floats.
fn half(image: &Image, space: ColorSpace) -> Image {
    let (width, height) = ((image.width / 2).max(1), (image.height / 2).max(1));
    let size = 4 * width as usize * height as usize;
    let srgb = space == ColorSpace::Srgb;
    let pixels = match &image.pixels {
        Pixels::Rgba8(p) => {
            let colours: [f32; 256] = if srgb { *SRGB_8 } else { std::array::from_fn(|i| i as f32 / 255.0) };
            let mut out = Vec::with_capacity(size);
            let store = |c: usize, x: f32| {
                if srgb && c < 3 { linear_to_srgb_8(x) } else { (x * 255.0 + 0.5) as u8 }
            };
            shrink(
                p,
                image.width,
                image.height,
                |c, x| if c < 3 { colours[x as usize] } else { f32::from(x) / 255.0 },
                |texel| {
                    out.extend([0, 1, 2, 3].map(|c| store(c, texel[c])));
                },
            );
            Pixels::Rgba8(out)
        }
        Pixels::Rgba16(p) => {
            let mut out = Vec::with_capacity(size);
            let decode = |c: usize, x: u16| {
                let x = f32::from(x) / 65535.0;
                if srgb && c < 3 { srgb_to_linear(x) } else { x }
            };
            shrink(p, image.width, image.height, decode, |texel| out.extend(texel));
            Pixels::RgbaF32(out)
        }
        Pixels::RgbaF32(p) => {
            let mut out = Vec::with_capacity(size);
            shrink(p, image.width, image.height, |_, x| x, |texel| out.extend(texel));
            Pixels::RgbaF32(out)
        }
    };
    Image { name: String::new(), width, height, pixels }
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

/// Gives `store` the mean of each texel of half size, row by row.
fn shrink<T: Copy>(
    pixels: &[T],
    width: u32,
    height: u32,
    decode: impl Fn(usize, T) -> f32,
    mut store: impl FnMut([f32; 4]),
) {
    let texels: &[[T; 4]] = pixels.as_chunks().0;
    let columns: Vec<_> = (0..(width / 2).max(1)).map(|x| covered(x, width)).collect();
    for y in 0..(height / 2).max(1) {
        let (rows, row_shares) = covered(y, height);
        for (across, shares) in &columns {
            let mut sum = [0.0; 4];
            for (row, row_share) in rows.iter().zip(row_shares) {
                if row_share == 0.0 {
                    continue;
                }
                for (column, share) in across.iter().zip(shares) {
                    if *share == 0.0 {
                        continue;
                    }
                    let texel = texels[row * width as usize + column];
                    for (c, sum) in sum.iter_mut().enumerate() {
                        *sum += row_share * share * decode(c, texel[c]);
                    }
                }
            }
            store(sum);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use kiln_formats::scene::{Texture, TextureRef};

    fn image(width: u32, height: u32, f: impl Fn(u32, u32) -> u8) -> Image {
        let pixels =
            (0..height).flat_map(|y| (0..width).map(move |x| (x, y))).flat_map(|(x, y)| [f(x, y); 4]).collect();
        Image { name: String::new(), width, height, pixels: Pixels::Rgba8(pixels) }
    }

    fn first(image: &Image) -> [u8; 4] {
        let Pixels::Rgba8(p) = &image.pixels else { panic!("8 bits stay 8 bits") };
        [p[0], p[1], p[2], p[3]]
    }

    #[test]
    fn black_and_white_average_to_half_the_light() {
        let board = image(8, 8, |x, y| if (x + y) % 2 == 0 { 255 } else { 0 });
        let colours = chain(&board, ColorSpace::Srgb);
        assert_eq!(colours.iter().map(|i| (i.width, i.height)).collect::<Vec<_>>(), [(4, 4), (2, 2), (1, 1)]);
        // 188 is the sRGB code of 0.5; alpha is linear.
        colours.iter().for_each(|level| assert_eq!(first(level), [188, 188, 188, 128]));
        assert_eq!(first(&chain(&board, ColorSpace::Linear)[0]), [128; 4]);
    }

    #[test]
    fn every_texel_of_an_odd_image_counts_the_same() {
        for (width, height) in [(5, 3), (7, 1), (1, 9), (3, 4)] {
            for spot in 0..width * height {
                let values = (0..width * height).flat_map(|k| [if k == spot { 1.0 } else { 0.0 }; 4]).collect();
                let source = Image { name: String::new(), width, height, pixels: Pixels::RgbaF32(values) };
                let smaller = half(&source, ColorSpace::Linear);
                let Pixels::RgbaF32(p) = &smaller.pixels else { panic!("floats stay floats") };
                let mean = p.iter().sum::<f32>() / p.len() as f32;
                assert!((mean * (width * height) as f32 - 1.0).abs() < 1e-5, "{width}×{height}, {spot}: {mean}");
            }
        }
    }

    #[test]
    fn textures_of_one_image_share_their_chain() {
        let of = |color_space| Texture {
            image: 0,
            wrap_u: Default::default(),
            wrap_v: Default::default(),
            filter: Default::default(),
            color_space,
        };
        let scene = Scene {
            images: vec![image(4, 4, |x, _| x as u8)],
            textures: vec![of(ColorSpace::Srgb), of(ColorSpace::Linear), of(ColorSpace::Srgb)],
            ..Scene::default()
        };
        let pyramids = Pyramids::new(&scene, &Control::default());
        assert_eq!((pyramids.chains.len(), &pyramids.of_texture[..]), (2, &[0, 1, 0][..]));
        let size = |level| pyramids.level(&scene, TextureRef::new(0).texture, level).width;
        assert_eq!([0, 1, 2, 3, 40].map(size), [4, 2, 1, 1, 1]);
    }
}
