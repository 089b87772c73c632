//! MP4 files (H.264) by ffmpeg, a program of its own that many people have.

use super::{Frame, first};
use std::io::Write;
use std::path::PathBuf;
use std::process::{Command, Stdio};

/// The program that makes the films.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Ffmpeg {
    program: PathBuf,
}

impl Ffmpeg {
    /// `ffmpeg` of the system's path.
    ///
    /// # Errors
    /// A sentence, when it is not there or does not run.
    pub fn find() -> Result<Self, String> {
        Self::at("ffmpeg".into())
    }

    fn at(program: PathBuf) -> Result<Self, String> {
        let asked = Command::new(&program).arg("-version").stdin(Stdio::null()).output();
        match asked {
            Ok(output) if output.status.success() => Ok(Self { program }),
            Ok(output) => Err(format!("{} does not run: {}", program.display(), output.status)),
            Err(error) => Err(format!(
                "MP4 files are made by ffmpeg, which is not there ({}: {error}); .apng and .webp files need nothing",
                program.display()
            )),
        }
    }
}

/// A film of these frames, so many a second, over a background (sRGB), for MP4 has no transparency. Sides are even: an odd one
/// grows by a line of background. The film ends where a turntable would begin anew: players repeat it if they are told to.
///
/// # Errors
/// A sentence: when there are no frames, their sizes differ, or ffmpeg fails, with what it says.
pub fn encode(
    ffmpeg: &Ffmpeg,
    frames: &[Frame],
    frames_per_second: u16,
    background: [u8; 3],
) -> Result<Vec<u8>, String> {
    let Frame { width, height, .. } = *first(frames)?;
    let (width, height) = (width.next_multiple_of(2), height.next_multiple_of(2));
    // A film's index comes first only in files in which ffmpeg can go back.
    let folder = tempfile::tempdir().map_err(|e| format!("no temporary folder: {e}"))?;
    let film = folder.path().join("film.mp4");
    let mut command = Command::new(&ffmpeg.program);
    command.args(["-nostdin", "-loglevel", "error", "-f", "rawvideo", "-pixel_format", "rgb24"]);
    command.args(["-video_size", &format!("{width}x{height}"), "-framerate", &frames_per_second.to_string()]);
    command.args(["-i", "pipe:0", "-vf", "scale=out_color_matrix=bt709:out_range=tv,format=yuv420p"]);
    command.args(["-c:v", "libx264", "-preset", "slow", "-crf", "18", "-movflags", "+faststart"]);
    command.args(["-color_primaries", "bt709", "-color_trc", "iec61966-2-1", "-colorspace", "bt709"]);
    // Neither dates nor versions, and the same bytes on any number of cores.
    command.args(["-map_metadata", "-1", "-fflags", "+bitexact", "-flags:v", "+bitexact", "-threads", "1"]);
    let spawned = command.arg(&film).stdin(Stdio::piped()).stdout(Stdio::null()).stderr(Stdio::piped()).spawn();
    let mut child = spawned.map_err(|e| format!("ffmpeg cannot be started: {e}"))?;
    let input = child.stdin.take();
    let output = std::thread::scope(|scope| {
        scope.spawn(move || {
            let Some(mut input) = input else { return };
            for frame in frames {
                // When ffmpeg has gone, it has said why.
                if input.write_all(&solid(frame, width, height, background)).is_err() {
                    break;
                }
            }
        });
        child.wait_with_output()
    });
    let output = output.map_err(|e| format!("ffmpeg: {e}"))?;
    if !output.status.success() {
        let said = String::from_utf8_lossy(&output.stderr);
        let said = said.trim().lines().next_back().unwrap_or("it says nothing");
        return Err(format!("ffmpeg failed ({}): {said}", output.status));
    }
    std::fs::read(&film).map_err(|e| format!("ffmpeg made no film: {e}"))
}

/// A frame over a background, mixed as browsers mix it, in a size that is at least its own: three bytes a pixel.
fn solid(frame: &Frame, width: u32, height: u32, background: [u8; 3]) -> Vec<u8> {
    let mut pixels = background.repeat(width as usize * height as usize);
    let rows = frame.pixels.chunks_exact(4 * frame.width.max(1) as usize);
    for (row, target) in rows.zip(pixels.chunks_exact_mut(3 * width.max(1) as usize)) {
        for (p, target) in row.chunks_exact(4).zip(target.chunks_exact_mut(3)) {
            let alpha = u32::from(p[3]);
            for (c, value) in target.iter_mut().enumerate() {
                let mixed = u32::from(p[c]) * alpha + u32::from(background[c]) * (255 - alpha);
                *value = ((mixed + 127) / 255) as u8;
            }
        }
    }
    pixels
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn frames_lie_on_the_background() {
        let frame = Frame { width: 1, height: 1, pixels: vec![200, 100, 0, 51] };
        let (white, over) = ([255; 3], [244, 224, 204]);
        assert_eq!(solid(&frame, 2, 2, white), [&over[..], &white, &white, &white].concat());
    }

    #[test]
    fn a_program_that_is_not_there_is_named() {
        let message = Ffmpeg::at("/there/is/no/ffmpeg".into()).expect_err("missing");
        assert!(message.contains("/there/is/no/ffmpeg") && message.contains(".webp"), "{message}");
    }

    #[test]
    fn films_have_all_frames_and_nearly_their_colours() {
        let Ok(ffmpeg) = Ffmpeg::find() else {
            assert!(std::env::var_os("KILN_REQUIRE_FFMPEG").is_none(), "ffmpeg is not there");
            eprintln!("skipped: ffmpeg is not there");
            return;
        };
        // An odd width, and colours that a wrong matrix would turn.
        let frame = |k: u8| Frame { width: 31, height: 32, pixels: [40 * k, 200, 90, 255].repeat(31 * 32) };
        let frames: Vec<Frame> = (0..6).map(frame).collect();
        let film = encode(&ffmpeg, &frames, 12, [255; 3]).expect("a film");
        assert!(film == encode(&ffmpeg, &frames, 12, [255; 3]).expect("again"));
        let folder = tempfile::tempdir().expect("temporary folder");
        let path = folder.path().join("film.mp4");
        std::fs::write(&path, film).expect("write");
        let read = Command::new("ffmpeg")
            .args(["-loglevel", "error", "-i"])
            .arg(&path)
            .args(["-f", "rawvideo", "-pix_fmt", "rgb24", "-"])
            .output()
            .expect("runs");
        assert_eq!(read.stdout.len(), 6 * 32 * 32 * 3, "{}", String::from_utf8_lossy(&read.stderr));
        for (k, picture) in read.stdout.chunks_exact(32 * 32 * 3).enumerate() {
            let pixel = &picture[3 * (16 * 32 + 8)..][..3];
            let want = &frames[k].pixels[..3];
            assert!(pixel.iter().zip(want).all(|(a, b)| a.abs_diff(*b) <= 4), "{k}: {pixel:?} {want:?}");
        }
    }
}
