//! Decoding of image files, with limits, through the `image` crate.

use crate::scene::{Image, Pixels};
use crate::{ErrorCode, ImportError};
use image::{DynamicImage, ImageDecoder, ImageFormat, ImageReader};
use std::io::Cursor;
use std::panic::{AssertUnwindSafe, catch_unwind};

/// A decoder that has read the header, by the format that the first bytes tell, or `name` where they cannot (TGA).
fn open<'a>(
    bytes: &'a [u8],
    name: &str,
    max_texels: u64,
) -> Result<(ImageFormat, impl ImageDecoder + 'a), ImportError> {
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
    let decoder = reader.into_decoder().map_err(|e| broken(&e, format, name))?;
    Ok((format, decoder))
}

fn broken(cause: &image::ImageError, format: ImageFormat, name: &str) -> ImportError {
    let (code, what) = match cause {
        image::ImageError::Unsupported(_) => (ErrorCode::Unsupported, "uses what Kiln does not read"),
        image::ImageError::Limits(_) => (ErrorCode::TooLarge, "exceeds the limits"),
        _ => (ErrorCode::Invalid, "is not sound"),
    };
    ImportError::new(code, format!("{format:?} image {what}: {cause}")).in_file(name)
}

/// Runs a third-party decoder; a panic in it is the image's fault.
fn guarded<T>(name: &str, run: impl FnOnce() -> Result<T, ImportError>) -> Result<T, ImportError> {
    catch_unwind(AssertUnwindSafe(run)).unwrap_or_else(|_| {
        Err(ImportError::new(ErrorCode::Invalid, "is not a sound image: its decoder panicked").in_file(name))
    })
}

/// Width and height by the header alone, so that images can be held against a limit before any is decoded.
///
/// # Errors
/// As [`decode`], without the limit.
pub fn dimensions(bytes: &[u8], name: &str) -> Result<(u32, u32), ImportError> {
    guarded(name, || open(bytes, name, u64::MAX).map(|(_, decoder)| decoder.dimensions()))
}

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
    guarded(name, || decode_unguarded(bytes, name, max_texels))
}

fn decode_unguarded(bytes: &[u8], name: &str, max_texels: u64) -> Result<Image, ImportError> {
    let error = |code, message: String| ImportError::new(code, message).in_file(name);
    let (format, decoder) = open(bytes, name, max_texels)?;
    let (width, height) = decoder.dimensions();
    let texels = u64::from(width) * u64::from(height);
    if texels > max_texels {
        return Err(error(ErrorCode::TooLarge, format!("{width}×{height} texels exceed the limit of {max_texels}")));
    }
    if texels == 0 {
        return Err(error(ErrorCode::Invalid, "has no pixels".into()));
    }
    let decoded = DynamicImage::from_decoder(decoder).map_err(|e| broken(&e, format, name))?;
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
