//! Textures at half, a quarter, … of their size (Williams 1983), for rays that see many texels at once.

use super::cutouts::{self, Weighing};
use super::shrink::half;
use kiln_formats::scene::{ColorSpace, Image, ImageId};
use kiln_formats::{Control, Scene, parallel};
use std::collections::BTreeMap;

/// The smaller versions of all images that the scene's textures use. Averages are taken of linear values, and over those texels only
/// that can be seen (`cutouts`).
#[derive(Debug, Default)]
pub struct Pyramids {
    /// Each image in each way that it is used in, from half size down to one texel.
    chains: Vec<Vec<Image>>,
    /// The chain of each texture.
    of_texture: Vec<u32>,
}

impl Pyramids {
    /// Makes them, on the current rayon pool; `control` is told what that takes there.
    pub fn new(scene: &Scene, control: &Control) -> Self {
        let mut ids: BTreeMap<(ImageId, bool, Weighing), u32> = BTreeMap::new();
        let mut sources = Vec::new();
        let of_texture = scene.textures.iter().zip(cutouts::weighings(scene)).map(|(texture, weighing)| {
            *ids.entry((texture.image, texture.color_space == ColorSpace::Srgb, weighing)).or_insert_with(|| {
                sources.push((texture.image, texture.color_space, weighing));
                sources.len() as u32 - 1
            })
        });
        let of_texture = of_texture.collect();
        let chain = |(image, space, weighing): &(ImageId, ColorSpace, Weighing)| {
            chain(&scene.images[*image as usize], *space, *weighing)
        };
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

fn chain(image: &Image, space: ColorSpace, weighing: Weighing) -> Vec<Image> {
    let mut chain: Vec<Image> = Vec::new();
    let mut weights = weighing.of(image);
    loop {
        let last = chain.last().unwrap_or(image);
        if last.width == 1 && last.height == 1 {
            return chain;
        }
        let (mut smaller, its_weights) = half(last, space, weights.as_deref());
        weights = weights.map(|_| its_weights);
        if let Some(weights) = &weights {
            cutouts::spread(&mut smaller, weights);
        }
        chain.push(smaller);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use kiln_formats::scene::{Pixels, Texture, TextureRef};

    fn image(width: u32, height: u32, f: impl Fn(u32, u32) -> [u8; 4]) -> Image {
        let pixels = (0..height).flat_map(|y| (0..width).map(move |x| (x, y))).flat_map(|(x, y)| f(x, y)).collect();
        Image { name: String::new(), width, height, pixels: Pixels::Rgba8(pixels) }
    }

    fn first(image: &Image) -> [u8; 4] {
        let Pixels::Rgba8(p) = &image.pixels else { panic!("8 bits stay 8 bits") };
        [p[0], p[1], p[2], p[3]]
    }

    #[test]
    fn black_and_white_average_to_half_the_light() {
        let board = image(8, 8, |x, y| if (x + y) % 2 == 0 { [255; 4] } else { [0; 4] });
        let colours = chain(&board, ColorSpace::Srgb, Weighing::Even);
        assert_eq!(colours.iter().map(|i| (i.width, i.height)).collect::<Vec<_>>(), [(4, 4), (2, 2), (1, 1)]);
        // 188 is the sRGB code of 0.5; alpha is linear.
        colours.iter().for_each(|level| assert_eq!(first(level), [188, 188, 188, 128]));
        assert_eq!(first(&chain(&board, ColorSpace::Linear, Weighing::Even)[0]), [128; 4]);
    }

    #[test]
    fn colours_that_nothing_shows_do_not_count() {
        // Green leaves of 3 texels in 16 on a black ground that is cut out, in images of even and of odd sizes.
        for (width, height) in [(16, 16), (15, 9)] {
            let leaf = |x: u32, y: u32| x % 4 == 1 && y % 4 < 3;
            let leaves = image(width, height, |x, y| if leaf(x, y) { [40, 200, 90, 255] } else { [0; 4] });
            for weighing in [Weighing::by_alpha(), Weighing::by_cutoff(0.5)] {
                for level in chain(&leaves, ColorSpace::Srgb, weighing) {
                    let Pixels::Rgba8(texels) = &level.pixels else { panic!("8 bits stay 8 bits") };
                    for texel in texels.chunks_exact(4).filter(|texel| texel[3] > 0) {
                        assert_eq!(texel[..3], [40, 200, 90], "{}×{}", level.width, level.height);
                    }
                }
            }
            let smallest = |weighing| first(chain(&leaves, ColorSpace::Srgb, weighing).last().unwrap());
            // Alpha is the share that is there, whatever counts for the colour.
            assert_eq!(smallest(Weighing::by_alpha())[3], smallest(Weighing::Even)[3]);
            assert!(smallest(Weighing::Even)[1] < 110);
        }
        // A soft edge under the threshold is not there at all.
        let edge = image(2, 1, |x, _| if x == 0 { [255, 255, 255, 200] } else { [0, 0, 0, 100] });
        assert_eq!(first(&chain(&edge, ColorSpace::Linear, Weighing::by_cutoff(0.5))[0]), [255, 255, 255, 150]);
        assert_eq!(first(&chain(&edge, ColorSpace::Linear, Weighing::by_alpha())[0]), [170, 170, 170, 150]);
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
            images: vec![image(4, 4, |x, _| [x as u8; 4])],
            textures: vec![of(ColorSpace::Srgb), of(ColorSpace::Linear), of(ColorSpace::Srgb)],
            ..Scene::default()
        };
        let pyramids = Pyramids::new(&scene, &Control::default());
        assert_eq!((pyramids.chains.len(), &pyramids.of_texture[..]), (2, &[0, 1, 0][..]));
        let size = |level| pyramids.level(&scene, TextureRef::new(0).texture, level).width;
        assert_eq!([0, 1, 2, 3, 40].map(size), [4, 2, 1, 1, 1]);
    }
}
