use crate::settings::{EffectSet, EnvironmentSettings, Settings};
use kiln_formats::{Control, FileRead};
use std::fs::File;
use std::io::{self, Read};
use std::path::PathBuf;

/// Bytes hashed between two looks at the control.
const BLOCK: usize = 1 << 16;

/// `blake3:` and the hexadecimal hash of bytes.
pub fn of_bytes(bytes: &[u8]) -> String {
    format!("blake3:{}", blake3::hash(bytes).to_hex())
}

/// `blake3:` and the hash over the hashes of these files in this order. Names do not enter.
///
/// # Errors
/// When a file cannot be read; [`io::ErrorKind::Interrupted`] when `control` asks for a stop.
pub fn of_files(files: &[PathBuf], control: &Control) -> io::Result<String> {
    let mut all = blake3::Hasher::new();
    let mut block = [0; BLOCK];
    for file in files {
        let mut one = blake3::Hasher::new();
        let mut reader = File::open(file)?;
        loop {
            control.check().map_err(|stopped| io::Error::new(io::ErrorKind::Interrupted, stopped))?;
            match reader.read(&mut block) {
                Ok(0) => break,
                Ok(n) => one.update(&block[..n]),
                Err(error) if error.kind() == io::ErrorKind::Interrupted => continue,
                Err(error) => return Err(error),
            };
        }
        all.update(one.finalize().as_bytes());
    }
    Ok(format!("blake3:{}", all.finalize().to_hex()))
}

/// As [`of_files`], of files that have been read.
pub fn of_read(files: &[FileRead]) -> String {
    let mut all = blake3::Hasher::new();
    files.iter().for_each(|file| {
        all.update(&file.hash);
    });
    format!("blake3:{}", all.finalize().to_hex())
}

/// `blake3:` and the hash of the canonical JSON (sorted keys, no blanks) of all settings that pictures depend on.
///
/// The instruction set and forced effects are left out, for they change no pixel, and so is the time allowed: a picture that was finished within
/// it is the picture without it, and one that was not says so. An environment file counts by its content.
///
/// # Errors
/// Only should a number not be finite, which JSON cannot say.
pub fn of_settings(settings: &Settings, environment_digest: Option<&str>) -> serde_json::Result<String> {
    let mut settings = settings.clone();
    settings.prepare.simd = Default::default();
    settings.prepare.effects.forced = EffectSet::default();
    settings.goal.time = None;
    if let Some(program) = &mut settings.pictures.denoise {
        // Where it is.
        program.0 = PathBuf::new();
    }
    if let (EnvironmentSettings::File(file), Some(digest)) = (&mut settings.environment, environment_digest) {
        file.path = PathBuf::from(digest);
    }
    // Objects of serde_json are sorted maps.
    Ok(of_bytes(serde_json::to_value(&settings)?.to_string().as_bytes()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::settings::{EnvironmentFile, SimdTier};

    #[test]
    fn settings_hash_follows_what_pixels_depend_on() {
        let hash = |s: &Settings| of_settings(s, Some("blake3:00")).expect("finite");
        let plain = Settings::default();
        let mut other = plain.clone();
        other.prepare.simd = SimdTier::Scalar;
        other.goal.time = Some(3.0);
        other.prepare.effects.forced = EffectSet::all();
        assert_eq!(hash(&plain), hash(&other));
        other.pictures.denoise = Some(crate::settings::PathText("/opt/oidnDenoise".into()));
        assert_ne!(hash(&plain), hash(&other));
        let elsewhere = hash(&other);
        other.pictures.denoise = Some(crate::settings::PathText("oidnDenoise".into()));
        assert_eq!(hash(&other), elsewhere);
        other.pictures.denoise = None;
        assert_eq!(hash(&plain), hash(&other));
        other.render.seed = 1;
        assert_ne!(hash(&plain), hash(&other));
        let with = |path: &str| {
            let file = EnvironmentFile { path: path.into(), rotation_y_deg: 0.0, intensity: 1.0 };
            Settings { environment: EnvironmentSettings::File(file), ..Settings::default() }
        };
        assert_eq!(hash(&with("a.hdr")), hash(&with("b.hdr")));
        assert_ne!(hash(&with("a.hdr")), hash(&plain));
    }

    #[test]
    fn content_hash_follows_bytes_and_not_names() {
        let folder = tempfile::tempdir().expect("temporary folder");
        let file = |name: &str, bytes: &[u8]| {
            let path = folder.path().join(name);
            std::fs::write(&path, bytes).expect("write");
            path
        };
        let (a, b, c) = (file("a", b"one"), file("b", b"one"), file("c", b"two"));
        let control = Control::default();
        let paths = |files: &[&PathBuf]| files.iter().map(|f| (*f).clone()).collect::<Vec<_>>();
        let hash = |files: &[&PathBuf]| of_files(&paths(files), &control).expect("read");
        let read = |path: &PathBuf, bytes: &[u8]| FileRead { path: path.clone(), hash: blake3::hash(bytes).into() };
        assert_eq!(of_read(&[read(&a, b"one"), read(&c, b"two")]), hash(&[&a, &c]));
        assert_eq!(hash(&[&a, &c]), hash(&[&b, &c]));
        assert_ne!(hash(&[&a, &c]), hash(&[&a]));
        assert_ne!(hash(&[&a, &c]), hash(&[&c, &a]));
        control.stop();
        assert!(of_files(&paths(&[&a]), &control).is_err());
    }
}
