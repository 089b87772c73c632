//! Pictures that follow each other: animated PNG and WebP, and MP4 by ffmpeg.

mod apng;
mod ffmpeg;
mod webp;

pub use ffmpeg::{Ffmpeg, encode as encode_mp4};
use std::io::Cursor;
pub use {apng::encode as encode_apng, webp::encode as encode_webp};

/// A frame: 8-bit sRGB with straight alpha, row by row from the top.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Frame {
    /// Width in pixels.
    pub width: u32,
    /// Height in pixels.
    pub height: u32,
    /// Four bytes a pixel.
    pub pixels: Vec<u8>,
}

impl Frame {
    /// Reads a PNG file of any kind; of an animated one the first frame.
    ///
    /// # Errors
    /// A sentence, when it is no sound PNG file or has more than `max_pixels`.
    pub fn of_png(bytes: &[u8], max_pixels: u64) -> Result<Self, String> {
        let unsound = |e: png::DecodingError| format!("is not a sound PNG file: {e}");
        let mut decoder = png::Decoder::new(Cursor::new(bytes));
        decoder.set_transformations(png::Transformations::normalize_to_color8() | png::Transformations::ALPHA);
        let mut reader = decoder.read_info().map_err(unsound)?;
        let (width, height) = (reader.info().width, reader.info().height);
        if u64::from(width) * u64::from(height) > max_pixels {
            return Err(format!("has {width} × {height} pixels, more than the limit of {max_pixels}"));
        }
        let mut data = vec![0; reader.output_buffer_size().ok_or("is too large")?];
        reader.next_frame(&mut data).map_err(unsound)?;
        let pixels = match reader.output_color_type().0 {
            png::ColorType::Rgba => data,
            png::ColorType::GrayscaleAlpha => data.chunks_exact(2).flat_map(|p| [p[0], p[0], p[0], p[1]]).collect(),
            other => return Err(format!("has pixels of an unexpected kind: {other:?}")),
        };
        Ok(Self { width, height, pixels })
    }
}

/// The first of frames that make an animation.
fn first(frames: &[Frame]) -> Result<&Frame, String> {
    let first = frames.first().ok_or("there are no frames")?;
    let size = |frame: &Frame| (frame.width, frame.height, frame.pixels.len());
    if let Some(other) = frames.iter().find(|f| size(f) != size(first)) {
        let (w, h) = (first.width, first.height);
        return Err(format!("frames differ in size: {w} × {h} and {} × {}", other.width, other.height));
    }
    Ok(first)
}

#[cfg(test)]
mod tests {
    use super::*;

    pub fn frame(value: u8) -> Frame {
        Frame { width: 3, height: 2, pixels: (0..24).map(|k| value.wrapping_add(k * 10)).collect() }
    }

    #[test]
    fn what_cannot_be_animated_is_named() {
        let other = Frame { width: 2, height: 3, ..frame(0) };
        for encode in [encode_apng, encode_webp] {
            assert!(encode(&[], 12).is_err());
            assert!(encode(&[frame(0), other.clone()], 12).expect_err("sizes").contains("2 × 3"));
        }
        let bytes = encode_apng(&[frame(0)], 12).expect("small");
        assert!(Frame::of_png(&bytes, 5).expect_err("limit").contains("limit"));
        assert!(Frame::of_png(&bytes[..40], 6).is_err());
    }
}
