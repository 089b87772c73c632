//! Files that are whole or absent.

use std::ffi::OsStr;
use std::fs::{self, File};
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU64, Ordering};

/// A file that is being written; removed unless it is committed.
struct Temporary {
    path: PathBuf,
    committed: bool,
}

impl Temporary {
    /// Finds a name in the folder of a file, which is made when it is missing.
    fn beside(path: &Path) -> io::Result<Self> {
        static COUNTER: AtomicU64 = AtomicU64::new(0);
        if path.file_name().is_none() {
            return Err(io::Error::new(io::ErrorKind::InvalidInput, "is not a file name"));
        }
        if let Some(folder) = path.parent().filter(|f| !f.as_os_str().is_empty()) {
            fs::create_dir_all(folder)?;
        }
        // Not made from the name: that may already be as long as the file system allows.
        let unique = COUNTER.fetch_add(1, Ordering::Relaxed);
        let name = format!(".kiln-{}-{unique}.tmp", std::process::id());
        Ok(Self { path: path.with_file_name(name), committed: false })
    }

    /// Becomes the file.
    fn take_name(&mut self, path: &Path) -> io::Result<()> {
        fs::rename(&self.path, path)?;
        self.committed = true;
        Ok(())
    }
}

impl Drop for Temporary {
    fn drop(&mut self) {
        if !self.committed {
            // Nothing better can be done when this fails too.
            let _ = fs::remove_file(&self.path);
        }
    }
}

/// Writes a file so that at any moment, whatever happens, `path` holds its old content or all of the new one.
///
/// The bytes go to a temporary file in the same folder (which is made when it is missing) that takes the name at the
/// end. This holds whenever the process dies. When the whole machine does, only the file system knows: waiting for the
/// disk (0.1 s a file on a machine of ours) would cost more than many a picture; [`write_durably`] does wait.
///
/// # Errors
/// Those of the file system; then the temporary file is gone and `path` is as it was.
pub fn write(path: &Path, bytes: &[u8]) -> io::Result<()> {
    replace(path, |file| file.write_all(bytes))
}

/// As [`write()`], with what `fill` writes.
///
/// # Errors
/// As [`write()`], and those of `fill`.
pub fn write_with(path: &Path, fill: impl FnOnce(&mut File) -> io::Result<()>) -> io::Result<()> {
    replace(path, fill)
}

/// As [`write()`], with the bytes on disk before the file takes its name.
///
/// # Errors
/// As [`write()`].
pub fn write_durably(path: &Path, bytes: &[u8]) -> io::Result<()> {
    write_durably_with(path, |file| file.write_all(bytes))
}

/// As [`write_durably`], with what `fill` writes.
///
/// # Errors
/// As [`write()`], and those of `fill`.
pub fn write_durably_with(path: &Path, fill: impl FnOnce(&mut File) -> io::Result<()>) -> io::Result<()> {
    replace(path, |file| {
        fill(file)?;
        file.sync_data()
    })
}

/// Gives a file a second place, whole or not at all: by a link where the file system can, by a copy elsewhere.
///
/// # Errors
/// Those of the file system; then `target` is as it was.
pub fn link_or_copy(source: &Path, target: &Path) -> io::Result<()> {
    // Of two names of one file, renaming one to the other would leave both.
    if is_same_file(&source.metadata()?, target) {
        return Ok(());
    }
    let mut temporary = Temporary::beside(target)?;
    if fs::hard_link(source, &temporary.path).is_err() {
        fs::copy(source, &temporary.path)?;
    }
    temporary.take_name(target)
}

/// Whether a path leads to a file.
#[cfg(unix)]
pub fn is_same_file(file: &fs::Metadata, path: &Path) -> bool {
    use std::os::unix::fs::MetadataExt;
    path.metadata().is_ok_and(|other| (file.dev(), file.ino()) == (other.dev(), other.ino()))
}

/// Whether a path leads to a file; where files have no numbers, nobody knows.
#[cfg(not(unix))]
pub fn is_same_file(_: &fs::Metadata, _: &Path) -> bool {
    false
}

/// Whether a file name is that of a temporary file of ours.
pub fn is_temporary(name: &OsStr) -> bool {
    name.to_str().is_some_and(|name| name.starts_with(".kiln-") && name.ends_with(".tmp"))
}

fn replace(path: &Path, fill: impl FnOnce(&mut File) -> io::Result<()>) -> io::Result<()> {
    let mut temporary = Temporary::beside(path)?;
    let mut file = File::create(&temporary.path)?;
    fill(&mut file)?;
    drop(file);
    temporary.take_name(path)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::ffi::OsString;

    fn names(folder: &Path) -> Vec<OsString> {
        folder.read_dir().expect("folder").map(|e| e.expect("entry").file_name()).collect()
    }

    #[test]
    fn folders_are_made_and_old_files_replaced() {
        let folder = tempfile::tempdir().expect("temporary folder");
        let path = folder.path().join("a/b/c.png");
        write(&path, b"old").expect("write");
        write(&path, b"new").expect("write");
        assert_eq!(fs::read(&path).expect("read"), b"new");
        assert_eq!(names(&folder.path().join("a/b")), ["c.png"]);
    }

    #[test]
    fn a_failure_leaves_nothing_behind() {
        let folder = tempfile::tempdir().expect("temporary folder");
        // The final name is taken by a folder that is not empty: the rename fails after all bytes are written.
        let path = folder.path().join("c.png");
        fs::create_dir_all(path.join("inside")).expect("folder");
        assert!(write(&path, b"new").is_err());
        assert_eq!(names(folder.path()), ["c.png"]);
        assert!(write(Path::new(".."), b"new").is_err());
    }
}
