use crate::settings::{SamplerKind, Strategy};
use glam::DVec3;
use kiln_formats::scene::{Camera, Projection};
use serde::Deserialize;
use std::path::{Path, PathBuf};

/// One check as its file says it.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Check {
    /// The file's name without its ending.
    #[serde(skip)]
    pub name: String,
    /// What is tried, in a line.
    pub title: String,
    /// The scene file; relative to the check's folder in the file, complete after [`load`].
    pub scene: PathBuf,
    /// Where the expected values come from.
    pub derivation: String,
    /// Set where the renderer is known to be wrong. It must then fail: a check that passes again loses the mark.
    pub known_failure: Option<KnownFailure>,
    /// The camera; the scene's first when left out.
    pub camera: Option<CameraSpec>,
    /// Light from infinitely far away; also what is seen behind the scene.
    #[serde(default)]
    pub environment: EnvironmentSpec,
    /// The picture and the light transport.
    #[serde(default)]
    pub render: RenderSpec,
    /// What must come out, at least one.
    pub expect: Vec<Expectation>,
}

/// An admitted fault.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct KnownFailure {
    /// The cause, in a sentence.
    pub reason: String,
    /// The strategies that fail; all of the check's when empty.
    #[serde(default)]
    pub strategies: Vec<Strategy>,
}

/// A camera without shear: perspective with `vfov_deg`, orthographic with `height`. Zero is legal for both: every
/// sample then follows the same ray, through `target`.
#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CameraSpec {
    /// Where it stands, world space.
    pub eye: [f64; 3],
    /// The point in the middle of the picture.
    pub target: [f64; 3],
    /// What is up in the picture; +Y when left out, +Z for cameras that look along Y.
    pub up: Option<[f64; 3]>,
    /// Vertical field of view, degrees.
    pub vfov_deg: Option<f64>,
    /// Height of an orthographic picture, world units.
    pub height: Option<f64>,
}

/// A light from infinitely far away: at most one of the fields.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct EnvironmentSpec {
    /// The same radiance from everywhere.
    pub constant: Option<Level>,
    /// Texels of an equirectangular picture, rows from the top; (0, 1, 0) is up, the middle column is at +X and
    /// columns go on towards +Z.
    pub rows: Option<Vec<Vec<[f32; 3]>>>,
}

/// The picture and the light transport.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct RenderSpec {
    /// Width in pixels.
    pub width: u32,
    /// Height in pixels.
    pub height: u32,
    /// Camera paths a pixel.
    pub spp: u32,
    /// Scattering events a path at most.
    pub max_depth: u32,
    /// Light samples a vertex; without it, as many as renders take.
    pub light_samples: Option<u32>,
    /// Every one of these must give what is expected.
    pub strategies: Vec<Strategy>,
    /// Where random numbers come from.
    pub sampler: SamplerKind,
    /// Selects the random numbers.
    pub seed: u64,
}

impl Default for RenderSpec {
    fn default() -> Self {
        use Strategy::{Bsdf, Cosine, Hemisphere, Light, Mis};
        Self {
            width: 8,
            height: 8,
            spp: 64,
            max_depth: 16,
            light_samples: None,
            strategies: vec![Hemisphere, Cosine, Bsdf, Light, Mis],
            sampler: SamplerKind::default(),
            seed: 0,
        }
    }
}

/// A radiance, grey or RGB.
#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(untagged)]
pub enum Level {
    /// The same in all channels.
    Grey(f64),
    /// Linear RGB.
    Rgb([f64; 3]),
}

impl Level {
    /// As three channels.
    pub fn rgb(self) -> [f64; 3] {
        match self {
            Self::Grey(grey) => [grey; 3],
            Self::Rgb(rgb) => rgb,
        }
    }
}

/// How what is got must lie to what is expected.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Relation {
    /// At it.
    #[default]
    Equal,
    /// Not above it.
    AtMost,
    /// Not below it.
    AtLeast,
}

/// A value to expect of a part of the picture.
#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Expectation {
    /// Radiance.
    pub value: Level,
    /// Pixels x0 ≤ x < x1, y0 ≤ y < y1 as [x0, y0, x1, y1], y from the top; the whole picture when left out.
    pub region: Option<[u32; 4]>,
    /// Equal, at most or at least.
    #[serde(default)]
    pub relation: Relation,
    /// Systematic deviation that the derivation allows for, absolute.
    #[serde(default)]
    pub absolute: f64,
    /// The same, relative to the value. What is left out stands for the rounding of a path's products in f32.
    #[serde(default = "rounding")]
    pub relative: f64,
    /// Every pixel is compared by itself and no noise is granted: for values that all samples must have.
    #[serde(default)]
    pub each_pixel: bool,
    /// A mean whose standard error exceeds this share of the value proves nothing, and fails.
    #[serde(default = "resolution")]
    pub resolution: f64,
}

fn rounding() -> f64 {
    1e-5
}

fn resolution() -> f64 {
    0.01
}

