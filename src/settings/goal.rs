use serde::{Deserialize, Serialize};

/// When a picture is good enough, before all of [`super::RenderSettings::spp`] samples are taken. What is met first
/// ends the render.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Goal {
    /// The upper 95 % bound of the RMS error as displayed (0–255 levels), > 0.
    pub error: Option<f64>,
    /// Wall seconds for a whole asset with all its views, from reading to writing, > 0.
    pub time: Option<f64>,
}

impl Goal {
    /// Camera paths per pixel at most where no number is asked for. A time ends every render; an error may never be met where light
    /// is found by chance, and a batch is not to wait for it all night.
    pub fn most_spp(&self) -> Option<u32> {
        match (self.error, self.time) {
            (_, Some(_)) => Some(65_536),
            (Some(_), None) => Some(4096),
            (None, None) => None,
        }
    }
}

/// Named goals.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, clap::ValueEnum)]
#[serde(rename_all = "lowercase")]
#[value(rename_all = "lowercase")]
pub enum Preset {
    /// A first look: error 8, at most 64 samples.
    Draft,
    /// Good for a thumbnail: error 4, at most 256 samples.
    Preview,
    /// Noise that can hardly be seen: error 1.5, at most 4096 samples.
    Final,
}

impl Preset {
    /// The goal, and the most camera paths per pixel.
    pub fn goal(self) -> (Goal, u32) {
        let (error, spp) = match self {
            Self::Draft => (8.0, 64),
            Self::Preview => (4.0, 256),
            Self::Final => (1.5, 4096),
        };
        (Goal { error: Some(error), time: None }, spp)
    }
}
