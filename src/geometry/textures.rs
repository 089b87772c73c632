//! Texture look-ups: wrap, filter, decode.

use super::Pyramids;
use glam::{Vec3, Vec4};
use kiln_formats::Scene;
use kiln_formats::scene::{
    Channel, ColorInput, ColorSpace, Filter, Image, Pixels, ScalarInput, Texture, TextureRef, Wrap,
};
use std::ops::{Add, Mul};
use std::sync::LazyLock;

/// The sRGB transfer function of IEC 61966-2-1, from stored [0, 1] to linear.
pub fn srgb_to_linear(x: f32) -> f32 {
    if x <= 0.04045 { x / 12.92 } else { libm::powf((x + 0.055) / 1.055, 2.4) }
}

/// The inverse of [`srgb_to_linear`] as a byte; what is not in [0, 1] is clamped. Right to the nearest but for a few of the
/// darkest values.
pub(super) fn linear_to_srgb_8(x: f32) -> u8 {
    static CODES: LazyLock<Vec<u8>> = LazyLock::new(|| {
        let mut code = 0u8;
        let step = |k: u32| {
            let x = k as f32 / LAST as f32;
            while code < 255 && x > 0.5 * (SRGB_8[code as usize] + SRGB_8[code as usize + 1]) {
                code += 1;
            }
            code
        };
        (0..=LAST).map(step).collect()
    });
    const LAST: u32 = (1 << 14) - 1;
    CODES[(x * LAST as f32 + 0.5) as usize & LAST as usize]
}

pub(super) static SRGB_8: LazyLock<[f32; 256]> =
    LazyLock::new(|| std::array::from_fn(|i| srgb_to_linear(i as f32 / 255.0)));

/// One texel, linear.
pub(super) fn texel(image: &Image, space: ColorSpace, x: u32, y: u32) -> Vec4 {
    let at = 4 * (y as usize * image.width as usize + x as usize);
    match &image.pixels {
        Pixels::Rgba8(p) => {
            let [r, g, b, a] = [p[at], p[at + 1], p[at + 2], p[at + 3]];
            let alpha = f32::from(a) * (1.0 / 255.0);
            match space {
                ColorSpace::Srgb => {
                    let table = &*SRGB_8;
                    Vec4::new(table[r as usize], table[g as usize], table[b as usize], alpha)
                }
                ColorSpace::Linear => {
                    Vec3::new(f32::from(r), f32::from(g), f32::from(b)).extend(0.0) / 255.0 + Vec4::W * alpha
                }
            }
        }
        Pixels::Rgba16(p) => {
            let v = Vec4::from([p[at], p[at + 1], p[at + 2], p[at + 3]].map(|c| f32::from(c) / 65535.0));
            match space {
                ColorSpace::Srgb => Vec4::new(srgb_to_linear(v.x), srgb_to_linear(v.y), srgb_to_linear(v.z), v.w),
                ColorSpace::Linear => v,
            }
        }
        Pixels::RgbaF32(p) => Vec4::new(p[at], p[at + 1], p[at + 2], p[at + 3]),
    }
}

/// Where a coordinate lies among `size` texels: `along` them, with texel 0 from 0 to 1, between −½ and `size`. Coordinates are
/// wrapped before they are multiplied, so that no precision is lost far out.
fn texels_along(coordinate: f32, size: u32, mode: Wrap) -> f32 {
    let size = size as f32;
    match mode {
        Wrap::Repeat => (coordinate - floor(coordinate)) * size,
        Wrap::Clamp => coordinate.max(0.0).min(1.0) * size,
        Wrap::Mirror => {
            let turn = coordinate - 2.0 * floor(coordinate * 0.5);
            (if turn > 1.0 { 2.0 - turn } else { turn }) * size
        }
    }
}

/// The texel that has a number between −1 and `size`: that at the other side, or the last one again.
fn wrapped(index: i32, size: u32, mode: Wrap) -> u32 {
    let last = size as i32 - 1;
    match mode {
        Wrap::Repeat if index < 0 => last as u32,
        Wrap::Repeat if index > last => 0,
        _ => index.clamp(0, last) as u32,
    }
}

