//! Animated PNG files, which viewers that know nothing of animations show as their first frame.

use std::io::Cursor;

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

/// An animation that begins anew at its end, with so many frames a second. The bytes depend on the arguments alone.
///
/// # Errors
/// A sentence: when there are no frames, their sizes differ, or one is too large for the format.
pub fn encode(frames: &[Frame], frames_per_second: u16) -> Result<Vec<u8>, String> {
    let Some(first) = frames.first() else { return Err("there are no frames".into()) };
    let size = |frame: &Frame| (frame.width, frame.height, frame.pixels.len());
    if let Some(other) = frames.iter().find(|f| size(f) != size(first)) {
        let (w, h) = (first.width, first.height);
        return Err(format!("frames differ in size: {w} × {h} and {} × {}", other.width, other.height));
    }
    let error = |e: png::EncodingError| e.to_string();
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, first.width, first.height);
    encoder.set_color(png::ColorType::Rgba);
    encoder.set_source_srgb(png::SrgbRenderingIntent::Perceptual);
    let count = u32::try_from(frames.len()).map_err(|_| "there are too many frames")?;
    // Zero plays are endlessly many.
    encoder.set_animated(count, 0).map_err(error)?;
    encoder.set_frame_delay(1, frames_per_second.max(1)).map_err(error)?;
    let mut writer = encoder.write_header().map_err(error)?;
    for frame in frames {
        writer.write_image_data(&frame.pixels).map_err(error)?;
    }
    writer.finish().map_err(error)?;
    Ok(bytes)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn frame(value: u8) -> Frame {
        Frame { width: 3, height: 2, pixels: (0..24).map(|k| value.wrapping_add(k * 10)).collect() }
    }

    #[test]
    fn every_frame_is_read_back() {
        let frames: Vec<Frame> = (0..5).map(|k| frame(k * 50)).collect();
        let bytes = encode(&frames, 12).expect("small");
        assert_eq!(bytes, encode(&frames, 12).expect("again"));
        assert_eq!(Frame::of_png(&bytes, 6), Ok(frames[0].clone()), "viewers without animations show the first");
        let mut reader = png::Decoder::new(Cursor::new(&bytes)).read_info().expect("our own file");
        let animation = *reader.info().animation_control().expect("animated");
        assert_eq!((animation.num_frames, animation.num_plays), (5, 0));
        for frame in &frames {
            let mut data = vec![0; 24];
            reader.next_frame(&mut data).expect("a frame");
            let control = reader.info().frame_control().expect("its control");
            assert_eq!((control.delay_num, control.delay_den), (1, 12));
            assert_eq!(data, frame.pixels);
        }
    }

    #[test]
    fn what_cannot_be_animated_is_named() {
        assert!(encode(&[], 12).is_err());
        let other = Frame { width: 2, height: 3, ..frame(0) };
        assert!(encode(&[frame(0), other], 12).expect_err("sizes").contains("2 × 3"));
        let bytes = encode(&[frame(0)], 12).expect("small");
        assert!(Frame::of_png(&bytes, 5).expect_err("limit").contains("limit"));
        assert!(Frame::of_png(&bytes[..40], 6).is_err());
    }
}
