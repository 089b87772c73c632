//! Animated PNG files, which viewers that know nothing of animations show as their first frame.

use super::{Frame, first};

/// An animation that begins anew at its end, with so many frames a second. The bytes depend on the arguments alone.
///
/// # Errors
/// A sentence: when there are no frames, their sizes differ, or one is too large for the format.
pub fn encode(frames: &[Frame], frames_per_second: u16) -> Result<Vec<u8>, String> {
    let first = first(frames)?;
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
    use super::super::tests::frame;
    use super::*;
    use std::io::Cursor;

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
}
