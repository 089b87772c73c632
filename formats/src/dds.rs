//! DDS files, as games and their tools write them, by the `image_dds` crate.

use crate::scene::{Image, Pixels};
use crate::{ErrorCode, ImportError};
use image_dds::ddsfile::Dds;
use image_dds::{ImageFormat, Surface, SurfaceRgba8, SurfaceRgba32Float, dds_image_format};

/// Whether the bytes begin as a DDS file does.
pub(crate) fn is_dds(bytes: &[u8]) -> bool {
    bytes.starts_with(b"DDS ")
}

/// Width and height by the header, where it is whole.
pub(crate) fn dimensions(bytes: &[u8]) -> Option<(u32, u32)> {
    let word = |at: usize| bytes.get(at..)?.first_chunk().map(|b| u32::from_le_bytes(*b));
    Some((word(16)?, word(12)?))
}

/// Whether the texels are floats, as far as the header can be understood.
pub(crate) fn has_floats(bytes: &[u8]) -> bool {
    Dds::read(bytes).is_ok_and(|dds| dds_image_format(&dds).is_ok_and(is_float))
}

/// Decodes the first and largest picture of a file, as stored. Normal maps of two channels (BC5) get their third.
///
/// # Errors
/// [`ErrorCode::TooLarge`] when the header claims more than `max_texels`, [`ErrorCode::Unsupported`] for formats that the decoder
/// does not know, [`ErrorCode::Invalid`] for corrupt data, and for less of it than the header claims.
pub(crate) fn decode(bytes: &[u8], name: &str, max_texels: u64) -> Result<Image, ImportError> {
    let error = |code, message: String| ImportError::new(code, message).in_file(name);
    let broken = |why: &dyn std::fmt::Display| error(ErrorCode::Invalid, format!("is not a sound DDS image: {why}"));
    let dds = Dds::read(bytes).map_err(|e| broken(&e))?;
    let (width, height) = (dds.get_width(), dds.get_height());
    if u64::from(width) * u64::from(height) > max_texels {
        let message = format!("{width}×{height} texels exceed the limit of {max_texels}");
        return Err(error(ErrorCode::TooLarge, message));
    }
    let image_format = dds_image_format(&dds).map_err(|info| {
        error(ErrorCode::Unsupported, format!("DDS image of a format that Kiln does not read: {info:?}"))
    })?;
    // The first of its pictures: not its smaller versions, nor other sides of a cube.
    let surface = Surface { width, height, depth: 1, layers: 1, mipmaps: 1, image_format, data: dds.data.as_slice() };
    let pixels = if is_float(image_format) {
        let SurfaceRgba32Float { mut data, .. } =
            surface.decode_layers_mipmaps_rgbaf32(0..1, 0..1).map_err(|e| broken(&e))?;
        data.iter_mut().filter(|x| !x.is_finite()).for_each(|x| *x = 0.0);
        Pixels::RgbaF32(data)
    } else {
        let SurfaceRgba8 { mut data, .. } = surface.decode_layers_mipmaps_rgba8(0..1, 0..1).map_err(|e| broken(&e))?;
        if matches!(image_format, ImageFormat::BC5RgUnorm | ImageFormat::BC5RgSnorm) {
            data.as_chunks_mut().0.iter_mut().for_each(|[r, g, b, _]| *b = third(*r, *g));
        }
        Pixels::Rgba8(data)
    };
    Ok(Image { name: name.into(), width, height, pixels })
}

/// What belongs beside x and y in a map of unit normals.
fn third(x: u8, y: u8) -> u8 {
    let signed = |v: u8| f32::from(v) / 127.5 - 1.0;
    let (x, y) = (signed(x), signed(y));
    let z = (1.0 - x * x - y * y).max(0.0).sqrt();
    (z * 127.5 + 128.0) as u8
}

fn is_float(format: ImageFormat) -> bool {
    use ImageFormat::*;
    matches!(
        format,
        BC6hRgbUfloat
            | BC6hRgbSfloat
            | R16Float
            | Rg16Float
            | Rgba16Float
            | R32Float
            | Rg32Float
            | Rgb32Float
            | Rgba32Float
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A DDS file of 4 × 4 texels in one block.
    fn dds(fourcc: &[u8; 4], block: &[u8]) -> Vec<u8> {
        let mut words = [0u32; 31];
        words[0..5].copy_from_slice(&[124, 0x8_1007, 4, 4, block.len() as u32]);
        words[18..21].copy_from_slice(&[32, 4, u32::from_le_bytes(*fourcc)]);
        words[26] = 0x1000;
        let head = b"DDS ".iter().copied().chain(words.into_iter().flat_map(u32::to_le_bytes));
        head.chain(block.iter().copied()).collect()
    }

    #[test]
    fn blocks_become_texels() {
        // Two colours, 5-6-5 red and blue; the first row takes the first, the others the second.
        let file = dds(b"DXT1", &[0x00, 0xf8, 0x1f, 0x00, 0x00, 0x55, 0x55, 0x55]);
        assert!(is_dds(&file));
        assert_eq!(dimensions(&file), Some((4, 4)));
        let image = decode(&file, "a.dds", 16).unwrap();
        let Pixels::Rgba8(texels) = image.pixels else { panic!() };
        assert_eq!((image.width, image.height, texels.len()), (4, 4, 64));
        assert_eq!((&texels[..4], &texels[16..20]), (&[255, 0, 0, 255][..], &[0, 0, 255, 255][..]));
    }

    #[test]
    fn floats_are_known_by_the_header() {
        let mut halves = dds(b"DX10", &[0; 16]);
        // DXGI_FORMAT_BC6H_UF16, a texture of two dimensions.
        let more = [95, 3, 0, 1, 0].map(u32::to_le_bytes).concat();
        halves.splice(128..128, more);
        let image = decode(&halves, "a.dds", 16).unwrap();
        assert!(matches!(image.pixels, Pixels::RgbaF32(_)) && has_floats(&halves));
        assert!(!has_floats(&dds(b"DXT1", &[0; 8])) && !has_floats(b"DDS "));
    }

    #[test]
    fn normals_of_two_channels_get_their_third() {
        // x and y in the middle everywhere: straight up.
        let file = dds(b"ATI2", &[128, 128, 0, 0, 0, 0, 0, 0, 128, 128, 0, 0, 0, 0, 0, 0]);
        let Pixels::Rgba8(texels) = decode(&file, "a.dds", 16).unwrap().pixels else { panic!() };
        assert_eq!(texels[..3], [128, 128, 255]);
    }

    #[test]
    fn what_is_no_picture_says_why() {
        let file = dds(b"DXT1", &[0; 8]);
        assert_eq!(decode(&file, "a.dds", 15).unwrap_err().code, ErrorCode::TooLarge);
        assert_eq!(decode(&file[..130], "a.dds", 16).unwrap_err().code, ErrorCode::Invalid);
        assert_eq!(decode(&file[..40], "a.dds", 16).unwrap_err().code, ErrorCode::Invalid);
        let mut boasts = file;
        boasts[12..20].copy_from_slice(&[0, 0, 1, 0, 0, 0, 1, 0]);
        assert_eq!(decode(&boasts, "a.dds", u64::MAX).unwrap_err().code, ErrorCode::Invalid);
        assert_eq!(decode(&dds(b"WHAT", &[0; 8]), "a.dds", 16).unwrap_err().code, ErrorCode::Unsupported);
    }
}
