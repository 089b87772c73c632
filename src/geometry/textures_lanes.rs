//! Texture look-ups at sixteen points: twin of [`super::textures::Reader`]. Where texels lie and what they mean is computed in
//! lanes; the texels are fetched one after the other.

use super::Pyramids;
use super::textures::{Reader, SRGB_8};
use crate::lanes::{Floats, LANES, Lanes, Mask, Words};
use kiln_formats::Scene;
use kiln_formats::scene::{ColorSpace, Filter, Pixels, TextureRef, Wrap};

/// Sizes of an image that lanes know of: more than 32 768 texels along a side are left to the code for one point.
const MOST_LEVELS: usize = LANES;

/// Reads textures at sixteen points as rays of some width see them.
#[derive(Clone, Copy)]
pub struct TexturesLanes<'a, L: Lanes> {
    /// Holds the textures.
    pub scene: &'a Scene,
    /// Their smaller versions.
    pub pyramids: &'a Pyramids,
    /// Both sets of texture coordinates.
    pub uv: [[L::F; 2]; 2],
    /// The rays' widths squared in units of each set.
    pub footprint: [L::F; 2],
}

/// The sizes of an image of four bytes a texel, the largest first.
struct Levels<'a> {
    count: usize,
    bytes: [&'a [u8]; MOST_LEVELS],
    width: [u32; MOST_LEVELS],
    height: [u32; MOST_LEVELS],
}

/// Where look-ups go along one axis: two texels each, and how far from the first to the second.
struct Along<L: Lanes> {
    first: L::U,
    second: L::U,
    part: L::F,
}

impl<L: Lanes> TexturesLanes<'_, L> {
    /// The linear RGBA values of a texture, where `active`.
    #[inline(always)]
    pub fn lookup(&self, l: L, reference: &TextureRef, active: L::M) -> [L::F; 4] {
        let Some(levels) = self.levels(reference) else {
            let of = |set: usize| [self.uv[set][0].array(), self.uv[set][1].array()];
            let footprint = [self.footprint[0].array(), self.footprint[1].array()];
            let [r, g, b, a] = self.one_by_one(reference, active.bits(), [of(0), of(1)], footprint);
            return [l.load(&r), l.load(&g), l.load(&b), l.load(&a)];
        };
        let texture = &self.scene.textures[reference.texture as usize];
        let set = reference.uv_set as usize & 1;
        let ([[a, b], [c, d]], [u, v]) = (reference.transform.linear, self.uv[set]);
        let [du, dv] = reference.transform.offset;
        let (u, v) = (u * a + v * b + du, u * c + v * d + dv);
        let known = u.is_finite() & v.is_finite() & active;
        // As `textures::level`.
        let texels = self.footprint[set] * (a * d - b * c).abs() * (levels.width[0] as f32 * levels.height[0] as f32);
        let level = (texels.to_bits().shr::<23>() - 127).shr::<1>().min(l.word(levels.count as u32 - 1));
        let level = L::U::select(texels.ge(l.splat(1.0)), level, l.word(0));
        let (width, height) = (l.gather_words(&levels.width, level), l.gather_words(&levels.height, level));
        let nearest = texture.filter == Filter::Nearest;
        let (x, y) = (along(l, u, width, texture.wrap_u, nearest), along(l, v, height, texture.wrap_v, nearest));
        let (upper, lower) = (y.first * width, y.second * width);
        let places = [
            (upper + x.first).array(),
            (upper + x.second).array(),
            (lower + x.first).array(),
            (lower + x.second).array(),
        ];
        let found = levels.fetch(&level.array(), &places, known.bits());
        let texels =
            [l.load_words(&found[0]), l.load_words(&found[1]), l.load_words(&found[2]), l.load_words(&found[3])];
        // Texels of unknown places are zeros, but zero times what is not a number is not.
        let parts = [x.part.only(known), y.part.only(known)];
        let srgb = (texture.color_space == ColorSpace::Srgb).then(|| &*SRGB_8);
        [
            channel::<L, 0>(l, &texels, parts, srgb),
            channel::<L, 8>(l, &texels, parts, srgb),
            channel::<L, 16>(l, &texels, parts, srgb),
            channel::<L, 24>(l, &texels, parts, srgb),
        ]
    }

    /// The sizes of a texture's image; `None` where its texels are not four bytes, or there are too many sizes.
    fn levels(&self, reference: &TextureRef) -> Option<Levels<'_>> {
        let texture = &self.scene.textures[reference.texture as usize];
        let image = &self.scene.images[texture.image as usize];
        let smaller = self.pyramids.chain(reference.texture);
        let count = 1 + smaller.len();
        if count > MOST_LEVELS {
            return None;
        }
        let (width, height) = ([0; MOST_LEVELS], [0; MOST_LEVELS]);
        let mut levels = Levels { count, bytes: [&[]; MOST_LEVELS], width, height };
        for (k, image) in std::iter::once(image).chain(smaller).enumerate() {
            let Pixels::Rgba8(bytes) = &image.pixels else { return None };
            (levels.bytes[k], levels.width[k], levels.height[k]) = (bytes, image.width, image.height);
        }
        Some(levels)
    }

    #[inline(never)]
    fn one_by_one(
        &self,
        reference: &TextureRef,
        active: u32,
        uv: [[[f32; LANES]; 2]; 2],
        footprint: [[f32; LANES]; 2],
    ) -> [[f32; LANES]; 4] {
        let mut found = [[0.0; LANES]; 4];
        for lane in (0..LANES).filter(|lane| active >> lane & 1 == 1) {
            let uv = uv.map(|set| set.map(|row| row[lane]));
            let footprint = footprint.map(|row| row[lane]);
            let reader = Reader { scene: self.scene, pyramids: self.pyramids, uv, footprint };
            for (row, x) in found.iter_mut().zip(reader.lookup(reference).to_array()) {
                row[lane] = x;
            }
        }
        found
    }
}

