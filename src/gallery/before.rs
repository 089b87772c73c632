use super::entry::{Entry, Words};
use super::record::{self, Record};
use super::views::{Paths, Views, rounded};
use crate::metrics::{Show, Shown, rmse};
use rayon::prelude::*;
use serde::Serialize;
use std::collections::{HashMap, HashSet};
use std::fs;
use std::io;
use std::path::{Component, Path, PathBuf};

/// Texels of a picture that is read to be compared, at most.
const MOST_TEXELS: u64 = 1 << 28;

/// What an earlier run made of an asset.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub(super) struct Before {
    pub status: String,
    #[serde(skip_serializing_if = "Paths::is_empty")]
    pub png: Paths,
    /// Wall and CPU seconds.
    pub seconds: (f64, f64),
    /// Stated error of the first view, and its bound.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub error: Option<(f64, f64)>,
    pub change: Change,
    /// How much the first view that differs differs, RMS levels of 255.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub levels: Option<f64>,
    /// The first view that differs.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub view: Option<usize>,
}

/// What became of an asset's pictures.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub(super) enum Change {
    /// The same bytes in every view.
    Same,
    /// Other bytes, or other views.
    Changed,
    /// There are pictures now, and were none.
    Fixed,
    /// There were pictures, and are none now.
    Broken,
    /// There were none and are none.
    None,
    /// The asset is not in this run.
    Gone,
}

/// An earlier run.
pub(super) struct Earlier {
    folder: PathBuf,
    /// The gallery's folder.
    own: PathBuf,
    /// From the gallery's folder to it, ending in `/`, as a page needs it.
    link: String,
    records: Vec<Record>,
    /// Their numbers by name.
    known: HashMap<String, usize>,
    /// Names of this run's assets.
    here: HashSet<String>,
}

impl Earlier {
    /// Reads the manifest of an earlier run in `folder`, to be linked to from a page in `from`.
    ///
    /// # Errors
    /// Those of the file system.
    pub fn read(from: &Path, folder: &Path) -> io::Result<Self> {
        let records = record::read(folder)?;
        let known = records.iter().enumerate().map(|(number, r)| (r.input.clone(), number)).collect();
        let whole = |path: &Path| path.canonicalize().map_err(|e| record::named(path, e));
        let link = relative(&whole(from)?, &whole(folder)?);
        let (folder, own) = (folder.to_path_buf(), from.to_path_buf());
        Ok(Self { folder, own, link, records, known, here: HashSet::new() })
    }

    /// Fills in what the earlier run made of these assets. `records` and `entries` belong together one by one.
    pub fn compare(&mut self, records: &[Record], entries: &mut [Entry]) {
        self.here.extend(records.iter().map(|r| r.input.clone()));
        let own = &self.own;
        entries.par_iter_mut().zip(records).for_each(|(entry, record)| {
            let Some(earlier) = self.known.get(&record.input).map(|number| &self.records[*number]) else { return };
            let (was, is) = (pictures(earlier), pictures(record));
            let mut before = self.before(earlier, Change::Same);
            before.change = match (was.is_empty(), is.is_empty()) {
                (true, true) => Change::None,
                (true, false) => Change::Fixed,
                (false, true) => Change::Broken,
                (false, false) => {
                    let differs = |(a, b): (&&str, &&str)| !same_bytes(&own.join(a), &self.folder.join(b));
                    let view = is.iter().zip(&was).position(differs);
                    before.view = view;
                    before.levels = view.and_then(|v| levels(&own.join(is[v]), &self.folder.join(was[v])));
                    if view.is_none() && is.len() == was.len() { Change::Same } else { Change::Changed }
                }
            };
            entry.before = Some(before);
        });
    }

    /// Assets of the earlier run that were not compared: they are not in this one.
    pub fn gone(&self, words: &mut Words) -> Vec<Entry> {
        let gone = self.records.iter().filter(|r| !self.here.contains(&r.input));
        let entry = |record: &Record| Entry {
            status: "gone".into(),
            views: None,
            before: Some(self.before(record, Change::Gone)),
            ..Entry::of(record, words)
        };
        gone.map(entry).collect()
    }

    fn before(&self, record: &Record, change: Change) -> Before {
        let first = record.outputs.first();
        let stated = first.and_then(|o| Some((rounded(o.error?), rounded(o.error_bound?))));
        Before {
            status: record.status.clone(),
            png: Views::of(record).map(|v| v.png.below(&self.link)).unwrap_or_default(),
            seconds: (rounded(record.seconds.total), rounded(record.cpu_seconds.total)),
            error: stated,
            change,
            levels: None,
            view: None,
        }
    }
}

/// The PNG files of a record, view by view.
fn pictures(record: &Record) -> Vec<&str> {
    let mut outputs: Vec<_> = record.outputs.iter().filter(|o| o.is_rendered("png")).collect();
    outputs.sort_by_key(|o| o.view);
    outputs.iter().map(|o| o.path.as_str()).collect()
}

/// Whether two files hold the same; files that cannot be read do not.
fn same_bytes(a: &Path, b: &Path) -> bool {
    let size = |path: &Path| fs::metadata(path).ok().map(|m| m.len());
    match (size(a), size(b)) {
        (Some(x), Some(y)) if x == y => matches!((fs::read(a), fs::read(b)), (Ok(x), Ok(y)) if x == y),
        _ => false,
    }
}

/// RMS difference as displayed; `None` for pictures of different sizes and such that cannot be read.
fn levels(a: &Path, b: &Path) -> Option<f64> {
    let read = |path| Shown::read(path, &Show::default(), MOST_TEXELS).ok();
    let (a, b) = (read(a)?, read(b)?);
    ((a.width, a.height) == (b.width, b.height)).then(|| rounded(rmse(&a, &b)))
}

/// The way from one folder to another, both whole paths, with `/` and one at the end; the whole path where there is no way.
fn relative(from: &Path, to: &Path) -> String {
    let shared = from.components().zip(to.components()).take_while(|(a, b)| a == b).count();
    let text = |c: Component| c.as_os_str().to_string_lossy().into_owned() + "/";
    if shared == 0 {
        return to.to_string_lossy().replace('\\', "/") + "/";
    }
    let up = from.components().skip(shared).map(|_| String::from("../"));
    up.chain(to.components().skip(shared).map(text)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ways_between_folders() {
        let way = |from, to| relative(Path::new(from), Path::new(to));
        assert_eq!(way("/a/b", "/a/c/d"), "../c/d/");
        assert_eq!(way("/a/b", "/a/b"), "");
        assert_eq!(way("/a/b/c", "/a"), "../../");
        assert_eq!(way("/a", "/a/old #1"), "old #1/");
    }
}
