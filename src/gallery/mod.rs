//! The gallery: what a batch made, as one HTML file that opens from disk.
//!
//! It is made of the folder's `manifest.jsonl` alone, so that a folder of any age or origin can be given one. The page
//! loads nothing but the pictures beside it.

mod animate;
mod before;
mod entry;
mod page;
mod record;
mod views;

use crate::write::atomic;
pub use animate::{Animated, animate};
use before::Earlier;
use entry::{Entry, Words};
use std::io;
use std::path::{Path, PathBuf};

/// What a gallery is made of.
#[derive(Clone, Debug)]
pub struct Gallery<'a> {
    /// A folder that `kiln batch` has written to.
    pub folder: &'a Path,
    /// The output folder of an earlier run to compare with.
    pub against: Option<&'a Path>,
}

/// A gallery that has been written.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Written {
    /// The page.
    pub path: PathBuf,
    /// Assets shown.
    pub assets: usize,
    /// Lines of the manifest that could not be read, such as one that was being written when the batch was killed.
    pub unreadable: usize,
}

impl Gallery<'_> {
    /// Writes `index.html` into the folder, whole or not at all.
    ///
    /// Where a picture differs from the earlier run's, both are read to measure by how much (on the current rayon pool).
    ///
    /// # Errors
    /// Those of the file system, with the path; [`io::ErrorKind::NotFound`] when a folder has no manifest.
    pub fn write(&self) -> io::Result<Written> {
        let manifest = record::read(self.folder)?;
        let earlier = self.against.map(|folder| Earlier::read(self.folder, folder)).transpose()?;
        let mut words = Words::default();
        let mut entries: Vec<Entry> = manifest.records.iter().map(|r| Entry::of(r, &mut words)).collect();
        if let Some(earlier) = &earlier {
            earlier.compare(&manifest.records, &mut entries);
            entries.extend(earlier.gone(&manifest.records, &mut words));
        }
        let contents = page::Contents {
            title: name(self.folder),
            against: self.against.map(name),
            kiln: env!("CARGO_PKG_VERSION"),
            unreadable: manifest.unreadable,
            words,
            assets: entries,
        };
        let path = self.folder.join("index.html");
        let text = page::html(&contents)?;
        atomic::write(&path, text.as_bytes()).map_err(|e| record::named(&path, e))?;
        Ok(Written { path, assets: manifest.records.len(), unreadable: manifest.unreadable })
    }
}

/// What people call a folder.
fn name(folder: &Path) -> String {
    let whole = folder.canonicalize();
    let path = whole.as_deref().unwrap_or(folder);
    path.file_name().unwrap_or(path.as_os_str()).to_string_lossy().into_owned()
}
