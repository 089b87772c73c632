//! Pictures without noise, by Open Image Denoise (<https://www.openimagedenoise.org>).
//!
//! Its program `oidnDenoise` is run, and not its library loaded: a crash in it costs a picture, and no foreign function is called.
//! What it makes of a picture looks better than it is known to be, so it comes beside the picture as it was rendered.

mod pfm;

use crate::film::{Picture, Surfaces};
use pfm::FloatMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

/// The program's name.
pub const PROGRAM: &str = "oidnDenoise";

/// A picture without noise.
#[derive(Clone, Debug, PartialEq)]
pub struct Denoised {
    /// It.
    pub picture: Picture,
    /// Name and version of what made it.
    pub by: String,
}

/// The denoiser.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Denoiser {
    program: PathBuf,
}

impl Denoiser {
    /// That of a program, which is looked for on the system's path when it is a plain name.
    pub fn new(program: &Path) -> Self {
        Self { program: program.to_path_buf() }
    }

    /// That it is there.
    ///
    /// # Errors
    /// A sentence with what can be done, when it is not there or does not run.
    pub fn check(&self) -> Result<(), String> {
        let why = match Command::new(&self.program).arg("-h").stdin(Stdio::null()).output() {
            // Its help ends with a code that says failure.
            Ok(output) if String::from_utf8_lossy(&output.stdout).contains("Open Image Denoise") => return Ok(()),
            Ok(output) => last_line(&output.stderr).unwrap_or_else(|| output.status.to_string()),
            Err(error) => error.to_string(),
        };
        Err(format!(
            "{} does not run ({why}): it is a part of Open Image Denoise 2 (openimagedenoise.org, or pyoidn/oidn/bin of the \
             Python package pyoidn); put it on the system's path, or say --denoise=PROGRAM",
            self.program.display()
        ))
    }

    /// Removes the noise of a picture, guided by the colours and normals of its surfaces, which have its size. The coverage stays
    /// as it is. The same bytes on the same kind of processor with the same version; not on all.
    ///
    /// # Errors
    /// A sentence, with what the program says.
    pub fn denoise(&self, picture: &Picture, surfaces: &Surfaces, threads: usize) -> Result<Denoised, String> {
        let (width, height) = (picture.width, picture.height);
        let folder = tempfile::tempdir().map_err(|e| format!("no temporary folder: {e}"))?;
        let write = |name: &str, pixels: Vec<[f32; 3]>| {
            let path = folder.path().join(name);
            let written = fs::write(&path, FloatMap { width, height, pixels }.encode());
            written.map(|()| path).map_err(|e| format!("{name} cannot be written for the denoiser: {e}"))
        };
        let color = write("color.pfm", picture.pixels.iter().map(|p| [p[0], p[1], p[2]]).collect())?;
        let albedo = write("albedo.pfm", surfaces.albedo.clone())?;
        let normal = write("normal.pfm", surfaces.normal.clone())?;
        let result = folder.path().join("result.pfm");
        let mut command = Command::new(&self.program);
        // One dash is what all versions know.
        for (flag, file) in [("-hdr", &color), ("-alb", &albedo), ("-nrm", &normal), ("-o", &result)] {
            command.arg(flag).arg(file);
        }
        // Other devices are as good, but not the same.
        command.args(["-d", "cpu", "--threads", &threads.to_string()]).stdin(Stdio::null());
        let output = command.output().map_err(|e| format!("{} cannot be started: {e}", self.program.display()))?;
        if !output.status.success() {
            let last = last_line(&output.stderr).unwrap_or_else(|| "it says nothing".into());
            return Err(format!("{} failed ({}): {last}", self.program.display(), output.status));
        }
        let bytes = fs::read(&result).map_err(|e| format!("the denoiser made no picture: {e}"))?;
        let map = FloatMap::decode(&bytes, width, height).map_err(|e| format!("what the denoiser made {e}"))?;
        let clean = |value: f32| if value.is_finite() { value.max(0.0) } else { 0.0 };
        let pixel = |([r, g, b], was): (&[f32; 3], &[f32; 4])| [clean(*r), clean(*g), clean(*b), was[3]];
        let pixels = map.pixels.iter().zip(&picture.pixels).map(pixel).collect();
        let by = name(&String::from_utf8_lossy(&output.stdout));
        Ok(Denoised { picture: Picture { width, height, pixels }, by })
    }
}

/// The last that a program complained about.
fn last_line(said: &[u8]) -> Option<String> {
    let said = String::from_utf8_lossy(said);
    said.lines().map(str::trim).rfind(|line| !line.is_empty()).map(str::to_owned)
}

/// The denoiser's name with the version that it tells of in `device=CPU, version=2.5.1, msec=7.5`.
fn name(said: &str) -> String {
    let version = said.split("version=").nth(1).and_then(|rest| rest.split([',', '\n', ' ']).next());
    version.map_or_else(|| "Open Image Denoise".into(), |version| format!("Open Image Denoise {version}"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_version_is_found() {
        assert_eq!(name("Initializing device\n  device=CPU, version=2.5.1, msec=7.5\n"), "Open Image Denoise 2.5.1");
        assert_eq!(name("Initializing device"), "Open Image Denoise");
    }

    #[test]
    fn a_program_that_is_not_there_is_named() {
        let message = Denoiser::new(Path::new("/there/is/no/denoiser")).check().expect_err("missing");
        assert!(message.contains("/there/is/no/denoiser") && message.contains("--denoise="), "{message}");
    }
}
