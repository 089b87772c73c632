use super::Outcome;
use crate::write::atomic;
use std::fs::{self, File};
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};

/// The record of a batch: `manifest.jsonl` in its output folder, one line an asset.
///
/// While the batch runs, lines are appended as assets are finished, so that a run that is killed leaves what it did.
/// At the end the file is replaced by one in the order of the inputs.
#[derive(Debug)]
pub struct Manifest {
    path: PathBuf,
    file: Mutex<File>,
}

impl Manifest {
    /// Begins an empty manifest in a folder, which is made when it is missing.
    ///
    /// # Errors
    /// When the folder cannot be written to.
    pub fn begin(folder: &Path) -> io::Result<Self> {
        fs::create_dir_all(folder)?;
        let path = folder.join("manifest.jsonl");
        let file = Mutex::new(File::create(&path)?);
        Ok(Self { path, file })
    }

    /// Appends a line.
    ///
    /// # Errors
    /// Those of the file system.
    pub fn append(&self, outcome: &Outcome) -> io::Result<()> {
        let line = outcome.to_line()? + "\n";
        self.file.lock().unwrap_or_else(PoisonError::into_inner).write_all(line.as_bytes())
    }

    /// Replaces what was appended by these lines, whole or not at all.
    ///
    /// # Errors
    /// Those of the file system; then the appended lines stay.
    pub fn finish(&self, outcomes: &[Outcome]) -> io::Result<()> {
        let mut text = String::new();
        for outcome in outcomes {
            text += &outcome.to_line()?;
            text.push('\n');
        }
        atomic::write_durably(&self.path, text.as_bytes())
    }
}
