use serde::Deserialize;
use std::collections::HashMap;
use std::fs::File;
use std::io::{self, BufRead, BufReader};
use std::path::Path;

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

/// A manifest that was read.
#[derive(Debug, Default)]
pub(super) struct Manifest {
    /// In the order of the file; where an asset has several lines, the last one counts.
    pub records: Vec<Record>,
    /// Lines that are no record.
    pub unreadable: usize,
}

/// Reads `manifest.jsonl` of a folder.
///
/// # Errors
/// Those of the file system, with the path.
pub(super) fn read(folder: &Path) -> io::Result<Manifest> {
    let path = folder.join("manifest.jsonl");
    let file = File::open(&path).map_err(|e| named(&path, e))?;
    parse(BufReader::new(file)).map_err(|e| named(&path, e))
}

/// An error with the path that it is about.
pub(super) fn named(path: &Path, error: io::Error) -> io::Error {
    io::Error::new(error.kind(), format!("{}: {error}", path.display()))
}

fn parse(mut reader: impl BufRead) -> io::Result<Manifest> {
    let mut manifest = Manifest::default();
    let mut places: HashMap<String, usize> = HashMap::new();
    let mut line = Vec::new();
    while reader.read_until(b'\n', &mut line)? > 0 {
        if !line.trim_ascii().is_empty() {
            match serde_json::from_slice::<Record>(&line) {
                Ok(record) => match places.get(&record.input) {
                    Some(&place) => manifest.records[place] = record,
                    None => {
                        places.insert(record.input.clone(), manifest.records.len());
                        manifest.records.push(record);
                    }
                },
                Err(_) => manifest.unreadable += 1,
            }
        }
        line.clear();
    }
    Ok(manifest)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_last_line_of_an_asset_counts_and_half_a_line_is_told() {
        let text = "{\"input\": \"a\", \"status\": \"failed\"}\n{\"input\": \"b\", \"status\": \"ok\", \"novel\": [1]}\n\n\
                    {\"input\": \"a\", \"status\": \"ok\"}\n{\"input\": \"c\", \"sta";
        let manifest = parse(text.as_bytes()).expect("read");
        let found: Vec<(&str, &str)> = manifest.records.iter().map(|r| (r.input.as_str(), r.status.as_str())).collect();
        assert_eq!(found, [("a", "ok"), ("b", "ok")]);
        assert_eq!(manifest.unreadable, 1);
    }

    #[test]
    fn a_folder_without_a_manifest_is_named() {
        let folder = tempfile::tempdir().expect("temporary folder");
        let error = read(folder.path()).expect_err("no manifest");
        assert_eq!(error.kind(), io::ErrorKind::NotFound);
        assert!(error.to_string().contains("manifest.jsonl"), "{error}");
    }
}
