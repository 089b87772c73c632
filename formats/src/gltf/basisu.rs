//! KHR_texture_basisu: KTX2 files with Basis Universal data, transcoded to RGBA by the `basisu` crate.

use crate::scene::{Image, Pixels};
use crate::{ErrorCode, ImportError};
use basisu::{DecodeFlags, TargetFormat, Transcoder};
use ktx2::{ColorModel, Reader, SupercompressionScheme};
use std::fmt::Display;
use std::panic::{AssertUnwindSafe, catch_unwind};

/// Texels that need no justification by the size of the data, and how many each byte of them justifies beyond:
/// runs of equal blocks take next to nothing.
const FREE_TEXELS: u64 = 16 << 20;
const TEXELS_PER_BYTE: u64 = 16 << 10;

/// Whether the bytes begin as a KTX2 file does.
pub(super) fn is_ktx2(bytes: &[u8]) -> bool {
    bytes.starts_with(b"\xABKTX 20\xBB\r\n\x1A\n")
}

/// Width times height by the header, 0 where it ends before.
pub(super) fn stated_texels(bytes: &[u8]) -> u64 {
    // Read by hand: the container's parser panics on some headers, and this is all that is needed of it here.
    let word = |at: usize| bytes.get(at..)?.first_chunk().map(|b| u64::from(u32::from_le_bytes(*b)));
    word(20).zip(word(24)).map_or(0, |(width, height)| width.saturating_mul(height))
}

/// A picture's size without its texels.
///
/// # Errors
/// [`ErrorCode::TooLarge`] when that is more than `max_texels`, [`ErrorCode::Invalid`] where the header is cut short; the file is `name`.
pub(super) fn header(bytes: &[u8], name: &str, max_texels: u64) -> Result<Image, ImportError> {
    let word = |at: usize| bytes.get(at..)?.first_chunk().map(|b| u32::from_le_bytes(*b));
    let (width, height) = word(20).zip(word(24)).ok_or_else(|| broken("it is cut short").in_file(name))?;
    let texels = u64::from(width) * u64::from(height);
    if texels == 0 {
        return Err(broken("it has no pixels").in_file(name));
    }
    if texels > max_texels {
        let message = format!("{width}×{height} texels exceed the limit of {max_texels}");
        return Err(ImportError::new(ErrorCode::TooLarge, message).in_file(name));
    }
    Ok(Image { name: name.into(), width, height, pixels: Pixels::Rgba8(Vec::new()) })
}

/// Decodes the largest level of a two-dimensional texture, as stored: the colour space is up to the texture's use.
///
/// # Errors
/// [`ErrorCode::TooLarge`] when the header claims more than `max_texels` or far more than the data can hold (before
/// anything is allocated), [`ErrorCode::Unsupported`] for other kinds of textures, [`ErrorCode::Invalid`] for corrupt
/// data; the file is `name`.
pub(super) fn decode(bytes: &[u8], name: &str, max_texels: u64) -> Result<Image, ImportError> {
    // The crates are young, and ktx2 panics on a block size of 256: should one panic, then the image is at fault as far as the user is concerned.
    catch_unwind(AssertUnwindSafe(|| decode_unguarded(bytes, max_texels)))
        .unwrap_or_else(|_| Err(broken("its decoder panicked")))
        .map(|image| Image { name: name.into(), ..image })
        .map_err(|error| error.in_file(name))
}

fn broken(why: impl Display) -> ImportError {
    ImportError::new(ErrorCode::Invalid, format!("is not a sound KTX2 image: {why}"))
}

fn decode_unguarded(bytes: &[u8], max_texels: u64) -> Result<Image, ImportError> {
    let reader = Reader::new(bytes).map_err(|e| broken(format!("{e:?}")))?;
    let header = reader.header();
    let (width, height) = (header.pixel_width, header.pixel_height);
    let unsupported = |what: &str| ImportError::new(ErrorCode::Unsupported, format!("is a KTX2 file {what}"));
    if !matches!(reader.color_model(), Some(ColorModel::ETC1S | ColorModel::UASTC)) {
        let format = header.format.map_or_else(
            || reader.color_model().map_or_else(|| "an unknown format".to_owned(), |model| format!("{model:?}")),
            |format| format!("{format:?}"),
        );
        return Err(unsupported(&format!(
            "of {format}, not of the data that glTF uses (Basis Universal: ETC1S, UASTC)"
        )));
    }
    if height == 0 || header.pixel_depth > 1 || header.layer_count > 1 || header.face_count != 1 {
        return Err(unsupported("of an array, a cube or another kind that is no two-dimensional texture"));
    }
    let texels = u64::from(width) * u64::from(height);
    if texels == 0 {
        return Err(broken("it has no pixels"));
    }
    let level = reader.levels().next().ok_or_else(|| broken("it has no levels"))?;
    let data = (level.data.len() as u64).saturating_add(reader.supercompression_global_data().len() as u64);
    let backed = FREE_TEXELS.saturating_add(data.saturating_mul(TEXELS_PER_BYTE));
    if texels > max_texels.min(backed) {
        let message = format!("{width}×{height} texels exceed the limit of {}", max_texels.min(backed));
        return Err(ImportError::new(ErrorCode::TooLarge, message));
    }
    // The transcoder takes the uncompressed length at its word: blocks of 4 × 4 texels in 16 bytes.
    let blocks = u64::from(width.div_ceil(4)) * u64::from(height.div_ceil(4));
    let zstd = header.supercompression_scheme == Some(SupercompressionScheme::Zstandard);
    if zstd && level.uncompressed_byte_length > blocks.saturating_mul(16) {
        return Err(broken("its largest level has more data than blocks"));
    }
    let transcoder = Transcoder::new(bytes).map_err(|e| broken(format!("{e:?}")))?;
    if transcoder.base_dimensions() != (width, height) {
        return Err(broken("its sizes contradict each other"));
    }
    let pixels =
        transcoder.transcode(0, TargetFormat::Rgba32, DecodeFlags::NONE).map_err(|e| broken(format!("{e:?}")))?;
    if pixels.len() as u64 != texels * 4 {
        return Err(broken("its level is not complete"));
    }
    Ok(Image { name: String::new(), width, height, pixels: Pixels::Rgba8(pixels) })
}
