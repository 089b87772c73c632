//! Animated WebP files without loss: the frames by `image-webp`, which writes stills, in the container that the format describes
//! (<https://developers.google.com/speed/webp/docs/riff_container>).

use super::{Frame, first};
use image_webp::{ColorType, WebPEncoder};

/// Pixels along a side that the format can say.
const MOST: u32 = 1 << 14;
/// Flags of the file: it is animated, and may have alpha.
const ANIMATED: u8 = 0x02;
const ALPHA: u8 = 0x10;
/// Flag of a frame: it replaces what was there.
const REPLACE: u8 = 0x02;

/// An animation that begins anew at its end, with so many frames a second. The bytes depend on the arguments alone.
///
/// # Errors
/// A sentence: when there are no frames, their sizes differ, or they are too large for the format.
pub fn encode(frames: &[Frame], frames_per_second: u16) -> Result<Vec<u8>, String> {
    let Frame { width, height, .. } = *first(frames)?;
    if width.max(height) > MOST || width.min(height) == 0 {
        return Err(format!("WebP files have at most {MOST} × {MOST} pixels, these frames {width} × {height}"));
    }
    let opaque = frames.iter().all(|f| f.pixels.chunks_exact(4).all(|p| p[3] == u8::MAX));
    let size = [number(width - 1), number(height - 1)].concat();
    let flags = if opaque { ANIMATED } else { ANIMATED | ALPHA };
    let mut file = chunk(b"VP8X", &[&[flags, 0, 0, 0][..], &size].concat());
    // A transparent background, shown over and over.
    file.extend(chunk(b"ANIM", &[0; 6]));
    let rate = u32::from(frames_per_second.max(1));
    // Milliseconds from the beginning, so that what is rounded off a frame is not lost.
    let begin = |frame: usize| (frame as u32 * 1000 + rate / 2) / rate;
    for (index, frame) in frames.iter().enumerate() {
        let duration = number((begin(index + 1) - begin(index)).max(1));
        let head = [&[0; 6][..], &size, &duration, &[REPLACE]].concat();
        file.extend(chunk(b"ANMF", &[head, picture(frame, opaque)?].concat()));
    }
    Ok(chunk(b"RIFF", &[&b"WEBP"[..], &file].concat()))
}

/// The chunk of a still's pixels.
fn picture(frame: &Frame, opaque: bool) -> Result<Vec<u8>, String> {
    let (color, pixels): (_, Vec<u8>) = if opaque {
        (ColorType::Rgb8, frame.pixels.chunks_exact(4).flat_map(|p| [p[0], p[1], p[2]]).collect())
    } else {
        (ColorType::Rgba8, frame.pixels.clone())
    };
    let mut file = Vec::new();
    WebPEncoder::new(&mut file).encode(&pixels, frame.width, frame.height, color).map_err(|e| e.to_string())?;
    // "RIFF", length, "WEBP", and then the one chunk of a still without metadata.
    let chunk = file.get(12..).filter(|chunk| chunk.starts_with(b"VP8L"));
    chunk.map(<[u8]>::to_vec).ok_or_else(|| "the encoder gave no plain WebP file".into())
}

/// A chunk of a RIFF file: its name, its length, what it holds, and a byte to make it even.
fn chunk(name: &[u8; 4], content: &[u8]) -> Vec<u8> {
    let length = (content.len() as u32).to_le_bytes();
    let padding: &[u8] = if content.len().is_multiple_of(2) { &[] } else { &[0] };
    [&name[..], &length, content, padding].concat()
}

/// A number of 24 bits.
fn number(value: u32) -> [u8; 3] {
    let [low, middle, high, _] = value.to_le_bytes();
    [low, middle, high]
}

#[cfg(test)]
mod tests {
    use super::super::tests::frame;
    use super::*;
    use image_webp::{LoopCount, WebPDecoder};
    use std::io::Cursor;

    #[test]
    fn every_frame_is_read_back() {
        let transparent: Vec<Frame> = (0..5).map(|k| frame(k * 50)).collect();
        let solid = |frame: &Frame| Frame {
            pixels: frame.pixels.chunks_exact(4).flat_map(|p| [p[0], p[1], p[2], 255]).collect(),
            ..*frame
        };
        for (frames, alpha) in [(transparent.iter().map(solid).collect(), false), (transparent.clone(), true)] {
            let frames: Vec<Frame> = frames;
            let bytes = encode(&frames, 12).expect("small");
            assert_eq!(bytes, encode(&frames, 12).expect("again"));
            let mut decoder = WebPDecoder::new(Cursor::new(&bytes)).expect("our own file");
            assert_eq!((decoder.dimensions(), decoder.num_frames(), decoder.has_alpha()), ((3, 2), 5, alpha));
            assert_eq!((decoder.is_animated(), decoder.loop_count()), (true, LoopCount::Forever));
            let mut durations = 0;
            for frame in &frames {
                let mut data = vec![0; decoder.output_buffer_size().expect("small")];
                durations += decoder.read_frame(&mut data).expect("a frame");
                let pixels = frame.pixels.chunks_exact(4).flat_map(|p| &p[..if alpha { 4 } else { 3 }]);
                assert!(data.iter().eq(pixels));
            }
            assert_eq!(durations, 417, "five frames of a twelfth of a second");
        }
    }

    #[test]
    fn frames_that_are_too_large_are_named() {
        let wide = Frame { width: MOST + 1, height: 1, pixels: vec![0; 4 * (MOST as usize + 1)] };
        assert!(encode(&[wide], 12).expect_err("wide").contains("16385"));
    }
}
