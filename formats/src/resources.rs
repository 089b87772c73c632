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
}

/// A file that was read.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct FileRead {
    /// Its canonical path.
    pub path: PathBuf,
    /// BLAKE3 hash of the bytes that were read.
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
        Ok(Self { folder, root, limits, read: Vec::new(), missing: Mutex::default() })
    }

    /// The asset's file name without its ending, once it has been read.
    pub fn asset_name(&self) -> Option<String> {
        Some(self.read.first()?.path.file_stem()?.to_str()?.to_owned())
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
            self.read.push(FileRead { path: path.to_path_buf(), hash: blake3::hash(&bytes).into() });
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
mod tests {
    use super::*;
    use std::fs;

    /// `top/{root/{asset/{a.obj, Tex/Wood.PNG}, beside.png}, secret.txt}`.
    fn tree() -> (tempfile::TempDir, PathBuf) {
        let top = tempfile::tempdir().unwrap();
        let asset = top.path().join("root/asset");
        fs::create_dir_all(asset.join("Tex")).unwrap();
        for (name, content) in
            [("a.obj", "asset"), ("Tex/Wood.PNG", "wood"), ("../beside.png", "beside"), ("../../secret.txt", "secret")]
        {
            fs::write(asset.join(name), content).unwrap();
        }
        (top, asset)
    }

    fn resources(asset: &Path) -> Resources {
        Resources::new(&asset.join("a.obj"), None, Limits::default()).unwrap()
    }

    #[test]
    fn references_inside_the_root_are_read_and_remembered() {
        let (_top, asset) = tree();
        let mut resources = resources(&asset);
        assert_eq!(resources.read_asset(&asset.join("a.obj")).unwrap(), b"asset");
        for (reference, content) in [
            ("Tex/Wood.PNG", "wood"),
            ("./Tex/../Tex/Wood.PNG", "wood"),
            ("tex\\wood.png", "wood"),
            ("../beside.png", "beside"),
            ("../ASSET/tex/WOOD.png", "wood"),
        ] {
            assert_eq!(resources.read(reference).unwrap(), content.as_bytes(), "{reference}");
        }
        let touched = resources.touched();
        let names: Vec<_> = touched.read.iter().filter_map(|f| f.path.file_name()?.to_str()).collect();
        assert_eq!(names, ["a.obj", "Wood.PNG", "beside.png"]);
        assert_eq!(touched.read[1].hash, *blake3::hash(b"wood").as_bytes());
    }

    #[test]
    fn what_leads_out_of_the_root_is_refused() {
        let (top, asset) = tree();
        let mut resources = resources(&asset);
        let absolute = top.path().join("secret.txt").display().to_string();
        for reference in [
            "../../secret.txt",
            "..\\..\\secret.txt",
            "Tex/../../../SECRET.txt",
            &absolute,
            "file:///etc/passwd",
            "http://example.org/a.png",
            "C:\\a.png",
            "c:a.png",
            "\\\\server\\share\\a.png",
            "",
            "a\0b",
        ] {
            assert_eq!(resources.read(reference).unwrap_err().code, ErrorCode::Refused, "{reference:?}");
        }
        assert_eq!(resources.read("gone.png").unwrap_err().code, ErrorCode::Io);
        let missing = asset.canonicalize().unwrap().join("gone.png");
        assert_eq!(resources.touched(), Touched { read: Vec::new(), missing: vec![missing] });
        let wide = Resources::new(&asset.join("a.obj"), Some(top.path()), Limits::default());
        assert_eq!(wide.unwrap().read("../../secret.txt").unwrap(), b"secret");
        let narrow = Resources::new(&asset.join("a.obj"), Some(&asset), Limits::default());
        assert_eq!(narrow.unwrap().read("../beside.png").unwrap_err().code, ErrorCode::Refused);
    }

    #[cfg(unix)]
    #[test]
    fn links_are_followed_before_they_are_judged() {
        let (top, asset) = tree();
        std::os::unix::fs::symlink(top.path().join("secret.txt"), asset.join("link.png")).unwrap();
        std::os::unix::fs::symlink(top.path(), asset.join("folder")).unwrap();
        std::os::unix::fs::symlink("loop", asset.join("loop")).unwrap();
        std::os::unix::fs::symlink(asset.join("Tex/Wood.PNG"), asset.join("inside.png")).unwrap();
        let mut resources = resources(&asset);
        assert_eq!(resources.read("link.png").unwrap_err().code, ErrorCode::Refused);
        assert_eq!(resources.read("folder/secret.txt").unwrap_err().code, ErrorCode::Refused);
        assert_eq!(resources.read("loop").unwrap_err().code, ErrorCode::Io);
        assert_eq!(resources.read("inside.png").unwrap(), b"wood");
    }

    #[test]
    fn only_regular_files_within_the_limit_are_read() {
        let (_top, asset) = tree();
        assert_eq!(resources(&asset).read("Tex").unwrap_err().code, ErrorCode::Refused);
        assert_eq!(resources(&asset).read(".").unwrap_err().code, ErrorCode::Refused);
        let with = |max_file_bytes| {
            let limits = Limits { max_file_bytes, ..Limits::default() };
            Resources::new(&asset.join("a.obj"), None, limits).unwrap().read("Tex/Wood.PNG")
        };
        assert_eq!(with(3).unwrap_err().code, ErrorCode::TooLarge);
        assert_eq!(with(4).unwrap(), b"wood");
        assert_eq!(with(u64::MAX).unwrap(), b"wood");
        let sparse = File::create(asset.join("sparse.bin")).unwrap();
        if sparse.set_len(1 << 42).is_ok() {
            assert_eq!(resources(&asset).read("sparse.bin").unwrap_err().code, ErrorCode::TooLarge);
        }
    }
}
