use super::record::{self, Record};
use crate::write::animation::{Ffmpeg, Frame, encode_apng, encode_mp4, encode_webp};
use crate::write::atomic;
use rayon::prelude::*;
use std::io;
use std::path::{Path, PathBuf};

/// Pixels of a frame that is read, at most.
const MOST_PIXELS: u64 = 1 << 28;

/// A file format of animations.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, clap::ValueEnum)]
pub enum AnimationFormat {
    /// Animated PNG.
    Apng,
    /// Animated WebP, without loss: a little smaller.
    Webp,
    /// H.264 by ffmpeg, over a background.
    Mp4,
}

impl AnimationFormat {
    /// The file ending, without the dot.
    pub fn ending(self) -> &'static str {
        match self {
            Self::Apng => "apng",
            Self::Webp => "webp",
            Self::Mp4 => "mp4",
        }
    }
}

/// How turntables become animations.
#[derive(Clone, Debug)]
pub struct Animation {
    /// The files made of each.
    pub formats: Vec<AnimationFormat>,
    /// Frames a second, ≥ 1.
    pub frames_per_second: u16,
    /// sRGB; what is behind transparent pixels in formats that have none.
    pub background: [u8; 3],
}

/// A turntable that became an animation, or did not.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Animated {
    /// The asset, as the manifest calls it.
    pub input: String,
    /// The animation's path below the folder, or a sentence with why there is none.
    pub result: Result<PathBuf, String>,
}

/// Makes animations of every turntable of a batch's folder, from its PNG files: `chairs/oak.glb.apng` of `chairs/oak.glb.000.png`
/// and so on. On the current rayon pool, several at a time; in the manifest's order.
///
/// # Errors
/// When the manifest cannot be read, with its path; when there is no ffmpeg and it is needed.
pub fn animate(folder: &Path, animation: &Animation) -> io::Result<Vec<Animated>> {
    let ffmpeg = animation.formats.contains(&AnimationFormat::Mp4).then(Ffmpeg::find);
    let ffmpeg = ffmpeg.transpose().map_err(|message| io::Error::new(io::ErrorKind::NotFound, message))?;
    let turntables = record::read(folder)?.into_iter().map(|record| {
        let frames = frames(&record);
        (record, frames)
    });
    let turntables: Vec<_> = turntables.filter(|(_, frames)| frames.len() > 1).collect();
    let animated = |(record, frames): &(Record, Vec<String>)| -> Vec<Animated> {
        let all = read(folder, frames);
        let one = |format: &AnimationFormat| {
            let pictures = all.as_ref().map_err(Clone::clone)?;
            write(folder, frames, pictures, *format, animation, ffmpeg.as_ref())
        };
        animation.formats.iter().map(|format| Animated { input: record.input.clone(), result: one(format) }).collect()
    };
    Ok(turntables.par_iter().flat_map_iter(animated).collect())
}

/// The PNG files of a record that are frames of a turntable: numbered from 000.
fn frames(record: &Record) -> Vec<String> {
    let mut outputs: Vec<_> = record.outputs.iter().filter(|o| o.is_rendered("png")).collect();
    outputs.sort_by_key(|o| o.view);
    let is_frame = |(index, path): (usize, &str)| stem(path, index).is_some();
    let paths = || outputs.iter().map(|o| o.path.as_str());
    if paths().enumerate().all(is_frame) { paths().map(str::to_owned).collect() } else { Vec::new() }
}

/// A frame's path without number and ending.
fn stem(path: &str, index: usize) -> Option<&str> {
    path.strip_suffix(&format!(".{index:03}.png"))
}

fn read(folder: &Path, frames: &[String]) -> Result<Vec<Frame>, String> {
    let read = |path: &String| {
        let named = |e: String| format!("{path}: {e}");
        let bytes = std::fs::read(folder.join(path)).map_err(|e| named(format!("cannot be read: {e}")))?;
        Frame::of_png(&bytes, MOST_PIXELS).map_err(named)
    };
    frames.iter().map(read).collect()
}

fn write(
    folder: &Path,
    frames: &[String],
    pictures: &[Frame],
    format: AnimationFormat,
    animation: &Animation,
    ffmpeg: Option<&Ffmpeg>,
) -> Result<PathBuf, String> {
    let rate = animation.frames_per_second;
    let bytes = match format {
        AnimationFormat::Apng => encode_apng(pictures, rate)?,
        AnimationFormat::Webp => encode_webp(pictures, rate)?,
        AnimationFormat::Mp4 => encode_mp4(ffmpeg.ok_or("there is no ffmpeg")?, pictures, rate, animation.background)?,
    };
    let stem = frames.first().and_then(|path| stem(path, 0)).ok_or("there are no frames")?;
    let path = PathBuf::from(format!("{stem}.{}", format.ending()));
    atomic::write(&folder.join(&path), &bytes).map_err(|e| format!("{}: cannot be written: {e}", path.display()))?;
    Ok(path)
}
