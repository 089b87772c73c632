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
pub use animate::{Animated, Animation, AnimationFormat, animate};
use before::Earlier;
use entry::{Entry, Words};
use page::{Head, Page};
use record::{Manifest, Record};
use std::io::{self, BufWriter};
use std::path::{Path, PathBuf};

/// What a gallery is made of.
#[derive(Clone, Debug)]
pub struct Gallery<'a> {
    /// A folder that `kiln batch` has written to.
    pub folder: &'a Path,
    /// The output folder of an earlier run to compare with.
    pub against: Option<&'a Path>,
}

/// Assets that are held at a time: enough to keep all cores busy with comparing pictures.
const AT_A_TIME: usize = 1024;

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
        let mut manifest = Manifest::open(self.folder)?;
        let mut earlier = self.against.map(|folder| Earlier::read(self.folder, folder)).transpose()?;
        let head = Head { title: name(self.folder), against: self.against.map(name), kiln: env!("CARGO_PKG_VERSION") };
        let path = self.folder.join("index.html");
        let mut assets = 0;
        let written = atomic::write_with(&path, |target| {
            let mut page = Page::begin(BufWriter::with_capacity(1 << 18, target), &head)?;
            let mut words = Words::default();
            let mut some = Vec::new();
            let mut put = |records: &mut Vec<Record>, words: &mut Words, page: &mut Page<_>| {
                let mut entries: Vec<Entry> = records.iter().map(|r| Entry::of(r, words)).collect();
                if let Some(earlier) = &mut earlier {
                    earlier.compare(records, &mut entries);
                }
                assets += records.len();
                records.clear();
                entries.iter().try_for_each(|entry| page.add(entry))
            };
            manifest.each(|record| {
                some.push(record);
                if some.len() < AT_A_TIME { Ok(()) } else { put(&mut some, &mut words, &mut page) }
            })?;
            put(&mut some, &mut words, &mut page)?;
            if let Some(earlier) = &earlier {
                earlier.gone(&mut words).iter().try_for_each(|entry| page.add(entry))?;
            }
            page.end(manifest.unreadable, &words)
        });
        written.map_err(|e| record::named(&path, e))?;
        Ok(Written { path, assets, unreadable: manifest.unreadable })
    }
}

/// What people call a folder.
fn name(folder: &Path) -> String {
    let whole = folder.canonicalize();
    let path = whole.as_deref().unwrap_or(folder);
    path.file_name().unwrap_or(path.as_os_str()).to_string_lossy().into_owned()
}
