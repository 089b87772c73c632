use crate::settings::{Background, EnvironmentFile, EnvironmentSettings, FixedView};
use serde::Deserialize;
use std::path::{Path, PathBuf};

/// A camera, a size and a light in a JSON file, so that others can compare their pictures with ours.
///
/// `camera_to_world` (row-major 4×4, looks along −Z), `vfov_deg`, and optionally `width`, `height`, `max_scatter`
/// (scattering events per path) and `environment`: `{"type": "constant", "radiance": [r, g, b]}` or `{"type": "hdr",
/// "file": …, "rotation_y_deg": …, "intensity": …}` with the file relative to the JSON's folder. An environment is shown
/// behind the asset. A file without `environment`, or with `null`, has none. Other fields are ignored.
#[derive(Clone, Debug, PartialEq)]
pub struct ViewFile {
    /// The camera.
    pub view: FixedView,
    /// Width and height in pixels.
    pub size: (Option<u32>, Option<u32>),
    /// Scattering events per path at most.
    pub max_depth: Option<u32>,
    /// The light.
    pub environment: EnvironmentSettings,
    /// What is behind the asset.
    pub background: Background,
}

#[derive(Deserialize)]
struct Raw {
    camera_to_world: [[f64; 4]; 4],
    vfov_deg: f64,
    width: Option<u32>,
    height: Option<u32>,
    max_scatter: Option<u32>,
    environment: Option<RawEnvironment>,
}

#[derive(Deserialize)]
#[serde(tag = "type", rename_all = "lowercase")]
enum RawEnvironment {
    Constant {
        radiance: [f32; 3],
    },
    Hdr {
        file: PathBuf,
        #[serde(default)]
        rotation_y_deg: f64,
        #[serde(default = "one")]
        intensity: f64,
    },
}

fn one() -> f64 {
    1.0
}

impl ViewFile {
    /// Reads a view file.
    ///
    /// # Errors
    /// A sentence with the file's name and the line.
    pub fn read(path: &Path) -> Result<Self, String> {
        let text = std::fs::read_to_string(path).map_err(|e| format!("{}: cannot be read: {e}", path.display()))?;
        Self::parse(&text, path.parent().unwrap_or(Path::new(""))).map_err(|e| format!("{}: {e}", path.display()))
    }

    fn parse(text: &str, folder: &Path) -> Result<Self, String> {
        let raw: Raw = serde_json::from_str(text).map_err(|e| format!("is no view: {e}"))?;
        if raw.width == Some(0) || raw.height == Some(0) {
            return Err("width and height must be at least 1".into());
        }
        let (environment, background) = match raw.environment {
            None => (EnvironmentSettings::None, Background::Transparent),
            Some(RawEnvironment::Constant { radiance }) => {
                if !radiance.iter().all(|r| r.is_finite() && *r >= 0.0) {
                    return Err("the environment's radiance is negative or not finite".into());
                }
                (EnvironmentSettings::Constant(radiance), Background::Environment)
            }
            Some(RawEnvironment::Hdr { file, rotation_y_deg, intensity }) => {
                if !(intensity.is_finite() && intensity >= 0.0) {
                    return Err("the environment's intensity is negative or not finite".into());
                }
                let file = EnvironmentFile { path: folder.join(file), rotation_y_deg, intensity };
                (EnvironmentSettings::File(file), Background::Environment)
            }
        };
        Ok(Self {
            view: FixedView { camera_to_world: raw.camera_to_world, vfov_deg: raw.vfov_deg },
            size: (raw.width, raw.height),
            max_depth: raw.max_scatter,
            environment,
            background,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const CAMERA: &str = r#""camera_to_world": [[1,0,0,0],[0,1,0,0],[0,0,1,4],[0,0,0,1]], "vfov_deg": 40.0"#;

    #[test]
    fn environments_are_relative_to_the_file_and_shown() {
        let text = format!(
            r#"{{{CAMERA}, "width": 320, "max_scatter": 8, "note": "ignored",
                "environment": {{"type": "hdr", "file": "../env/a.hdr", "rotation_y_deg": 90, "intensity": 4.0}}}}"#
        );
        let view = ViewFile::parse(&text, Path::new("scenes")).expect("sound");
        assert_eq!((view.size, view.max_depth), ((Some(320), None), Some(8)));
        let file = EnvironmentFile { path: "scenes/../env/a.hdr".into(), rotation_y_deg: 90.0, intensity: 4.0 };
        assert_eq!(view.environment, EnvironmentSettings::File(file));
        assert_eq!(view.background, Background::Environment);
        let dark = ViewFile::parse(&format!(r#"{{{CAMERA}, "environment": null}}"#), Path::new("")).expect("sound");
        assert_eq!((dark.environment, dark.background), (EnvironmentSettings::None, Background::Transparent));
        let white = format!(r#"{{{CAMERA}, "environment": {{"type": "constant", "radiance": [1, 1, 1]}}}}"#);
        let white = ViewFile::parse(&white, Path::new("")).expect("sound");
        assert_eq!(white.environment, EnvironmentSettings::Constant([1.0; 3]));
    }

    #[test]
    fn what_is_missing_or_wrong_is_named() {
        let error = |text: &str| ViewFile::parse(text, Path::new("")).expect_err(text);
        assert!(error("{}").contains("camera_to_world"));
        assert!(error(&format!(r#"{{{CAMERA}, "width": 0}}"#)).contains("width"));
        assert!(error(&format!(r#"{{{CAMERA}, "environment": {{"type": "sun"}}}}"#)).contains("sun"));
        assert!(error("[").contains("line 1"));
    }
}
