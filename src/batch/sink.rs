use crate::write::atomic;
use std::io;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};

/// Where finished picture files go.
pub trait Sink: Sync {
    /// Takes a whole file. `path` is relative.
    ///
    /// # Errors
    /// When it cannot be kept; then nothing of it is.
    fn put(&self, path: &Path, bytes: Vec<u8>) -> io::Result<()>;
}

/// A folder on disk. Files appear whole.
#[derive(Clone, Debug)]
pub struct FileSink {
    /// The folder.
    pub folder: PathBuf,
}

impl Sink for FileSink {
    fn put(&self, path: &Path, bytes: Vec<u8>) -> io::Result<()> {
        atomic::write(&self.folder.join(path), &bytes)
    }
}

/// Keeps the files in memory, in the order in which they came.
#[derive(Debug, Default)]
pub struct MemorySink {
    files: Mutex<Vec<(PathBuf, Vec<u8>)>>,
}

impl MemorySink {
    /// The files.
    pub fn into_files(self) -> Vec<(PathBuf, Vec<u8>)> {
        self.files.into_inner().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Sink for MemorySink {
    fn put(&self, path: &Path, bytes: Vec<u8>) -> io::Result<()> {
        self.files.lock().unwrap_or_else(PoisonError::into_inner).push((path.to_path_buf(), bytes));
        Ok(())
    }
}
