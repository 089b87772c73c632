use super::{ImageId, TextureId};

/// Pixels of an image, row by row from the top, RGBA interleaved, as stored in the file (not yet linearised).
#[derive(Clone, Debug)]
pub enum Pixels {
    /// Four bytes a pixel.
    Rgba8(Vec<u8>),
    /// Four 16-bit values a pixel, native order.
    Rgba16(Vec<u16>),
    /// Four floats a pixel; always linear.
    RgbaF32(Vec<f32>),
}

/// A decoded image.
#[derive(Clone, Debug)]
pub struct Image {
    /// Name or file, for messages.
    pub name: String,
    /// Width in pixels, ≥ 1.
    pub width: u32,
    /// Height in pixels, ≥ 1.
    pub height: u32,
    /// `4 · width · height` values.
    pub pixels: Pixels,
}

/// How coordinates outside [0, 1] are taken.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Wrap {
    /// Tiles.
    #[default]
    Repeat,
    /// Tiles, every other one mirrored.
    Mirror,
    /// The border's texels go on for ever.
    Clamp,
}

/// Interpolation between texels.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Filter {
    /// Bilinear, between decoded (linear) values.
    #[default]
    Linear,
    /// The nearest texel.
    Nearest,
}

/// How stored values become linear ones. Alpha is always linear.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum ColorSpace {
    /// IEC 61966-2-1 transfer function: colours.
    #[default]
    Srgb,
    /// As stored: data, and the colours of `.ray` textures.
    Linear,
}

/// An image with its way of being sampled.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Texture {
    /// The image.
    pub image: ImageId,
    /// Wrapping across.
    pub wrap_u: Wrap,
    /// Wrapping down.
    pub wrap_v: Wrap,
    /// Interpolation.
    pub filter: Filter,
    /// Decoding.
    pub color_space: ColorSpace,
}

/// An affine map of texture coordinates (KHR_texture_transform): `uv' = linear · uv + offset`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct UvTransform {
    /// Row-major 2×2 matrix.
    pub linear: [[f32; 2]; 2],
    /// Added after the matrix.
    pub offset: [f32; 2],
}

impl UvTransform {
    /// Changes nothing.
    pub const IDENTITY: Self = Self { linear: [[1.0, 0.0], [0.0, 1.0]], offset: [0.0, 0.0] };

    /// The mapped coordinates.
    pub fn apply(&self, [u, v]: [f32; 2]) -> [f32; 2] {
        let [[a, b], [c, d]] = self.linear;
        [a * u + b * v + self.offset[0], c * u + d * v + self.offset[1]]
    }
}

/// A texture as one input of a material uses it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TextureRef {
    /// The texture.
    pub texture: TextureId,
    /// Which of the mesh's two sets of coordinates, 0 or 1. A mesh without that set reads at (0, 0).
    pub uv_set: u8,
    /// Applied to the coordinates first.
    pub transform: UvTransform,
}

impl TextureRef {
    /// The texture, read with the first set of coordinates as they are.
    pub fn new(texture: TextureId) -> Self {
        Self { texture, uv_set: 0, transform: UvTransform::IDENTITY }
    }
}