impl Levels<'_> {
    /// The texels at four places of each point's level, as their bytes; zeros where not `active`.
    #[inline(never)]
    fn fetch(&self, level: &[u32; LANES], places: &[[u32; LANES]; 4], active: u32) -> [[u32; LANES]; 4] {
        let mut found = [[0; LANES]; 4];
        for lane in (0..LANES).filter(|lane| active >> lane & 1 == 1) {
            let (texels, _) = self.bytes[level[lane] as usize % MOST_LEVELS].as_chunks::<4>();
            for (row, places) in found.iter_mut().zip(places) {
                row[lane] = texels.get(places[lane] as usize).map_or(0, |texel| u32::from_le_bytes(*texel));
            }
        }
        found
    }
}

/// As `textures::texels_along` and `textures::wrapped`.
#[inline(always)]
fn along<L: Lanes>(l: L, coordinate: L::F, size: L::U, mode: Wrap, nearest: bool) -> Along<L> {
    let (zero, one) = (l.splat(0.0), l.splat(1.0));
    let count = size.to_floats();
    let x = match mode {
        Wrap::Repeat => (coordinate - coordinate.floor()) * count,
        Wrap::Clamp => coordinate.max(zero).min(one) * count,
        Wrap::Mirror => {
            let turn = coordinate - (coordinate * 0.5).floor() * 2.0;
            L::F::select(turn.gt(one), l.splat(2.0) - turn, turn) * count
        }
    };
    let last = count - 1.0;
    if nearest {
        let first = wrapped(l, x.floor(), last, mode).truncate();
        return Along { first, second: first, part: zero };
    }
    let x = x - 0.5;
    let whole = x.floor();
    let (first, second) = (wrapped(l, whole, last, mode), wrapped(l, whole + 1.0, last, mode));
    Along { first: first.truncate(), second: second.truncate(), part: x - whole }
}

/// Whole numbers between −1 and one more than `last`.
#[inline(always)]
fn wrapped<L: Lanes>(l: L, index: L::F, last: L::F, mode: Wrap) -> L::F {
    let zero = l.splat(0.0);
    let (below, above) = if mode == Wrap::Repeat { (last, zero) } else { (zero, last) };
    L::F::select(index.lt(zero), below, L::F::select(index.gt(last), above, index))
}

/// The channel at bit `SHIFT` of four texels, linear, and between them. Alpha is linear in every space.
#[inline(always)]
fn channel<L: Lanes, const SHIFT: u32>(l: L, texels: &[L::U; 4], [x, y]: [L::F; 2], srgb: Option<&[f32; 256]>) -> L::F {
    let one = l.splat(1.0);
    let upper = decode::<L, SHIFT>(l, texels[0], srgb) * (one - x) + decode::<L, SHIFT>(l, texels[1], srgb) * x;
    let lower = decode::<L, SHIFT>(l, texels[2], srgb) * (one - x) + decode::<L, SHIFT>(l, texels[3], srgb) * x;
    upper * (one - y) + lower * y
}