/// Without a call, for numbers that are small or whole.
fn floor(x: f32) -> f32 {
    if x.abs() >= 8_388_608.0 {
        return x;
    }
    let whole = x as i32 as f32;
    if whole > x { whole - 1.0 } else { whole }
}

/// The linear RGBA value of a texture at texture coordinates (before the reference's transform), unfiltered.
pub fn lookup(scene: &Scene, reference: &TextureRef, uvs: &[[f32; 2]; 2]) -> Vec4 {
    let texture = &scene.textures[reference.texture as usize];
    read(&scene.images[texture.image as usize], texture, reference, uvs)
}

/// Reads a texture in one of the sizes of its image.
fn read(image: &Image, texture: &Texture, reference: &TextureRef, uvs: &[[f32; 2]; 2]) -> Vec4 {
    let texel = |x, y| texel(image, texture.color_space, x, y);
    interpolate(image, texture, reference, uvs, texel).unwrap_or(Vec4::ZERO)
}

/// What lies at texture coordinates, made of what `texel` gives for columns and rows; `None` for coordinates that are no
/// numbers.
#[inline]
fn interpolate<T: Copy + Add<Output = T> + Mul<f32, Output = T>>(
    image: &Image,
    texture: &Texture,
    reference: &TextureRef,
    uvs: &[[f32; 2]; 2],
    texel: impl Fn(u32, u32) -> T,
) -> Option<T> {
    let [u, v] = reference.transform.apply(uvs[reference.uv_set as usize & 1]);
    if !u.is_finite() || !v.is_finite() {
        return None;
    }
    let (width, height) = (image.width, image.height);
    let (x, y) = (texels_along(u, width, texture.wrap_u), texels_along(v, height, texture.wrap_v));
    let (column, row) = (|x| wrapped(x, width, texture.wrap_u), |y| wrapped(y, height, texture.wrap_v));
    if texture.filter == Filter::Nearest {
        return Some(texel(column(x as i32), row(y as i32)));
    }
    let (x, y) = (x - 0.5, y - 0.5);
    let (x0, y0) = (floor(x), floor(y));
    let (fx, fy) = (x - x0, y - y0);
    let (left, right) = (column(x0 as i32), column(x0 as i32 + 1));
    let (top, bottom) = (row(y0 as i32), row(y0 as i32 + 1));
    let upper = texel(left, top) * (1.0 - fx) + texel(right, top) * fx;
    let lower = texel(left, bottom) * (1.0 - fx) + texel(right, bottom) * fx;
    Some(upper * (1.0 - fy) + lower * fy)
}

/// The value of a scalar input that is read from an alpha channel of 8 bits, unfiltered: what [`scalar`] gives, sooner.
fn alpha_8(scene: &Scene, input: &ScalarInput, uvs: &[[f32; 2]; 2]) -> Option<f32> {
    let reference = input.texture.as_ref().filter(|_| input.channel == Channel::A && input.factor != 0.0)?;
    let texture = &scene.textures[reference.texture as usize];
    let image = &scene.images[texture.image as usize];
    let Pixels::Rgba8(bytes) = &image.pixels else { return None };
    let texel =
        |x: u32, y: u32| f32::from(bytes[4 * (y as usize * image.width as usize + x as usize) + 3]) * (1.0 / 255.0);
    Some(input.bias + input.factor * interpolate(image, texture, reference, uvs, texel).unwrap_or(0.0))
}

/// The value of a colour input, unfiltered.
pub fn color(scene: &Scene, input: &ColorInput, uvs: &[[f32; 2]; 2]) -> Vec3 {
    color_by(input, |reference| lookup(scene, reference, uvs))
}

/// The value of a scalar input, unfiltered.
pub fn scalar(scene: &Scene, input: &ScalarInput, uvs: &[[f32; 2]; 2]) -> f32 {
    alpha_8(scene, input, uvs).unwrap_or_else(|| scalar_by(input, |reference| lookup(scene, reference, uvs)))
}

fn color_by(input: &ColorInput, lookup: impl FnOnce(&TextureRef) -> Vec4) -> Vec3 {
    let factor = Vec3::from(input.factor);
    match &input.texture {
        Some(reference) if !input.is_black() => factor * lookup(reference).truncate(),
        _ => factor,
    }
}

