use serde::{Deserialize, Serialize};

/// Which camera takes the picture.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum CameraChoice {
    /// The asset's first camera when it has one, else auto-framed.
    #[default]
    Default,
    /// Auto-framed, whatever cameras the asset has.
    Auto,
    /// The asset's camera of this name, or with this index when none has the name.
    Named(String),
}

impl std::str::FromStr for CameraChoice {
    type Err = std::convert::Infallible;

    fn from_str(text: &str) -> Result<Self, Self::Err> {
        Ok(if text == "auto" { Self::Auto } else { Self::Named(text.into()) })
    }
}

/// Which world axis is up.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, clap::ValueEnum)]
#[serde(rename_all = "lowercase")]
#[value(rename_all = "lowercase")]
pub enum UpChoice {
    /// What the asset says, or its format's habit.
    #[default]
    Auto,
    /// +Y.
    Y,
    /// +Z.
    Z,
}

/// A perspective camera given in numbers, as in a `--view` file.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct FixedView {
    /// Row-major; the camera looks along its −Z, +Y is up in the picture. The last row is 0 0 0 1.
    pub camera_to_world: [[f64; 4]; 4],
    /// Vertical field of view, degrees.
    pub vfov_deg: f64,
}

/// Cameras and sizes of an asset's pictures.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ViewSettings {
    /// Width in pixels, ≥ 1.
    pub width: u32,
    /// Height in pixels, ≥ 1.
    pub height: u32,
    /// Which camera.
    pub camera: CameraChoice,
    /// A turntable of this many auto-framed views instead of one view; ≥ 1.
    pub turntable: Option<u32>,
    /// Which way is up for auto-framing and turntables.
    pub up: UpChoice,
    /// Instead of all these: a camera in numbers.
    pub fixed: Option<FixedView>,
}

impl Default for ViewSettings {
    fn default() -> Self {
        Self {
            width: 256,
            height: 256,
            camera: CameraChoice::default(),
            turntable: None,
            up: UpChoice::default(),
            fixed: None,
        }
    }
}
