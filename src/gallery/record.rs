use serde::Deserialize;
use std::borrow::Cow;
use std::collections::HashMap;
use std::fs::File;
use std::io::{self, BufRead, BufReader, Seek, SeekFrom};
use std::path::{Path, PathBuf};

/// A manifest line, as far as the gallery shows it. Other versions of Kiln may have written it: what is missing is
/// unknown, what is new is ignored.
#[derive(Clone, Debug, Default, PartialEq, Deserialize)]
#[serde(default)]
pub(super) struct Record {
    pub input: String,
    pub content: Option<String>,
    pub settings: Option<String>,
    pub seed: u64,
    pub status: String,
    pub error_code: Option<String>,
    pub error_message: Option<String>,
    pub light: Option<String>,
    pub outputs: Vec<Output>,
    pub warnings: Vec<Warning>,
    pub scene: Option<Scene>,
    pub seconds: Seconds,
    pub cpu_seconds: Seconds,
    pub rays: Option<Rays>,
    pub nonfinite: u64,
    pub peak_bytes: Option<u64>,
}

#[derive(Clone, Debug, Default, PartialEq, Deserialize)]
#[serde(default)]
pub(super) struct Output {
    pub path: String,
    pub format: String,
    pub view: u32,
    pub width: u32,
    pub height: u32,
    pub spp: u32,
    pub exposure: f64,
    pub error: Option<f64>,
    pub error_bound: Option<f64>,
    pub relmse: Option<f64>,
    pub target_met: Option<bool>,
    pub bias: Vec<String>,
    pub denoised: Option<String>,
}

impl Output {
    /// Whether it is a picture as it was rendered, in this format.
    pub fn is_rendered(&self, format: &str) -> bool {
        self.format == format && !self.is_denoised_png()
    }

    /// Whether it is a picture without noise that stands beside one.
    pub fn is_denoised_png(&self) -> bool {
        self.format == "png" && self.denoised.is_some()
    }
}

#[derive(Clone, Debug, Default, PartialEq, Deserialize)]
#[serde(default)]
pub(super) struct Warning {
    pub code: String,
    pub place: String,
    pub message: String,
}

#[derive(Clone, Debug, Default, PartialEq, Deserialize)]
#[serde(default)]
pub(super) struct Scene {
    pub triangles: u64,
    pub instances: u64,
    pub emitters: u64,
    pub effects: Vec<String>,
}

#[derive(Clone, Copy, Debug, Default, PartialEq, Deserialize)]
#[serde(default)]
pub(super) struct Seconds {
    pub import: f64,
    pub prepare: f64,
    pub kdtree: f64,
    pub render: f64,
    pub write: f64,
    pub total: f64,
}

#[derive(Clone, Copy, Debug, Default, PartialEq, Deserialize)]
#[serde(default)]
pub(super) struct Rays {
    pub camera: u64,
    pub bounce: u64,
    pub shadow: u64,
}

/// A manifest on the disk, of which the place of each asset's last line is known.
#[derive(Debug)]
pub(super) struct Manifest<R> {
    path: PathBuf,
    reader: R,
    /// First byte and length of each line, in the order in which the assets first come.
    lines: Vec<(u64, usize)>,
    /// Lines that are no record.
    pub unreadable: usize,
}

#[derive(Default, Deserialize)]
#[serde(default)]
struct Name<'a> {
    #[serde(borrow)]
    input: Cow<'a, str>,
}

impl Manifest<BufReader<File>> {
    /// Looks through `manifest.jsonl` of a folder.
    ///
    /// # Errors
    /// Those of the file system, with the path.
    pub fn open(folder: &Path) -> io::Result<Self> {
        let path = folder.join("manifest.jsonl");
        let file = File::open(&path).map_err(|e| named(&path, e))?;
        Self::of(path, BufReader::with_capacity(1 << 18, file))
    }
}

impl<R: BufRead + Seek> Manifest<R> {
    fn of(path: PathBuf, mut reader: R) -> io::Result<Self> {
        let (mut lines, mut unreadable) = (Vec::new(), 0);
        let mut places: HashMap<Box<str>, usize> = HashMap::new();
        let (mut at, mut line) = (0, Vec::new());
        loop {
            line.clear();
            let length = reader.read_until(b'\n', &mut line).map_err(|e| named(&path, e))?;
            if length == 0 {
                return Ok(Self { path, reader, lines, unreadable });
            }
            if !line.trim_ascii().is_empty() {
                match serde_json::from_slice::<Name>(&line) {
                    Ok(name) => match places.get(name.input.as_ref()) {
                        Some(&place) => lines[place] = (at, length),
                        None => {
                            places.insert(name.input.into(), lines.len());
                            lines.push((at, length));
                        }
                    },
                    Err(_) => unreadable += 1,
                }
            }
            at += length as u64;
        }
    }

    /// Each asset's last record, in turn. What is no record after all is counted and left out.
    ///
    /// # Errors
    /// Those of the file system, with the path, and those of `each`.
    pub fn each(&mut self, mut each: impl FnMut(Record) -> io::Result<()>) -> io::Result<()> {
        let (mut place, mut line) = (u64::MAX, Vec::new());
        for &(at, length) in &self.lines {
            line.resize(length, 0);
            // Seeking throws away what has been read ahead.
            let sought = if place == at { Ok(at) } else { self.reader.seek(SeekFrom::Start(at)) };
            sought.and_then(|_| self.reader.read_exact(&mut line)).map_err(|e| named(&self.path, e))?;
            place = at + length as u64;
            match serde_json::from_slice(&line) {
                Ok(record) => each(record)?,
                Err(_) => self.unreadable += 1,
            }
        }
        Ok(())
    }
}

/// All records of a folder's manifest.
///
/// # Errors
/// Those of the file system, with the path.
pub(super) fn read(folder: &Path) -> io::Result<Vec<Record>> {
    let mut records = Vec::new();
    Manifest::open(folder)?.each(|record| {
        records.push(record);
        Ok(())
    })?;
    Ok(records)
}

/// An error with the path that it is about.
pub(super) fn named(path: &Path, error: io::Error) -> io::Error {
    io::Error::new(error.kind(), format!("{}: {error}", path.display()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::io::Cursor;

    #[test]
    fn the_last_line_of_an_asset_counts_and_half_a_line_is_told() {
        let text = "{\"input\": \"a\", \"status\": \"failed\"}\n{\"input\": \"b\", \"status\": \"ok\", \"novel\": [1]}\n\n\
                    {\"input\": \"a\", \"status\": \"ok\"}\n{\"input\": \"d\", \"status\": 7}\n{\"input\": \"c\", \"sta";
        let mut manifest = Manifest::of(PathBuf::new(), Cursor::new(text)).expect("read");
        let mut found = Vec::new();
        let each = |record: Record| {
            found.push((record.input, record.status));
            Ok(())
        };
        manifest.each(each).expect("read again");
        assert_eq!(found, [("a".into(), "ok".into()), ("b".into(), "ok".into())]);
        assert_eq!(manifest.unreadable, 2);
    }

    #[test]
    fn a_folder_without_a_manifest_is_named() {
        let folder = tempfile::tempdir().expect("temporary folder");
        let error = read(folder.path()).expect_err("no manifest");
        assert_eq!(error.kind(), io::ErrorKind::NotFound);
        assert!(error.to_string().contains("manifest.jsonl"), "{error}");
    }
}
