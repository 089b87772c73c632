//! The only input: files of the asset, confined to a root folder and to limits.

use crate::{ErrorCode, ImportError, Limits};
use std::fs::File;
use std::io::Read;
use std::path::{Component, Path, PathBuf};
use std::sync::{Mutex, PoisonError};

/// Reads the asset's file and what it refers to.
///
/// References are relative to the asset's folder, may use `..` inside the root, and are refused outside it after
/// links are resolved. Only regular files are read, and never more bytes than the limit allows.
#[derive(Debug)]
pub struct Resources {
    folder: PathBuf,
    root: PathBuf,
    limits: Limits,
    read: Vec<FileRead>,
    /// A lock, because looking for a file changes nothing else.
    missing: Mutex<Vec<PathBuf>>,
    survey: bool,
    hashes: bool,
}

/// A file that was read.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct FileRead {
    /// Its canonical path.
    pub path: PathBuf,
    /// BLAKE3 hash of the bytes that were read; zeros where nobody is to ask ([`Resources::skip_hashes`]).
    pub hash: [u8; 32],
}

/// The files that decide what an asset is.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Touched {
    /// What was read, the asset first, each file once.
    pub read: Vec<FileRead>,
    /// What was looked for and is not there: should it appear, the asset is another one.
    pub missing: Vec<PathBuf>,
}

fn io_error(name: &str, error: &std::io::Error) -> ImportError {
    ImportError::new(ErrorCode::Io, format!("cannot be read: {error}")).in_file(name)
}

impl Resources {
    /// For the asset at `asset`. `root` is the folder that references may not leave; without one it is the parent
    /// of the asset's folder.
    ///
    /// # Errors
    /// [`ErrorCode::Io`] when the asset's folder or the root does not exist.
    pub fn new(asset: &Path, root: Option<&Path>, limits: Limits) -> Result<Self, ImportError> {
        let parent = match asset.parent() {
            Some(p) if !p.as_os_str().is_empty() => p,
            _ => Path::new("."),
        };
        let canonical = |p: &Path| p.canonicalize().map_err(|e| io_error(&p.display().to_string(), &e));
        let folder = canonical(parent)?;
        let root = match root {
            Some(root) => canonical(root)?,
            None => folder.parent().unwrap_or(&folder).to_path_buf(),
        };
        Ok(Self { folder, root, limits, read: Vec::new(), missing: Mutex::default(), survey: false, hashes: true })
    }

    /// The asset's file name without its ending, once it has been read.
    pub fn asset_name(&self) -> Option<String> {
        Some(self.read.first()?.path.file_stem()?.to_str()?.to_owned())
    }

    /// Hashes nothing from here on: of a large file of text that is a thirtieth of the work.
    pub fn skip_hashes(&mut self) {
        self.hashes = false;
    }

    /// Asks for what the files say, not for what only rendering needs: of images no more than their headers, where geometry and materials do
    /// not depend on pixels, and no tangents.
    pub fn only_survey(&mut self) {
        self.survey = true;
    }

    /// Whether nobody is to render what is read.
    pub fn is_survey(&self) -> bool {
        self.survey
    }

    /// The limits in force.
    pub fn limits(&self) -> &Limits {
        &self.limits
    }

    /// The files read and looked for so far: the asset with all that it refers to.
    pub fn touched(&self) -> Touched {
        let missing = self.missing.lock().unwrap_or_else(PoisonError::into_inner).clone();
        Touched { read: self.read.clone(), missing }
    }

    /// Reads the asset itself (it may lie anywhere).
    ///
    /// # Errors
    /// As [`Resources::read`].
    pub fn read_asset(&mut self, asset: &Path) -> Result<Vec<u8>, ImportError> {
        let path = asset.canonicalize().map_err(|e| io_error("", &e))?;
        self.read_regular(&path, "")
    }

