use super::record::{self, Record};
use crate::write::apng::{self, Frame};
use crate::write::atomic;
use rayon::prelude::*;
use std::io;
use std::path::{Path, PathBuf};

/// Pixels of a frame that is read, at most.
const MOST_PIXELS: u64 = 1 << 28;

/// A turntable that became an animation, or did not.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Animated {
    /// The asset, as the manifest calls it.
    pub input: String,
    /// The animation's path below the folder, or a sentence with why there is none.
    pub result: Result<PathBuf, String>,
}

/// Makes an animated PNG of every turntable of a batch's folder, from its PNG files: `chairs/oak.glb.apng` of
/// `chairs/oak.glb.000.png` and so on. On the current rayon pool, several at a time; in the manifest's order.
///
/// # Errors
/// When the manifest cannot be read, with its path.
pub fn animate(folder: &Path, frames_per_second: u16) -> io::Result<Vec<Animated>> {
    let with_frames = |record: Record| {
        let frames = frames(&record);
        (record, frames)
    };
    let turntables: Vec<_> = record::read(folder)?.into_iter().map(with_frames).collect();
    let animated = |(record, frames): &(Record, Vec<String>)| Animated {
        input: record.input.clone(),
        result: one(folder, frames, frames_per_second),
    };
    Ok(turntables.par_iter().filter(|(_, frames)| frames.len() > 1).map(animated).collect())
}

/// The PNG files of a record that are frames of a turntable: numbered from 000.
fn frames(record: &Record) -> Vec<String> {
    let mut outputs: Vec<_> = record.outputs.iter().filter(|o| o.format == "png").collect();
    outputs.sort_by_key(|o| o.view);
    let is_frame = |(index, path): (usize, &str)| stem(path, index).is_some();
    let paths = || outputs.iter().map(|o| o.path.as_str());
    if paths().enumerate().all(is_frame) { paths().map(str::to_owned).collect() } else { Vec::new() }
}

/// A frame's path without number and ending.
fn stem(path: &str, index: usize) -> Option<&str> {
    path.strip_suffix(&format!(".{index:03}.png"))
}

fn one(folder: &Path, frames: &[String], frames_per_second: u16) -> Result<PathBuf, String> {
    let read = |path: &String| {
        let named = |e: String| format!("{path}: {e}");
        let bytes = std::fs::read(folder.join(path)).map_err(|e| named(format!("cannot be read: {e}")))?;
        Frame::of_png(&bytes, MOST_PIXELS).map_err(named)
    };
    let pictures = frames.iter().map(read).collect::<Result<Vec<_>, _>>()?;
    let bytes = apng::encode(&pictures, frames_per_second)?;
    let stem = frames.first().and_then(|path| stem(path, 0)).ok_or("there are no frames")?;
    let path = PathBuf::from(format!("{stem}.apng"));
    atomic::write(&folder.join(&path), &bytes).map_err(|e| format!("{}: cannot be written: {e}", path.display()))?;
    Ok(path)
}
