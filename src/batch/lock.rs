use crate::write::atomic;
use std::fs::{self, File, TryLockError};
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

/// How long the workers of a run that was killed may take to be gone.
const PATIENCE: Duration = Duration::from_secs(10);

/// How long a lock is asked for before somebody else is taken to have it.
const BUSY: Duration = Duration::from_secs(1);
/// How often it is asked for.
const LOOK: Duration = Duration::from_millis(10);

/// An output folder that is ours: one run writes into it at a time.
///
/// The lock is the system's (on `.kiln.lock`), so it ends with the process however that ends. The file is taken away when the run
/// ends in order; finding one means that the run before did not, and that there may be half-written temporary files.
#[derive(Debug)]
pub struct OutputLock {
    path: PathBuf,
    /// Held by the workers together.
    presence: PathBuf,
    _file: Option<File>,
    /// What could not be made sure of.
    pub warning: Option<String>,
}

impl OutputLock {
    /// Takes the folder, which is made when it is missing, and takes away what a run that was killed left half-done.
    ///
    /// # Errors
    /// [`io::ErrorKind::ResourceBusy`] when another run has it; those of the file system.
    pub fn take(folder: &Path) -> io::Result<Self> {
        fs::create_dir_all(folder)?;
        let path = folder.join(".kiln.lock");
        let presence = folder.join(".kiln.workers");
        let begin = Instant::now();
        let (file, unclean, warning) = loop {
            let unclean = path.exists();
            let mut file = File::options().create(true).truncate(false).write(true).read(true).open(&path)?;
            match file.try_lock() {
                Ok(()) if is_still_there(&file, &path) => {
                    // For people who wonder.
                    file.set_len(0)?;
                    writeln!(file, "kiln, process {}", std::process::id())?;
                    break (Some(file), unclean, None);
                }
                // Its owner took it away in this moment.
                Ok(()) => (),
                // A child between its fork and its exec holds it for a moment longer than a run that was killed.
                Err(TryLockError::WouldBlock) if begin.elapsed() < BUSY => std::thread::sleep(LOOK),
                Err(TryLockError::WouldBlock) => {
                    let message = "another run of kiln writes into it";
                    return Err(io::Error::new(io::ErrorKind::ResourceBusy, message));
                }
                Err(TryLockError::Error(error)) => {
                    let warning =
                        format!("the file system has no locks ({error}): see to it that one run at a time writes here");
                    break (None, unclean, Some(warning));
                }
            }
        };
        let lock = Self { path, presence, _file: file, warning };
        let workers = File::options().create(true).truncate(false).write(true).open(&lock.presence)?;
        let begin = Instant::now();
        while matches!(workers.try_lock(), Err(TryLockError::WouldBlock)) {
            if begin.elapsed() > PATIENCE {
                let message = "workers of a run that was killed still write into it";
                return Err(io::Error::new(io::ErrorKind::ResourceBusy, message));
            }
            std::thread::sleep(LOOK);
        }
        if unclean {
            sweep(folder);
        }
        Ok(lock)
    }

    /// The file on which workers hold a shared lock.
    pub fn presence(&self) -> &Path {
        &self.presence
    }
}

impl Drop for OutputLock {
    fn drop(&mut self) {
        // While the lock is held nobody else can have made new ones. What cannot be removed is taken for unclean.
        let _ = fs::remove_file(&self.presence);
        let _ = fs::remove_file(&self.path);
    }
}

fn is_still_there(file: &File, path: &Path) -> bool {
    // Where files have no numbers, nobody can take away one that is open.
    !cfg!(unix) || file.metadata().is_ok_and(|file| atomic::is_same_file(&file, path))
}

/// Removes temporary files.
fn sweep(folder: &Path) {
    for entry in walkdir::WalkDir::new(folder).into_iter().filter_map(Result::ok) {
        if entry.file_type().is_file() && atomic::is_temporary(entry.file_name()) {
            // Nothing depends on it.
            let _ = fs::remove_file(entry.path());
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_at_a_time_and_nothing_is_left() {
        let folder = tempfile::tempdir().expect("temporary folder");
        let out = folder.path().join("a/out");
        let lock = OutputLock::take(&out).expect("free");
        assert_eq!(OutputLock::take(&out).expect_err("taken").kind(), io::ErrorKind::ResourceBusy);
        drop(lock);
        assert_eq!(out.read_dir().expect("folder").count(), 0);
        drop(OutputLock::take(&out).expect("free again"));
    }

    #[test]
    fn what_a_killed_run_left_is_swept() {
        let folder = tempfile::tempdir().expect("temporary folder");
        let touch = |name: &str| fs::write(folder.path().join(name), "x").expect("write");
        fs::create_dir(folder.path().join("sub")).expect("folder");
        ["sub/.kiln-7-1.tmp", "a.png", "b.tmp", ".kiln.lock"].iter().for_each(|name| touch(name));
        let lock = OutputLock::take(folder.path()).expect("nobody holds it");
        let there = |name: &str| folder.path().join(name).exists();
        assert!(!there("sub/.kiln-7-1.tmp") && there("a.png") && there("b.tmp"));
        // Without a sign of a killed run nobody searches the folder.
        drop(lock);
        touch("sub/.kiln-7-1.tmp");
        drop(OutputLock::take(folder.path()).expect("free"));
        assert!(there("sub/.kiln-7-1.tmp"));
    }
}