fn scalar_by(input: &ScalarInput, lookup: impl FnOnce(&TextureRef) -> Vec4) -> f32 {
    match &input.texture {
        Some(reference) if input.factor != 0.0 => {
            let value = lookup(reference);
            let channel = match input.channel {
                Channel::R => value.x,
                Channel::G => value.y,
                Channel::B => value.z,
                Channel::A => value.w,
            };
            input.bias + input.factor * channel
        }
        _ => input.bias + input.factor,
    }
}

/// Reads textures at a point as a ray of some width sees them.
#[derive(Clone, Copy, Debug)]
pub struct Reader<'a> {
    /// Holds the textures.
    pub scene: &'a Scene,
    /// Their smaller versions.
    pub pyramids: &'a Pyramids,
    /// Both sets of texture coordinates.
    pub uv: [[f32; 2]; 2],
    /// The ray's width squared in units of each set: the area of the texture that it sees, obliqueness left out.
    pub footprint: [f32; 2],
}

impl Reader<'_> {
    /// The linear RGBA value of a texture.
    #[inline]
    pub fn lookup(&self, reference: &TextureRef) -> Vec4 {
        let texture = &self.scene.textures[reference.texture as usize];
        let image = &self.scene.images[texture.image as usize];
        let footprint = self.footprint[reference.uv_set as usize & 1];
        let image = if footprint > 0.0 {
            let [[a, b], [c, d]] = reference.transform.linear;
            let texels = footprint * (a * d - b * c).abs() * (image.width as f32 * image.height as f32);
            self.pyramids.level(self.scene, reference.texture, level(texels))
        } else {
            image
        };
        read(image, texture, reference, &self.uv)
    }

    /// The value of a colour input.
    #[inline]
    pub fn color(&self, input: &ColorInput) -> Vec3 {
        color_by(input, |reference| self.lookup(reference))
    }

    /// The value of a scalar input.
    #[inline]
    pub fn scalar(&self, input: &ScalarInput) -> f32 {
        scalar_by(input, |reference| self.lookup(reference))
    }
}

