//! Decoding of image files, with limits, through the `image` crate, and `image_dds` for DDS.

use crate::scene::{Image, Pixels};
use crate::{ErrorCode, ImportError};
use crate::{dds, straight};
use image::error::LimitErrorKind;
use image::{ColorType, DynamicImage, ImageDecoder, ImageError, ImageFormat, ImageReader};
use std::alloc::{Layout, handle_alloc_error};
use std::any::Any;
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

fn broken(cause: &ImageError, format: ImageFormat, name: &str) -> ImportError {
    let (code, what) = match cause {
        ImageError::Unsupported(_) => (ErrorCode::Unsupported, "uses what Kiln does not read"),
        ImageError::Limits(_) => (ErrorCode::TooLarge, "exceeds the limits"),
        _ => (ErrorCode::Invalid, "is not sound"),
    };
    ImportError::new(code, format!("{format:?} image {what}: {cause}")).in_file(name)
}

/// Runs a third-party decoder; a panic in it is the image's fault, unless it is about memory.
fn guarded<T>(name: &str, run: impl FnOnce() -> Result<T, ImportError>) -> Result<T, ImportError> {
    catch_unwind(AssertUnwindSafe(run)).unwrap_or_else(|panic| {
        if is_refused_allocation(&*panic) {
            out_of_memory(0);
        }
        Err(ImportError::new(ErrorCode::Invalid, "is not a sound image: its decoder panicked").in_file(name))
    })
}

/// Whether a decoder panicked because it was given no memory, which it says in the words of [`std::collections::TryReserveError`].
fn is_refused_allocation(panic: &(dyn Any + Send)) -> bool {
    panic.downcast_ref::<String>().is_some_and(|text| text.contains("TryReserveError") && text.contains("AllocError"))
}

/// What every refused allocation comes to: an asset is not to be shown without a texture because there was no memory for it.
fn out_of_memory(bytes: u64) -> ! {
    let layout = usize::try_from(bytes).ok().and_then(|bytes| Layout::array::<u8>(bytes).ok());
    handle_alloc_error(layout.unwrap_or(Layout::new::<u8>()))
}

/// Width and height by the header alone, so that images can be held against a limit before any is decoded.
///
/// # Errors
/// As [`decode`], without the limit.
pub fn dimensions(bytes: &[u8], name: &str) -> Result<(u32, u32), ImportError> {
    if dds::is_dds(bytes) {
        let cut = || ImportError::new(ErrorCode::Invalid, "is a DDS image that is cut short").in_file(name);
        return dds::dimensions(bytes).ok_or_else(cut);
    }
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
    let decode = if dds::is_dds(bytes) { dds::decode } else { decode_unguarded };
    guarded(name, || decode(bytes, name, max_texels))
}

/// What the header says of an image: as [`decode`], with its size and the kind of its pixels, but none of them.
///
/// # Errors
/// As [`decode`], as far as the header tells.
pub fn header(bytes: &[u8], name: &str, max_texels: u64) -> Result<Image, ImportError> {
    let (width, height) = dimensions(bytes, name)?;
    check_size((width, height), name, max_texels)?;
    let pixels = if dds::is_dds(bytes) {
        if dds::has_floats(bytes) { Pixels::RgbaF32(Vec::new()) } else { Pixels::Rgba8(Vec::new()) }
    } else {
        let color = guarded(name, || open(bytes, name, u64::MAX).map(|(_, decoder)| decoder.color_type()))?;
        match color {
            ColorType::L16 | ColorType::La16 | ColorType::Rgb16 | ColorType::Rgba16 => Pixels::Rgba16(Vec::new()),
            ColorType::Rgb32F | ColorType::Rgba32F => Pixels::RgbaF32(Vec::new()),
            _ => Pixels::Rgba8(Vec::new()),
        }
    };
    Ok(Image { name: name.into(), width, height, pixels })
}

fn check_size((width, height): (u32, u32), name: &str, max_texels: u64) -> Result<u64, ImportError> {
    let texels = u64::from(width) * u64::from(height);
    let error = |code, message: String| Err(ImportError::new(code, message).in_file(name));
    if texels > max_texels {
        return error(ErrorCode::TooLarge, format!("{width}×{height} texels exceed the limit of {max_texels}"));
    }
    if texels == 0 {
        return error(ErrorCode::Invalid, "has no pixels".into());
    }
    Ok(texels)
}

fn decode_unguarded(bytes: &[u8], name: &str, max_texels: u64) -> Result<Image, ImportError> {
    let (format, decoder) = open(bytes, name, max_texels)?;
    let (width, height) = decoder.dimensions();
    let texels = check_size((width, height), name, max_texels)?;
    if format == ImageFormat::OpenExr {
        let too_large = |message| ImportError::new(ErrorCode::TooLarge, message).in_file(name);
        plausible_exr(bytes, max_texels).map_err(too_large)?;
    }
    if let Some(rgba) = straight::rgba(bytes, texels) {
        return Ok(Image { name: name.into(), width, height, pixels: Pixels::Rgba8(rgba) });
    }
    let needed = decoder.total_bytes().saturating_add(4 * texels);
    let decoded = DynamicImage::from_decoder(decoder).map_err(|e| {
        // A decoder speaks of memory also where a corrupt file asks for too much of it.
        let about_memory = matches!(&e, ImageError::Limits(e) if e.kind() == LimitErrorKind::InsufficientMemory);
        if about_memory && !can_be_had(needed) {
            out_of_memory(needed);
        }
        broken(&e, format, name)
    })?;
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
        DynamicImage::ImageRgb8(rgb) => {
            let mut rgba = vec![0; rgb.as_raw().len() / 3 * 4];
            straight::spread(rgb.as_raw(), &mut rgba);
            Pixels::Rgba8(rgba)
        }
        d => Pixels::Rgba8(d.into_rgba8().into_raw()),
    };
    Ok(Image { name: name.into(), width, height, pixels })
}

/// Uncompressed bytes that a byte of an EXR file can stand for at most, generously: deflate's best is 1030.
const MOST_OF_A_BYTE: u64 = 4096;

/// An EXR file has two windows, of which decoders believe either: what is stored, and what is to be shown. Neither may be much more than the
/// file's bytes can hold.
fn plausible_exr(bytes: &[u8], max_texels: u64) -> Result<(), String> {
    let meta = exr::meta::MetaData::read_from_buffered(Cursor::new(bytes), false).map_err(|e| e.to_string())?;
    let area = |size: exr::math::Vec2<usize>| (size.0 as u64).saturating_mul(size.1 as u64);
    let can_hold = (bytes.len() as u64).saturating_mul(MOST_OF_A_BYTE);
    for header in &meta.headers {
        let (stored, shown) = (area(header.layer_size), area(header.shared_attributes.display_window.size));
        let needed = stored.max(shown).saturating_mul(header.channels.bytes_per_pixel.max(1) as u64);
        if stored.max(shown) > max_texels || needed > can_hold {
            return Err(format!(
                "an EXR header that claims {stored} texels, {shown} of them shown, in {} bytes",
                bytes.len()
            ));
        }
    }
    Ok(())
}

/// Whether so much memory can be had now.
fn can_be_had(bytes: u64) -> bool {
    usize::try_from(bytes).is_ok_and(|bytes| Vec::<u8>::new().try_reserve_exact(bytes).is_ok())
}

#[cfg(test)]
#[path = "images_tests.rs"]
mod tests;
