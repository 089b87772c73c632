//! PNG files: 8 or 16 bit sRGB with straight alpha, an sRGB chunk and text metadata.

use super::display::DisplayPicture;
use super::{Metadata, srgb};
use crate::settings::BitDepth;

/// Encodes a picture. The bytes depend on the arguments alone.
///
/// # Errors
/// When the picture is too large for the format (2³¹ − 1 pixels a side) or metadata cannot be told in a text chunk.
pub fn encode(picture: &DisplayPicture, bits: BitDepth, metadata: &Metadata) -> Result<Vec<u8>, png::EncodingError> {
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, picture.width, picture.height);
    encoder.set_color(if picture.opaque { png::ColorType::Rgb } else { png::ColorType::Rgba });
    encoder.set_depth(match bits {
        BitDepth::Eight => png::BitDepth::Eight,
        BitDepth::Sixteen => png::BitDepth::Sixteen,
    });
    encoder.set_source_srgb(png::SrgbRenderingIntent::Perceptual);
    for (keyword, text) in metadata.entries() {
        if !text.is_empty() {
            encoder.add_itxt_chunk(keyword.into(), text)?;
        }
    }
    let mut writer = encoder.write_header()?;
    writer.write_image_data(&samples(picture, bits))?;
    writer.finish()?;
    Ok(bytes)
}

/// Encodes 8-bit sRGB pixels, row by row from the top, without any metadata: plots and maps.
///
/// # Errors
/// When the picture is too large for the format or the pixels are not `width` times a whole number.
pub fn encode_rgb8(width: u32, pixels: &[[u8; 3]]) -> Result<Vec<u8>, png::EncodingError> {
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, width, (pixels.len() / width.max(1) as usize) as u32);
    encoder.set_color(png::ColorType::Rgb);
    encoder.set_source_srgb(png::SrgbRenderingIntent::Perceptual);
    let mut writer = encoder.write_header()?;
    writer.write_image_data(pixels.as_flattened())?;
    writer.finish()?;
    Ok(bytes)
}

/// Quantised samples, 16-bit ones with the high byte first.
fn samples(picture: &DisplayPicture, bits: BitDepth) -> Vec<u8> {
    let channels = if picture.opaque { 3 } else { 4 };
    let values = picture.pixels.iter().flat_map(|pixel| &pixel[..channels]);
    match bits {
        BitDepth::Eight => values.map(|v| srgb::quantise(*v, 255.0) as u8).collect(),
        BitDepth::Sixteen => values.flat_map(|v| srgb::quantise(*v, 65535.0).to_be_bytes()).collect(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn metadata() -> Metadata {
        Metadata {
            software: "kiln test".into(),
            source: "chaise longue é 椅子.glb".into(),
            content: "blake3:00".into(),
            settings: "blake3:11".into(),
            seed: 7,
            spp: 64,
            view: 0,
            stated: None,
            denoised: None,
        }
    }

    fn picture(opaque: bool) -> DisplayPicture {
        let pixels = (0..6).map(|i| i as f32 / 5.0).map(|v| [v, 1.0 - v, 0.5, if opaque { 1.0 } else { v }]).collect();
        DisplayPicture { width: 3, height: 2, opaque, pixels }
    }

    #[test]
    fn what_is_written_is_read_back() {
        for bits in [BitDepth::Eight, BitDepth::Sixteen] {
            for opaque in [false, true] {
                let bytes = encode(&picture(opaque), bits, &metadata()).expect("a small picture");
                let mut reader = png::Decoder::new(std::io::Cursor::new(&bytes)).read_info().expect("our own file");
                let mut samples = vec![0; reader.output_buffer_size().expect("small")];
                reader.next_frame(&mut samples).expect("whole");
                let info = reader.info();
                assert_eq!((info.width, info.height), (3, 2));
                assert_eq!(info.srgb, Some(png::SrgbRenderingIntent::Perceptual));
                assert_eq!(info.color_type, if opaque { png::ColorType::Rgb } else { png::ColorType::Rgba });
                assert_eq!(samples, super::samples(&picture(opaque), bits));
                let texts: Vec<_> = info.utf8_text.iter().map(|t| (t.keyword.as_str(), t.get_text())).collect();
                assert!(
                    texts.iter().any(|(k, t)| *k == "Source" && t.as_deref().is_ok_and(|t| t == metadata().source))
                );
                assert!(texts.iter().any(|(k, t)| *k == "kiln:spp" && t.as_deref().is_ok_and(|t| t == "64")));
                assert_eq!(bytes, encode(&picture(opaque), bits, &metadata()).expect("again"), "same bytes again");
            }
        }
    }

    #[test]
    fn the_srgb_chunk_comes_before_the_pixels() {
        let bytes = encode(&picture(false), BitDepth::Eight, &metadata()).expect("a small picture");
        let find = |name: &[u8]| bytes.windows(4).position(|w| w == name);
        assert!(find(b"sRGB").expect("sRGB") < find(b"IDAT").expect("IDAT"));
        assert!(find(b"tIME").is_none(), "a time would vary from run to run");
    }
}
