use super::{Lower, Result};
use crate::ray::source::Offset;
use crate::repair::heights;
use crate::scene::{Channel, ColorSpace, Filter, Image, ImageId, Pixels, Texture, TextureId, Wrap};
use crate::{ImportError, images};
use std::collections::HashMap;

/// Textures read so far.
#[derive(Default)]
pub(super) struct Textures {
    /// By file and use.
    ids: HashMap<(String, Use), TextureId>,
    /// The largest value of each channel, per texture.
    brightest: Vec<[f32; 3]>,
    texels: u64,
}

/// What becomes of a texture's values.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) enum Use {
    /// They are taken as they are.
    Color,
    /// They are turned to grey.
    Grey,
    /// They are heights, of which normals are made.
    Heights,
}

impl Textures {
    /// The largest value of each channel.
    pub fn brightest(&self, texture: TextureId) -> [f32; 3] {
        self.brightest.get(texture as usize).copied().unwrap_or([1.0; 3])
    }
}

impl Lower<'_, '_> {
    /// Reads a texture. Its values are taken as stored, with the edge texels going on beyond [0, 1]; where a number
    /// is wanted, its luma. A texture that cannot be read stops the scene, as in the course tracers.
    pub(super) fn texture(&mut self, file: &str, wanted: Use, at: Offset) -> Result<TextureId> {
        let key = (file.replace('\\', "/"), wanted);
        if let Some(id) = self.textures.ids.get(&key) {
            return Ok(*id);
        }
        let left = self.resources.limits().max_texels.saturating_sub(self.textures.texels);
        let read = self.resources.read(file).and_then(|bytes| images::decode(&bytes, file, left));
        let mut image = read.map_err(|error| self.unreadable(file, &error, at))?;
        match wanted {
            Use::Color => {}
            Use::Grey => image.pixels = luma(&image.pixels),
            Use::Heights => {
                image.pixels = luma(&image.pixels);
                image = heights::to_normals(&image, Channel::R, true);
            }
        }
        self.textures.texels += u64::from(image.width) * u64::from(image.height);
        self.textures.brightest.push(brightest(&image));
        let id = self.scene.textures.len() as TextureId;
        self.scene.textures.push(Texture {
            image: self.scene.images.len() as ImageId,
            wrap_u: Wrap::Clamp,
            wrap_v: Wrap::Clamp,
            filter: Filter::Linear,
            color_space: ColorSpace::Linear,
        });
        self.scene.images.push(image);
        self.textures.ids.insert(key, id);
        Ok(id)
    }

    fn unreadable(&self, file: &str, error: &ImportError, at: Offset) -> ImportError {
        let folder = self.resources.resolve(".").map(|folder| format!(" (looked in {})", folder.display()));
        let message = format!("cannot read texture `{file}`: {}{}", error.message, folder.unwrap_or_default());
        self.source.error(error.code, at, message)
    }
}

/// Rec. 601 luma, the course's "intensity", spread over RGB. Eight bits become sixteen, so that little is rounded.
fn luma(pixels: &Pixels) -> Pixels {
    let weigh = |[r, g, b]: [f64; 3]| 0.299 * r + 0.587 * g + 0.114 * b;
    let sixteen = |r: f64, g: f64, b: f64| (weigh([r, g, b]) + 0.5) as u16;
    match pixels {
        Pixels::Rgba8(values) => Pixels::Rgba16(
            values
                .chunks_exact(4)
                .flat_map(|p| {
                    let y = sixteen(257.0 * f64::from(p[0]), 257.0 * f64::from(p[1]), 257.0 * f64::from(p[2]));
                    [y, y, y, 257 * u16::from(p[3])]
                })
                .collect(),
        ),
        Pixels::Rgba16(values) => Pixels::Rgba16(
            values
                .chunks_exact(4)
                .flat_map(|p| {
                    let y = sixteen(f64::from(p[0]), f64::from(p[1]), f64::from(p[2]));
                    [y, y, y, p[3]]
                })
                .collect(),
        ),
        Pixels::RgbaF32(values) => Pixels::RgbaF32(
            values
                .chunks_exact(4)
                .flat_map(|p| {
                    let y = weigh([p[0], p[1], p[2]].map(f64::from)) as f32;
                    [y, y, y, p[3]]
                })
                .collect(),
        ),
    }
}

fn brightest(image: &Image) -> [f32; 3] {
    fn largest<T: Copy>(values: &[T], to_float: impl Fn(T) -> f32) -> [f32; 3] {
        values.chunks_exact(4).fold([0.0; 3], |most, p| [0, 1, 2].map(|i| f32::max(most[i], to_float(p[i]))))
    }
    match &image.pixels {
        Pixels::Rgba8(values) => largest(values, |v| f32::from(v) / 255.0),
        Pixels::Rgba16(values) => largest(values, |v| f32::from(v) / 65535.0),
        Pixels::RgbaF32(values) => largest(values, |v| v),
    }
}
