use crate::film::Picture;
use crate::settings::{Background, ToneMap};
use crate::write::{display, exr, srgb};
use kiln_formats::images;
use kiln_formats::scene::Pixels;
use std::path::Path;

/// How linear pictures are shown, and what lies behind what is not covered.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Show {
    /// Tone mapping of linear pictures.
    pub tonemap: ToneMap,
    /// Exposure of linear pictures, EV.
    pub exposure_ev: f64,
    /// Laid under both pictures, sRGB. Black by default, as the error that Kiln states of a picture has it.
    pub background: [u8; 3],
}

/// A picture as it is shown, with the light behind it.
#[derive(Clone, Debug, PartialEq)]
pub struct Shown {
    /// Width in pixels, ≥ 1.
    pub width: u32,
    /// Height in pixels, ≥ 1.
    pub height: u32,
    /// Encoded sRGB in [0, 1] over the background, not rounded, row by row from the top.
    pub displayed: Vec<[f32; 3]>,
    /// Linear Rec. 709, premultiplied by coverage: radiance of a linear picture, the display's light of an encoded one.
    pub linear: Vec<[f32; 3]>,
    /// How much of the pixel is there: alpha in [0, 1].
    pub alpha: Vec<f32>,
    /// Whether `linear` is radiance, not what a display gives off.
    pub scene_referred: bool,
}

impl Shown {
    /// Of a linear picture.
    pub fn of(picture: &Picture, show: &Show) -> Self {
        let developed = display::develop(picture, show.exposure_ev, show.tonemap, Background::Transparent);
        let linear = picture.pixels.iter().map(|&[r, g, b, _]| [r, g, b]).collect();
        Self { linear, scene_referred: true, ..Self::of_encoded(picture.width, picture.height, developed.pixels, show) }
    }

    /// Of an encoded picture with straight alpha; all in [0, 1]. It is laid over the background as browsers and viewers do
    /// it, without decoding.
    fn of_encoded(width: u32, height: u32, pixels: Vec<[f32; 4]>, show: &Show) -> Self {
        let under = show.background.map(|c| f32::from(c) / 255.0);
        let over = |&[r, g, b, alpha]: &[f32; 4]| {
            let color = [r, g, b];
            std::array::from_fn(|c| color[c] * alpha + under[c] * (1.0 - alpha))
        };
        let light = |&[r, g, b, alpha]: &[f32; 4]| [r, g, b].map(|c| srgb::decode(c) * alpha);
        Self {
            width,
            height,
            displayed: pixels.iter().map(over).collect(),
            linear: pixels.iter().map(light).collect(),
            alpha: pixels.iter().map(|p| p[3]).collect(),
            scene_referred: false,
        }
    }

    /// Reads an EXR file (linear, premultiplied) or any other picture that Kiln reads (8 and 16 bits are sRGB with
    /// straight alpha, Radiance HDR is linear).
    ///
    /// # Errors
    /// A sentence with the file's name.
    pub fn read(path: &Path, show: &Show, max_texels: u64) -> Result<Self, String> {
        const EXR_MAGIC: [u8; 4] = [0x76, 0x2f, 0x31, 0x01];
        let named = |e: String| format!("{}: {e}", path.display());
        let bytes = std::fs::read(path).map_err(|e| named(format!("cannot be read: {e}")))?;
        if bytes.starts_with(&EXR_MAGIC) {
            return Ok(Self::of(&exr::decode(&bytes, max_texels).map_err(named)?, show));
        }
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        let image = images::decode(&bytes, &name, max_texels).map_err(|e| named(e.message))?;
        let (width, height) = (image.width, image.height);
        Ok(match image.pixels {
            Pixels::Rgba8(values) => {
                let pixel = |p: &[u8]| std::array::from_fn(|c| f32::from(p[c]) / 255.0);
                Self::of_encoded(width, height, values.chunks_exact(4).map(pixel).collect(), show)
            }
            Pixels::Rgba16(values) => {
                let pixel = |p: &[u16]| std::array::from_fn(|c| f32::from(p[c]) / 65535.0);
                Self::of_encoded(width, height, values.chunks_exact(4).map(pixel).collect(), show)
            }
            Pixels::RgbaF32(values) => {
                let pixels = values.chunks_exact(4).map(|p| std::array::from_fn(|c| p[c])).collect();
                Self::of(&Picture { width, height, pixels }, show)
            }
        })
    }
}
