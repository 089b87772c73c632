//! Decoding of image files, with limits, through the `image` crate, and `image_dds` for DDS.

use crate::dds;
use crate::scene::{Image, Pixels};
use crate::{ErrorCode, ImportError};
use image::error::LimitErrorKind;
use image::{DynamicImage, ImageDecoder, ImageError, ImageFormat, ImageReader};
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
    if format == ImageFormat::OpenExr {
        plausible_exr(bytes, max_texels).map_err(|message| error(ErrorCode::TooLarge, message))?;
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
        DynamicImage::ImageRgb8(rgb) => Pixels::Rgba8(opaque(rgb.as_raw())),
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

/// RGBA of RGB, several times as fast as the conversion that suits all formats.
fn opaque(rgb: &[u8]) -> Vec<u8> {
    let rgb: &[[u8; 3]] = rgb.as_chunks().0;
    let mut rgba = vec![u8::MAX; 4 * rgb.len()];
    for (to, [r, g, b]) in rgba.as_chunks_mut().0.iter_mut().zip(rgb) {
        *to = [*r, *g, *b, u8::MAX];
    }
    rgba
}

/// Whether so much memory can be had now.
fn can_be_had(bytes: u64) -> bool {
    usize::try_from(bytes).is_ok_and(|bytes| Vec::<u8>::new().try_reserve_exact(bytes).is_ok())
}

#[cfg(test)]
mod tests {
    use super::*;
    use image::{ImageBuffer, Luma, LumaA, Rgb, Rgba};

    fn encode(image: &DynamicImage, format: ImageFormat) -> Vec<u8> {
        let mut bytes = Cursor::new(Vec::new());
        image.write_to(&mut bytes, format).unwrap();
        bytes.into_inner()
    }

    fn pixel(x: u32, y: u32) -> [u8; 4] {
        [10 + x as u8, 20 + y as u8, 30, 40 + x as u8]
    }

    fn picture() -> DynamicImage {
        ImageBuffer::from_fn(3, 2, |x, y| Rgba(pixel(x, y))).into()
    }

    #[test]
    fn lossless_formats_give_their_bytes_row_by_row_from_the_top() {
        let want: Vec<u8> = (0..2).flat_map(|y| (0..3).flat_map(move |x| pixel(x, y))).collect();
        for format in [ImageFormat::Png, ImageFormat::Tga, ImageFormat::Tiff, ImageFormat::WebP, ImageFormat::Bmp] {
            let bytes = encode(&picture(), format);
            // The ending is a lie but for TGA, which has no signature.
            let name = if format == ImageFormat::Tga { "a.tga" } else { "a.jpg" };
            let image = decode(&bytes, name, 6).unwrap();
            assert_eq!((image.width, image.height, image.name.as_str()), (3, 2, name));
            let Pixels::Rgba8(got) = image.pixels else { panic!("{format:?}") };
            assert_eq!(got, want, "{format:?}");
            assert_eq!(dimensions(&bytes, name).unwrap(), (3, 2));
        }
    }

    #[test]
    fn depth_and_missing_channels() {
        let grey = DynamicImage::from(ImageBuffer::from_pixel(1, 1, Luma([77_u8])));
        let Pixels::Rgba8(got) = decode(&encode(&grey, ImageFormat::Png), "", 1).unwrap().pixels else { panic!() };
        assert_eq!(got, [77, 77, 77, 255]);
        let deep = DynamicImage::from(ImageBuffer::from_pixel(1, 1, LumaA([1000_u16, 3])));
        let Pixels::Rgba16(got) = decode(&encode(&deep, ImageFormat::Png), "", 1).unwrap().pixels else { panic!() };
        assert_eq!(got, [1000, 1000, 1000, 3]);
        let float = DynamicImage::from(ImageBuffer::from_pixel(1, 1, Rgb([0.5_f32, 4.0, f32::NAN])));
        let Pixels::RgbaF32(got) = decode(&encode(&float, ImageFormat::Tiff), "", 1).unwrap().pixels else { panic!() };
        assert_eq!(got, [0.5, 4.0, 0.0, 1.0]);
    }

    #[test]
    fn windows_of_an_exr_file_are_not_believed() {
        let sound = encode(&ImageBuffer::from_pixel(4, 4, Rgb([0.5_f32, 4.0, 1.0])).into(), ImageFormat::OpenExr);
        let Pixels::RgbaF32(got) = decode(&sound, "", 16).unwrap().pixels else { panic!() };
        assert_eq!(got[..4], [0.5, 4.0, 1.0, 1.0]);
        for window in ["dataWindow", "displayWindow"] {
            let mut bytes = sound.clone();
            // The name, `box2i`, a size of four bytes; then x and y of the first texel, and of the last one.
            let name = [window.as_bytes(), b"\0box2i\0"].concat();
            let at = bytes.windows(name.len()).position(|w| w == name).expect("the attribute") + name.len() + 4;
            bytes[at + 8..at + 12].copy_from_slice(&30_000_i32.to_le_bytes());
            bytes[at + 12..at + 16].copy_from_slice(&30_000_i32.to_le_bytes());
            let error = decode(&bytes, "a.exr", 1 << 30).expect_err(window);
            assert!(matches!(error.code, ErrorCode::TooLarge | ErrorCode::Invalid), "{window}: {error}");
        }
    }

    #[test]
    fn a_header_alone_allocates_nothing() {
        // A PNG of 1×1 whose header claims 65535 × 65535; the checksum of the header chunk is made right.
        let mut bytes = encode(&ImageBuffer::from_pixel(1, 1, Luma([0_u8])).into(), ImageFormat::Png);
        bytes[16..24].copy_from_slice(&[0, 0, 255, 255, 0, 0, 255, 255]);
        let crc = bytes[12..29].iter().fold(!0_u32, |crc, byte| {
            (0..8).fold(crc ^ u32::from(*byte), |c, _| if c & 1 == 1 { 0xedb8_8320 ^ (c >> 1) } else { c >> 1 })
        });
        bytes[29..33].copy_from_slice(&(!crc).to_be_bytes());
        assert_eq!(dimensions(&bytes, "").unwrap(), (65535, 65535));
        assert_eq!(decode(&bytes, "big.png", 1 << 30).unwrap_err().code, ErrorCode::TooLarge);
        assert_eq!(decode(&encode(&picture(), ImageFormat::Png), "", 5).unwrap_err().code, ErrorCode::TooLarge);
    }

    #[test]
    fn what_is_no_image_is_told_from_what_is_a_broken_one() {
        for bytes in [&b""[..], b"BLENDER", b"8BPS\0\x01 a Photoshop file"] {
            assert_eq!(decode(bytes, "a.png", 1 << 20).unwrap_err().code, ErrorCode::Unsupported);
        }
        let sound = encode(&picture(), ImageFormat::Png);
        for length in [9, 20, 40, sound.len() / 2] {
            let error = decode(&sound[..length], "a.png", 1 << 20).unwrap_err();
            assert_eq!((error.code, error.file.as_str()), (ErrorCode::Invalid, "a.png"), "{length}");
        }
    }

    #[test]
    fn damaged_images_give_an_image_or_an_error() {
        let formats = [
            ImageFormat::Png,
            ImageFormat::Jpeg,
            ImageFormat::Tga,
            ImageFormat::Tiff,
            ImageFormat::WebP,
            ImageFormat::Gif,
            ImageFormat::Bmp,
            ImageFormat::Pnm,
        ];
        let mut state = 12345_u32;
        let mut random = |n: usize| {
            state = state.wrapping_mul(1664525).wrapping_add(1013904223);
            (state >> 8) as usize % n
        };
        for format in formats {
            let rgb = DynamicImage::from(picture().into_rgb8());
            let sound = encode(&if format == ImageFormat::Jpeg { rgb } else { picture() }, format);
            for _ in 0..400 {
                let mut bytes = sound.clone();
                for _ in 0..1 + random(4) {
                    let at = random(bytes.len());
                    bytes[at] = random(256) as u8;
                }
                bytes.truncate(bytes.len() - random(2) * random(bytes.len()));
                if let Ok(image) = decode(&bytes, "a.tga", 1 << 20) {
                    assert!(image.width > 0 && image.height > 0);
                }
            }
        }
    }

    #[test]
    fn a_refused_allocation_is_known_from_other_panics() {
        let panic =
            |text: String| catch_unwind(move || std::panic::resume_unwind(Box::new(text))).expect_err("a panic");
        // As `image` unwraps it.
        let refused = Vec::<u8>::new().try_reserve_exact(isize::MAX as usize).expect_err("nobody has that");
        assert!(is_refused_allocation(&*panic(format!("input layout: {refused:?}"))), "{refused:?}");
        let overflow = Vec::<u32>::new().try_reserve_exact(usize::MAX).expect_err("more than can be said");
        assert!(!is_refused_allocation(&*panic(format!("{overflow:?}"))), "a file's fault: {overflow:?}");
        assert!(!is_refused_allocation(&*panic("index out of bounds".into())));
        assert!(can_be_had(1 << 16) && !can_be_had(isize::MAX as u64) && !can_be_had(u64::MAX));
    }
}
