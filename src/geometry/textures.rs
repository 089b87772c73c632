//! Texture look-ups: wrap, filter, decode.

use glam::{Vec3, Vec4};
use kiln_formats::Scene;
use kiln_formats::scene::{Channel, ColorInput, ColorSpace, Filter, Image, Pixels, ScalarInput, TextureRef, Wrap};
use std::sync::LazyLock;

/// The sRGB transfer function of IEC 61966-2-1, from stored [0, 1] to linear.
pub fn srgb_to_linear(x: f32) -> f32 {
    if x <= 0.04045 { x / 12.92 } else { libm::powf((x + 0.055) / 1.055, 2.4) }
}

static SRGB_8: LazyLock<[f32; 256]> = LazyLock::new(|| std::array::from_fn(|i| srgb_to_linear(i as f32 / 255.0)));

/// One texel, linear.
fn texel(image: &Image, space: ColorSpace, x: u32, y: u32) -> Vec4 {
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

fn wrap(index: i64, size: u32, mode: Wrap) -> u32 {
    let n = i64::from(size);
    // Nearly always, and without a division.
    if (0..n).contains(&index) {
        return index as u32;
    }
    let wrapped = match mode {
        Wrap::Repeat => index.rem_euclid(n),
        Wrap::Clamp => index.clamp(0, n - 1),
        Wrap::Mirror => {
            let m = index.rem_euclid(2 * n);
            if m < n { m } else { 2 * n - 1 - m }
        }
    };
    wrapped as u32
}

/// The linear RGBA value of a texture at texture coordinates (before the reference's transform).
pub fn lookup(scene: &Scene, reference: &TextureRef, uvs: &[[f32; 2]; 2]) -> Vec4 {
    let texture = &scene.textures[reference.texture as usize];
    let image = &scene.images[texture.image as usize];
    let [u, v] = reference.transform.apply(uvs[reference.uv_set as usize & 1]);
    if !u.is_finite() || !v.is_finite() {
        return Vec4::ZERO;
    }
    let (x, y) = (f64::from(u) * f64::from(image.width), f64::from(v) * f64::from(image.height));
    let fetch = |x: f64, y: f64| {
        let (x, y) = (wrap(x as i64, image.width, texture.wrap_u), wrap(y as i64, image.height, texture.wrap_v));
        texel(image, texture.color_space, x, y)
    };
    match texture.filter {
        Filter::Nearest => fetch(x.floor(), y.floor()),
        Filter::Linear => {
            let (x, y) = (x - 0.5, y - 0.5);
            let (x0, y0) = (x.floor(), y.floor());
            let (fx, fy) = ((x - x0) as f32, (y - y0) as f32);
            let upper = fetch(x0, y0) * (1.0 - fx) + fetch(x0 + 1.0, y0) * fx;
            let lower = fetch(x0, y0 + 1.0) * (1.0 - fx) + fetch(x0 + 1.0, y0 + 1.0) * fx;
            upper * (1.0 - fy) + lower * fy
        }
    }
}

/// The value of a colour input.
pub fn color(scene: &Scene, input: &ColorInput, uvs: &[[f32; 2]; 2]) -> Vec3 {
    let factor = Vec3::from(input.factor);
    match &input.texture {
        Some(reference) if !input.is_black() => factor * lookup(scene, reference, uvs).truncate(),
        _ => factor,
    }
}

/// The value of a scalar input.
pub fn scalar(scene: &Scene, input: &ScalarInput, uvs: &[[f32; 2]; 2]) -> f32 {
    match &input.texture {
        Some(reference) if input.factor != 0.0 => {
            let value = lookup(scene, reference, uvs);
            input.factor
                * match input.channel {
                    Channel::R => value.x,
                    Channel::G => value.y,
                    Channel::B => value.z,
                    Channel::A => value.w,
                }
        }
        _ => input.factor,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use kiln_formats::scene::Texture;

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
    fn srgb_decoding_has_its_known_values() {
        assert_eq!(srgb_to_linear(1.0), 1.0);
        assert!((srgb_to_linear(0.5) - 0.214_041_1).abs() < 1e-6);
        assert!((srgb_to_linear(0.04) - 0.003_095_975).abs() < 1e-8);
    }
}
