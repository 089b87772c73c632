//! Decoding of image files, with limits, through the `image` crate.

use crate::scene::{Image, Pixels};
use crate::{ErrorCode, ImportError};
use image::{DynamicImage, ImageDecoder, ImageFormat, ImageReader};
use std::io::Cursor;

/// Decodes an image file to RGBA as stored.
///
/// The format is told by the first bytes, and by `name`'s ending only where there is no signature (TGA). 8-bit
/// images give [`Pixels::Rgba8`], 16-bit ones [`Pixels::Rgba16`], float ones (Radiance HDR) [`Pixels::RgbaF32`].
/// Grey is spread over RGB; missing alpha is opaque. EXIF and ICC data are ignored.
///
/// # Errors
/// [`ErrorCode::TooLarge`] when the header claims more than `max_texels` (before anything is allocated),
/// [`ErrorCode::Unsupported`] for other formats, [`ErrorCode::Invalid`] for corrupt data; the file is `name`.
pub fn decode(bytes: &[u8], name: &str, max_texels: u64) -> Result<Image, ImportError> {
    let error = |code, message: String| ImportError::new(code, message).in_file(name);
    let reader = ImageReader::new(Cursor::new(bytes))
        .with_guessed_format()
        .map_err(|e| error(ErrorCode::Io, format!("cannot be read: {e}")))?;
    let by_name = || ImageFormat::from_path(name).ok().filter(|f| matches!(f, ImageFormat::Tga));
    let format = reader
        .format()
        .or_else(by_name)
        .filter(|f| f.reading_enabled())
        .ok_or_else(|| error(ErrorCode::Unsupported, "is not an image format that Kiln reads".into()))?;
    let mut reader = ImageReader::with_format(Cursor::new(bytes), format);
    let mut limits = image::Limits::default();
    limits.max_alloc = Some(max_texels.saturating_mul(16).max(1 << 20));
    reader.limits(limits);
    let corrupt = |e: image::ImageError| error(ErrorCode::Invalid, format!("is not a sound {format:?} image: {e}"));
    let decoder = reader.into_decoder().map_err(corrupt)?;
    let (width, height) = decoder.dimensions();
    let texels = u64::from(width) * u64::from(height);
    if texels > max_texels {
        return Err(error(ErrorCode::TooLarge, format!("{width}×{height} texels exceed the limit of {max_texels}")));
    }
    if texels == 0 {
        return Err(error(ErrorCode::Invalid, "has no pixels".into()));
    }
    let decoded = DynamicImage::from_decoder(decoder).map_err(corrupt)?;
    let pixels = match decoded {
        d @ (DynamicImage::ImageLuma16(_)
        | DynamicImage::ImageLumaA16(_)
        | DynamicImage::ImageRgb16(_)
        | DynamicImage::ImageRgba16(_)) => Pixels::Rgba16(d.into_rgba16().into_raw()),
        d @ (DynamicImage::ImageRgb32F(_) | DynamicImage::ImageRgba32F(_)) => {
            let mut values = d.into_rgba32f().into_raw();
            values.iter_mut().filter(|x| !x.is_finite()).for_each(|x| *x = 0.0);
            Pixels::RgbaF32(values)
        }
        d => Pixels::Rgba8(d.into_rgba8().into_raw()),
    };
    Ok(Image { name: name.into(), width, height, pixels })
}