/// Reads every `.toml` file of a folder, by name.
///
/// # Errors
/// A sentence that names the folder or the file.
pub fn load(folder: &Path) -> Result<Vec<Check>, String> {
    let in_folder = |e: std::io::Error| format!("the folder of checks {} cannot be read: {e}", folder.display());
    let mut files = Vec::new();
    for entry in std::fs::read_dir(folder).map_err(in_folder)? {
        let path = entry.map_err(in_folder)?.path();
        if path.extension().is_some_and(|e| e == "toml") {
            files.push(path);
        }
    }
    files.sort();
    if files.is_empty() {
        return Err(format!("there is no check (.toml) in {}", folder.display()));
    }
    files.iter().map(|path| read(path)).collect()
}

fn read(path: &Path) -> Result<Check, String> {
    let in_file = |message: String| format!("{}: {message}", path.display());
    let text = std::fs::read_to_string(path).map_err(|e| in_file(format!("cannot be read: {e}")))?;
    let mut check = parse(&text).map_err(in_file)?;
    check.name = path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
    check.scene = path.parent().unwrap_or(Path::new("")).join(&check.scene);
    Ok(check)
}

/// Pixels of a picture and samples of a pixel at most: a check is small.
const MOST: u32 = 1 << 16;

fn parse(text: &str) -> Result<Check, String> {
    let check: Check = toml::from_str(text).map_err(|e| e.to_string())?;
    let RenderSpec { width, height, spp, .. } = check.render;
    let sizes = 1..=256;
    if !sizes.contains(&width) || !sizes.contains(&height) || !(2..=MOST).contains(&spp) {
        return Err(format!("{width}×{height} pixels and {spp} samples: 1 to 256 and 2 to {MOST} are possible"));
    }
    if check.render.strategies.is_empty() || check.expect.is_empty() {
        return Err("nothing is expected: strategies or expect is empty".into());
    }
    for e in &check.expect {
        let [x0, y0, x1, y1] = e.region.unwrap_or([0, 0, width, height]);
        if x0 >= x1 || y0 >= y1 || x1 > width || y1 > height {
            return Err(format!("the region {:?} holds no pixel of the picture", [x0, y0, x1, y1]));
        }
        let numbers = [e.absolute, e.relative, e.resolution];
        if !numbers.iter().chain(&e.value.rgb()).all(|x| x.is_finite() && *x >= 0.0) {
            return Err("a value or tolerance is negative or not finite".into());
        }
    }
    if let Some(rows) = &check.environment.rows {
        let width = rows.first().map_or(0, Vec::len);
        if width == 0 || rows.iter().any(|row| row.len() != width) || check.environment.constant.is_some() {
            return Err("the environment's rows must be of one length, and exclude a constant".into());
        }
    }
    if let Some(camera) = check.camera {
        camera.camera(f64::from(width) / f64::from(height))?;
    }
    Ok(check)
}

impl CameraSpec {
    /// The camera for a picture of this aspect ratio (width / height).
    ///
    /// # Errors
    /// A sentence, when it is none.
    pub fn camera(&self, aspect: f64) -> Result<Camera, String> {
        let origin = DVec3::from(self.eye);
        let forward = (DVec3::from(self.target) - origin).try_normalize().ok_or("the camera's eye is its target")?;
        let up = self.up.map_or(if forward.y.abs() > 0.99 { DVec3::Z } else { DVec3::Y }, DVec3::from);
        let right = forward.cross(up).try_normalize().ok_or("the camera looks along its up")?;
        let (projection, half) = match (self.vfov_deg, self.height) {
            (Some(angle), None) if (0.0..180.0).contains(&angle) => {
                (Projection::Perspective, libm::tan(0.5 * angle.to_radians()))
            }
            (None, Some(height)) if height >= 0.0 => (Projection::Orthographic, 0.5 * height),
            _ => return Err("a camera has either vfov_deg in [0, 180) or height ≥ 0".into()),
        };
        Ok(Camera {
            name: String::new(),
            projection,
            origin,
            forward,
            right: right * (half * aspect),
            up: right.cross(forward) * half,
            aspect: None,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const HEAD: &str = "title = 't'\nscene = 's.obj'\nderivation = 'd'\n";

    #[test]
    fn a_short_check_is_filled_with_defaults() {
        let check = parse(&format!("{HEAD}[[expect]]\nvalue = 0.5\n")).expect("sound");
        assert_eq!((check.render.strategies.len(), check.render.spp, check.camera.is_none()), (5, 64, true));
        assert_eq!((check.expect[0].value.rgb(), check.expect[0].relation), ([0.5; 3], Relation::Equal));
    }

    #[test]
    fn what_is_wrong_is_named() {
        let error = |rest: &str| parse(&format!("{HEAD}{rest}")).expect_err(rest);
        assert!(error("").contains("expect"));
        assert!(error("[[expect]]\nvalue = 1\ntolerance = 0.1").contains("tolerance"), "unknown fields");
        assert!(error("[[expect]]\nvalue = -1.0").contains("negative"));
        assert!(error("[[expect]]\nvalue = 1.0\nregion = [0, 0, 9, 1]").contains("region"));
        assert!(error("[render]\nspp = 1\n[[expect]]\nvalue = 1.0").contains("samples"));
        let camera = "[camera]\neye = [0, 0, 1]\ntarget = [0, 0, 0]\n[[expect]]\nvalue = 1.0";
        assert!(error(camera).contains("vfov_deg"));
    }
}