/// ⌊log₂ √texels⌋, at least 0: by how many halvings an area of `texels` (≥ 0, or NaN: none) comes to be from one to four
/// texels of what is left. The finer of the two levels that a trilinear filter would mix.
#[inline]
fn level(texels: f32) -> u32 {
    if texels >= 1.0 { ((texels.to_bits() >> 23) - 127) / 2 } else { 0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn two_by_two(filter: Filter, wrap: Wrap) -> Scene {
        let pixels = [0, 0, 0, 255, 255, 0, 0, 255, 0, 255, 0, 255, 0, 0, 255, 0].to_vec();
        Scene {
            images: vec![Image { name: String::new(), width: 2, height: 2, pixels: Pixels::Rgba8(pixels) }],
            textures: vec![Texture { image: 0, wrap_u: wrap, wrap_v: wrap, filter, color_space: ColorSpace::Srgb }],
            ..Scene::default()
        }
    }

    #[test]
    fn texel_centres_give_the_texels_and_the_middle_their_mean() {
        let scene = two_by_two(Filter::Linear, Wrap::Repeat);
        let at = |u, v| lookup(&scene, &TextureRef::new(0), &[[u, v], [0.0; 2]]);
        assert_eq!(at(0.25, 0.25), Vec4::new(0.0, 0.0, 0.0, 1.0));
        assert_eq!(at(0.75, 0.25), Vec4::new(1.0, 0.0, 0.0, 1.0));
        assert_eq!(at(0.25, 0.75), Vec4::new(0.0, 1.0, 0.0, 1.0));
        assert!((at(0.5, 0.5) - Vec4::new(0.25, 0.25, 0.25, 0.75)).length() < 1e-6);
        assert_eq!(at(-0.75, 1.25), at(0.25, 0.25));
    }

    #[test]
    fn wrap_modes() {
        let nearest =
            |mode, u| lookup(&two_by_two(Filter::Nearest, mode), &TextureRef::new(0), &[[u, 0.1], [0.0; 2]]).x;
        assert_eq!([-0.9, -0.1, 0.1, 0.9, 1.1, 1.9].map(|u| nearest(Wrap::Repeat, u)), [0.0, 1.0, 0.0, 1.0, 0.0, 1.0]);
        assert_eq!([-0.9, -0.1, 0.1, 0.9, 1.1, 1.9].map(|u| nearest(Wrap::Clamp, u)), [0.0, 0.0, 0.0, 1.0, 1.0, 1.0]);
        assert_eq!([-0.9, -0.1, 0.1, 0.9, 1.1, 1.9].map(|u| nearest(Wrap::Mirror, u)), [1.0, 0.0, 0.0, 1.0, 1.0, 0.0]);
    }

    #[test]
    fn coverage_reads_what_a_whole_look_up_has_for_alpha() {
        for (filter, wrap) in [
            (Filter::Linear, Wrap::Repeat),
            (Filter::Linear, Wrap::Mirror),
            (Filter::Linear, Wrap::Clamp),
            (Filter::Nearest, Wrap::Repeat),
        ] {
            let mut scene = two_by_two(filter, wrap);
            if let Pixels::Rgba8(pixels) = &mut scene.images[0].pixels {
                pixels.iter_mut().enumerate().for_each(|(k, x)| *x = (k * 37 + 11) as u8);
            }
            let reference = TextureRef::new(0);
            let input = ScalarInput { factor: 0.8, texture: Some(reference), channel: Channel::A, bias: 0.1 };
            for k in 0..200 {
                let uv = [k as f32 * 0.037 - 2.3, k as f32 * -0.051 + 3.1];
                let whole = 0.1 + 0.8 * lookup(&scene, &reference, &[uv; 2]).w;
                assert_eq!(alpha_8(&scene, &input, &[uv; 2]), Some(whole));
            }
            assert_eq!(alpha_8(&scene, &ScalarInput { channel: Channel::R, ..input }, &[[0.0; 2]; 2]), None);
        }
    }

    #[test]
    fn far_out_coordinates_wrap_as_exactly_as_they_are() {
        let scene = two_by_two(Filter::Linear, Wrap::Repeat);
        let at = |u: f32| lookup(&scene, &TextureRef::new(0), &[[u, 0.25], [0.0; 2]]);
        for turns in [1.0, 100.0, 65536.0, -4096.0] {
            assert_eq!(at(turns + 0.375), at(0.375));
        }
    }

    #[test]
    fn srgb_decoding_has_its_known_values() {
        assert_eq!(srgb_to_linear(1.0), 1.0);
        assert!((srgb_to_linear(0.5) - 0.214_041_1).abs() < 1e-6);
        assert!((srgb_to_linear(0.04) - 0.003_095_975).abs() < 1e-8);
    }

    #[test]
    fn bytes_survive_decoding_and_encoding() {
        for byte in 0..=255u8 {
            assert_eq!(linear_to_srgb_8(SRGB_8[byte as usize]), byte);
        }
        assert_eq!((linear_to_srgb_8(0.0), linear_to_srgb_8(1.0), linear_to_srgb_8(0.214_041_1)), (0, 255, 128));
    }

    #[test]
    fn levels_are_halvings() {
        let texels = [0.0, 0.9, 1.0, 3.9, 4.0, 15.9, 16.0, 1e6, f32::NAN, f32::INFINITY];
        assert_eq!(texels.map(level), [0, 0, 0, 0, 1, 1, 2, 9, 0, 64]);
    }

    #[test]
    fn wide_rays_see_the_mean_and_narrow_ones_the_texels() {
        let scene = two_by_two(Filter::Linear, Wrap::Repeat);
        let pyramids = Pyramids::new(&scene, &kiln_formats::Control::default());
        let at = |uv, width: f32| {
            let reader = Reader { scene: &scene, pyramids: &pyramids, uv: [uv; 2], footprint: [width * width; 2] };
            reader.lookup(&TextureRef::new(0))
        };
        assert_eq!(at([0.75, 0.25], 0.0), Vec4::new(1.0, 0.0, 0.0, 1.0));
        assert_eq!(at([0.75, 0.25], 0.9), Vec4::new(1.0, 0.0, 0.0, 1.0));
        let mean = Vec4::new(0.25, 0.25, 0.25, 0.75);
        for uv in [[0.75, 0.25], [0.1, 0.6]] {
            // Bytes in between.
            assert!((at(uv, 1.1) - mean).abs().max_element() < 0.004, "{}", at(uv, 1.1));
        }
    }
}