#[inline(always)]
fn decode<L: Lanes, const SHIFT: u32>(l: L, texel: L::U, srgb: Option<&[f32; 256]>) -> L::F {
    let byte = texel.shr::<SHIFT>() & 0xFF;
    match (SHIFT, srgb) {
        (24, _) => byte.to_floats() * (1.0 / 255.0),
        (_, Some(table)) => l.gather(table, byte),
        (_, None) => byte.to_floats() / 255.0,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lanes::{AnyLanes, Work};
    use crate::math::simd::SimdTier;
    use kiln_formats::scene::{Image, Texture, UvTransform};

    struct Random(u32);

    impl Random {
        fn next(&mut self) -> f32 {
            self.0 = self.0.wrapping_mul(747_796_405).wrapping_add(2_891_336_453);
            (self.0 >> 8) as f32 / 16_777_216.0
        }
    }

    /// Images of 8 bits and one of floats, read in every way.
    fn scene() -> Scene {
        let mut random = Random(3);
        let mut image = |width: u32, height: u32, bytes: bool| {
            let values: Vec<f32> = (0..4 * width * height).map(|_| random.next()).collect();
            let pixels = match bytes {
                true => Pixels::Rgba8(values.iter().map(|x| (x * 255.0) as u8).collect()),
                false => Pixels::RgbaF32(values),
            };
            Image { name: String::new(), width, height, pixels }
        };
        let images = vec![image(16, 8, true), image(7, 5, true), image(1, 1, true), image(6, 6, false)];
        let mut textures = Vec::new();
        for k in 0..4 * 3 * 2 * 2u32 {
            let wrap = |k: u32| [Wrap::Repeat, Wrap::Clamp, Wrap::Mirror][k as usize % 3];
            textures.push(Texture {
                image: k % 4,
                wrap_u: wrap(k / 4),
                wrap_v: wrap(k / 4 + k),
                filter: if k / 12 % 2 == 0 { Filter::Linear } else { Filter::Nearest },
                color_space: if k / 24 == 0 { ColorSpace::Srgb } else { ColorSpace::Linear },
            });
        }
        Scene { images, textures, ..Scene::default() }
    }

    struct Read<'a>(&'a Scene, &'a Pyramids, TextureRef, [[f32; LANES]; 6]);

    impl Work for Read<'_> {
        type Output = [[f32; LANES]; 4];

        #[inline(always)]
        fn run<L: Lanes>(self, l: L) -> Self::Output {
            let [u0, v0, u1, v1, f0, f1] = self.3.map(|row| l.load(&row));
            let uv = [[u0, v0], [u1, v1]];
            let textures = TexturesLanes { scene: self.0, pyramids: self.1, uv, footprint: [f0, f1] };
            textures.lookup(l, &self.2, l.first(LANES)).map(|x| x.array())
        }
    }

    #[test]
    fn lanes_read_what_one_point_reads() {
        let scene = scene();
        let pyramids = Pyramids::new(&scene, &kiln_formats::Control::default());
        let mut random = Random(11);
        for texture in 0..scene.textures.len() as u32 {
            for round in 0..12 {
                let mut row = |from: f32, to: f32| std::array::from_fn(|_| from + (to - from) * random.next());
                let (near, far) = if round < 10 { (-2.0, 3.0) } else { (-4e6, 4e6) };
                let mut rows: [[f32; LANES]; 6] = [
                    row(near, far),
                    row(near, far),
                    row(0.0, 1.0),
                    row(0.0, 1.0),
                    row(0.0, if round % 2 == 0 { 0.0 } else { 0.4 }),
                    row(0.0, 3.0),
                ];
                rows[0][3] = [f32::NAN, f32::INFINITY, 0.0, 1.0, -1e-9, 0.5][round % 6];
                rows[4][5] = [f32::NAN, f32::INFINITY, 1e30, -1.0][round % 4];
                let transform = match round % 3 {
                    0 => UvTransform::IDENTITY,
                    _ => UvTransform { linear: [[0.7, -1.3], [0.4, 2.0]], offset: [0.25, -0.75] },
                };
                let reference = TextureRef { texture, uv_set: (round % 2) as u8, transform };
                for tier in SimdTier::ALL {
                    let all = AnyLanes::new(tier).run(Read(&scene, &pyramids, reference, rows));
                    for lane in 0..LANES {
                        let [u0, v0, u1, v1, f0, f1] = rows.map(|row| row[lane]);
                        let (uv, footprint) = ([[u0, v0], [u1, v1]], [f0, f1]);
                        let one = Reader { scene: &scene, pyramids: &pyramids, uv, footprint }.lookup(&reference);
                        assert_eq!(
                            all.map(|row| row[lane]),
                            one.to_array(),
                            "{tier}, texture {texture}, {round}, {lane}"
                        );
                    }
                }
            }
        }
    }
}
