//! The commonest images, read to RGBA without an RGB image in between: the same decoders and the same values as through the `image` crate, with
//! less memory to be touched.

use png::{BitDepth, ColorType, Transformations};
use std::io::Cursor;
use zune_jpeg::JpegDecoder;
use zune_jpeg::zune_core::bytestream::ZCursor;
use zune_jpeg::zune_core::colorspace::ColorSpace;
use zune_jpeg::zune_core::options::DecoderOptions;

/// RGBA of a JPEG file in colours or of an 8-bit RGB PNG file without interlacing, of that many texels. `None` for others, and for broken ones: why
/// they are, the general way tells.
pub(crate) fn rgba(bytes: &[u8], texels: u64) -> Option<Vec<u8>> {
    match bytes {
        [0xff, 0xd8, ..] => jpeg(bytes, texels),
        [0x89, b'P', b'N', b'G', ..] => png(bytes, texels),
        _ => None,
    }
}

fn size(texels: u64) -> Option<usize> {
    usize::try_from(texels).ok()?.checked_mul(4)
}

fn jpeg(bytes: &[u8], texels: u64) -> Option<Vec<u8>> {
    let options = DecoderOptions::default()
        .set_strict_mode(false)
        .set_max_width(usize::MAX)
        .set_max_height(usize::MAX)
        .jpeg_set_out_colorspace(ColorSpace::RGBA);
    let mut decoder = JpegDecoder::new_with_options(ZCursor::new(bytes), options);
    decoder.decode_headers().ok()?;
    if decoder.input_colorspace()? != ColorSpace::YCbCr || decoder.output_buffer_size() != size(texels) {
        return None;
    }
    let mut rgba = vec![0; size(texels)?];
    decoder.decode_into(&mut rgba).ok()?;
    // Where a file was cut short the decoder fills all channels alike.
    rgba.iter_mut().skip(3).step_by(4).for_each(|alpha| *alpha = u8::MAX);
    Some(rgba)
}

fn png(bytes: &[u8], texels: u64) -> Option<Vec<u8>> {
    let mut decoder = png::Decoder::new(Cursor::new(bytes));
    decoder.set_transformations(Transformations::IDENTITY);
    decoder.set_ignore_text_chunk(true);
    let mut reader = decoder.read_info().ok()?;
    let info = reader.info();
    let plain = info.color_type == ColorType::Rgb && info.bit_depth == BitDepth::Eight && info.trns.is_none();
    if !plain
        || info.interlaced
        || info.animation_control.is_some()
        || u64::from(info.width) * u64::from(info.height) != texels
    {
        return None;
    }
    let (mut row, mut rgba) = (vec![0; 3 * info.width as usize], vec![0; size(texels)?]);
    for out in rgba.chunks_exact_mut(4 * info.width as usize) {
        reader.read_row(&mut row).ok()??;
        spread(&row, out);
    }
    // What follows the last row belongs to its check sum.
    if reader.read_row(&mut row).ok()?.is_some() {
        return None;
    }
    Some(rgba)
}

/// RGBA of RGB, opaque.
pub(crate) fn spread(rgb: &[u8], rgba: &mut [u8]) {
    for (to, [r, g, b]) in rgba.as_chunks_mut().0.iter_mut().zip(rgb.as_chunks().0) {
        *to = [*r, *g, *b, u8::MAX];
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use image::{DynamicImage, ImageFormat, Rgb, RgbImage};

    fn picture() -> RgbImage {
        RgbImage::from_fn(37, 21, |x, y| Rgb([(x * 7) as u8, (y * 12) as u8, (x * y % 251) as u8]))
    }

    #[test]
    fn the_values_are_those_of_the_general_way() {
        for format in [ImageFormat::Png, ImageFormat::Bmp] {
            let mut file = Cursor::new(Vec::new());
            picture().write_to(&mut file, format).unwrap();
            let straight = rgba(file.get_ref(), 37 * 21);
            assert_eq!(straight.is_some(), format == ImageFormat::Png);
            if let Some(straight) = straight {
                assert_eq!(straight, DynamicImage::from(picture()).into_rgba8().into_raw());
                assert!(rgba(file.get_ref(), 37 * 22).is_none(), "another size than the header's");
                assert!(rgba(&file.get_ref()[..file.get_ref().len() / 2], 37 * 21).is_none(), "cut short");
            }
        }
        for (name, colors) in [("baseline", true), ("progressive", true), ("grey", false)] {
            let file = std::fs::read(format!("{}/tests/images/{name}.jpg", env!("CARGO_MANIFEST_DIR"))).unwrap();
            let image = image::load_from_memory(&file).unwrap().into_rgba8();
            let straight = rgba(&file, u64::from(image.width() * image.height()));
            assert_eq!(straight.is_some(), colors, "{name}");
            assert!(straight.is_none_or(|straight| straight == image.into_raw()), "{name}");
        }
        let whole = std::fs::read(format!("{}/tests/images/baseline.jpg", env!("CARGO_MANIFEST_DIR"))).unwrap();
        let mut compared = 0;
        for missing in 1..whole.len() {
            let cut = &whole[..whole.len() - missing];
            let Ok(image) = image::load_from_memory(cut) else { continue };
            let image = image.into_rgba8();
            let straight = rgba(cut, u64::from(image.width() * image.height()));
            assert!(straight.is_none_or(|straight| straight == image.into_raw()), "without the last {missing} bytes");
            compared += 1;
        }
        assert!(compared > 10, "cut files are shown as far as they go: {compared}");
    }
}