    /// Reads a file that the asset refers to. `reference` is a relative path with `/` or `\` between its parts.
    ///
    /// # Errors
    /// [`ErrorCode::Refused`] for absolute paths, URI schemes, what is no regular file and what lies outside the
    /// root; [`ErrorCode::Io`] when there is no such file; [`ErrorCode::TooLarge`].
    pub fn read(&mut self, reference: &str) -> Result<Vec<u8>, ImportError> {
        let path = self.resolve(reference)?;
        self.read_regular(&path, reference)
    }

    /// The canonical path of a reference, checked as [`Resources::read`] does.
    ///
    /// # Errors
    /// As [`Resources::read`], without the size.
    pub fn resolve(&self, reference: &str) -> Result<PathBuf, ImportError> {
        let refused = |why: &str| Err(ImportError::new(ErrorCode::Refused, why).in_file(reference));
        let unix = reference.replace('\\', "/");
        if unix.is_empty() || unix.contains('\0') {
            return refused("is not a file name");
        }
        let relative = Path::new(&unix);
        let drive = unix.as_bytes().get(1) == Some(&b':') && unix.as_bytes()[0].is_ascii_alphabetic();
        let absolute = relative.components().any(|c| matches!(c, Component::RootDir | Component::Prefix(_)));
        if absolute || drive || unix.split('/').next().is_some_and(|first| first.contains(':')) {
            return refused("absolute paths and URI schemes are refused: only files below the root are read");
        }
        let path = self.folder.join(relative);
        let path = match path.canonicalize() {
            Ok(path) => path,
            // Files packed on case-insensitive systems often differ in case from their references.
            Err(error) => match find_ignoring_case(&self.folder, relative) {
                Some(path) => path,
                None => {
                    let mut missing = self.missing.lock().unwrap_or_else(PoisonError::into_inner);
                    if !missing.contains(&path) {
                        missing.push(path);
                    }
                    return Err(io_error(reference, &error));
                }
            },
        };
        if !path.starts_with(&self.root) {
            return refused("lies outside the root folder");
        }
        Ok(path)
    }

    fn read_regular(&mut self, path: &Path, name: &str) -> Result<Vec<u8>, ImportError> {
        let metadata = path.metadata().map_err(|e| io_error(name, &e))?;
        if !metadata.is_file() {
            return Err(ImportError::new(ErrorCode::Refused, "is not a regular file").in_file(name));
        }
        let limit = self.limits.max_file_bytes;
        let too_large = || {
            let message = format!("is larger than the limit of {limit} bytes");
            ImportError::new(ErrorCode::TooLarge, message).in_file(name)
        };
        if metadata.len() > limit {
            return Err(too_large());
        }
        let file = File::open(path).map_err(|e| io_error(name, &e))?;
        // Sparse files claim any size, so a large one is not believed until it is read.
        let mut bytes = Vec::with_capacity(usize::try_from(metadata.len().min(1 << 30)).unwrap_or(0));
        // The file may grow while it is read.
        file.take(limit.saturating_add(1)).read_to_end(&mut bytes).map_err(|e| io_error(name, &e))?;
        if bytes.len() as u64 > limit {
            return Err(too_large());
        }
        if !self.read.iter().any(|file| file.path == path) {
            let hash = if self.hashes { blake3::hash(&bytes).into() } else { [0; 32] };
            self.read.push(FileRead { path: path.to_path_buf(), hash });
        }
        Ok(bytes)
    }
}

fn find_ignoring_case(folder: &Path, relative: &Path) -> Option<PathBuf> {
    let mut path = folder.to_path_buf();
    for part in relative.components() {
        let next = path.join(part);
        path = match part {
            Component::Normal(name) if !next.exists() => {
                let name = name.to_str()?.to_lowercase();
                let mut found: Vec<PathBuf> = path
                    .read_dir()
                    .ok()?
                    .filter_map(|entry| Some(entry.ok()?.path()))
                    .filter(|p| p.file_name().and_then(|n| n.to_str()).is_some_and(|n| n.to_lowercase() == name))
                    .collect();
                found.sort();
                found.into_iter().next()?
            }
            _ => next,
        };
    }
    path.canonicalize().ok()
}

#[cfg(test)]
#[path = "resources_tests.rs"]
mod tests;
