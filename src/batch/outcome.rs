use super::Job;
use crate::integrate::{Cause, Dropped, DroppedSample, RayCounts};
use crate::settings::{PathText, PictureFormat};
use kiln_formats::Warning;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// Places of dropped samples that are kept.
const PLACES: usize = 8;

/// How an asset fared.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Status {
    /// Every picture is there.
    Ok,
    /// Every picture is there, but something in the asset was mended or left out.
    Warned,
    /// Stopped before every picture was there, or before it was as good as asked for.
    Partial,
    /// No picture, or not all, for the reason in the message.
    Failed,
    /// Not begun, or stopped before the first picture.
    Skipped,
}

impl Status {
    /// One word, as in the manifest.
    pub fn word(self) -> &'static str {
        match self {
            Self::Ok => "ok",
            Self::Warned => "warned",
            Self::Partial => "partial",
            Self::Failed => "failed",
            Self::Skipped => "skipped",
        }
    }

    /// Whether every picture asked for is there.
    pub fn is_done(self) -> bool {
        matches!(self, Self::Ok | Self::Warned)
    }
}

/// One picture file.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct OutputRecord {
    /// Path below the output folder, with `/`.
    pub path: String,
    /// Its format.
    pub format: PictureFormat,
    /// Size of the file in bytes.
    #[serde(default)]
    pub bytes: u64,
    /// Which of the asset's views, from 0.
    pub view: u32,
    /// Width in pixels.
    pub width: u32,
    /// Height in pixels.
    pub height: u32,
    /// Camera paths per pixel.
    pub spp: u32,
    /// Camera paths.
    pub samples: u64,
    /// Exposure of the displayed picture, EV.
    pub exposure: f64,
    /// RMS error as displayed (0–255); `None`: not measured.
    pub error: Option<f64>,
    /// Upper 95 % bound of it; `None`: not measured.
    pub error_bound: Option<f64>,
    /// Relative mean square error in linear light; `None`: not measured.
    pub relmse: Option<f64>,
    /// Upper 95 % bound of it; `None`: not measured.
    pub relmse_bound: Option<f64>,
    /// Whether the error asked for was reached; `None`: none was asked for.
    pub target_met: Option<bool>,
    /// What was asked for that changes the expected picture, and by how much.
    pub bias: Vec<String>,
    /// Whether pixels used each other's paths (`--reuse`): those of a group of sixteen, four apart, have noise in common.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub reuse: bool,
    /// Name and version of what removed the noise: of a PNG file as a whole, so that its error is not known; of an EXR file in its
    /// layers `denoised.R`, `.G` and `.B` alone. `None`: nothing did.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub denoised: Option<String>,
}

/// What is in the scene.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct SceneFacts {
    /// Triangles drawn, counted once per instance.
    pub triangles: u64,
    /// Placements of meshes.
    pub instances: u64,
    /// Emissive triangles, punctual lights and environments; 0 until prepared.
    pub emitters: u64,
    /// Effects that the scene calls for.
    pub effects: Vec<String>,
}

/// Seconds by stage.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct StageSeconds {
    /// Reading files and geometry; images of glTF files stay encoded.
    pub import: f64,
    /// Preparation without the kd-tree: decoding images, tangents, lights, smaller versions of textures.
    pub prepare: f64,
    /// Building the kd-tree.
    pub kdtree: f64,
    /// Light transport, metering included.
    pub render: f64,
    /// Tone mapping, encoding and writing.
    pub write: f64,
    /// From beginning to end (wall), or the sum of the stages (CPU).
    pub total: f64,
}

/// The bounds that an asset was held to and failed at, where they were asked for.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct LimitRecord {
    /// Bytes of memory.
    pub memory: Option<u64>,
    /// Wall seconds until it was killed.
    pub timeout: Option<f64>,
    /// Triangles drawn.
    pub max_triangles: u64,
    /// Texels of all images together.
    pub max_texels: u64,
}

/// Rays traced.
pub type Rays = RayCounts;

/// Where a sample was dropped because it was not finite; with the record's seed that is the path's address.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct DroppedRecord {
    /// Which of the asset's views, from 0.
    pub view: u32,
    /// Its pixel, sample and cause.
    #[serde(flatten)]
    pub sample: DroppedSample,
}

/// What became of a job: one line of the manifest.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Outcome {
    /// Version of Kiln.
    pub kiln: String,
    /// The asset: [`super::Job::name`].
    pub input: String,
    /// `blake3:` and the hash of all files read; `None` when the asset could not be read.
    pub content: Option<String>,
    /// The files behind `content`, the asset first, the others as seen from its folder.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub files: Vec<PathText>,
    /// Files that it refers to and that are not there.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub missing: Vec<PathText>,
    /// `blake3:` and the hash of the settings that pixels depend on.
    pub settings: Option<String>,
    /// Wall seconds that it was allowed ([`crate::settings::Goal::time`]).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub time: Option<f64>,
    /// The limits, where it failed at one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub limits: Option<LimitRecord>,
    /// Selects the random numbers.
    pub seed: u64,
    /// How it fared.
    pub status: Status,
    /// Stable word for why it did not.
    pub error_code: Option<String>,
    /// Why it did not, in a sentence with its place.
    pub error_message: Option<String>,
    /// What it is lit by: `own`, `studio`, `own + studio`, `constant`, `none`, or the file of the environment.
    pub light: Option<String>,
    /// The pictures that are there.
    pub outputs: Vec<OutputRecord>,
    /// What was mended or left out.
    pub warnings: Vec<Warning>,
    /// What is in the scene; `None` when the asset could not be read.
    pub scene: Option<SceneFacts>,
    /// Wall seconds.
    pub seconds: StageSeconds,
    /// CPU seconds over all threads that worked for this asset.
    pub cpu_seconds: StageSeconds,
    /// Rays traced.
    pub rays: Rays,
    /// Samples dropped because they were not finite.
    pub nonfinite: u64,
    /// How many of them for which cause.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub nonfinite_causes: BTreeMap<Cause, u64>,
    /// The first of them that are in pictures (not in what measures the exposure), for `--replay`.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub nonfinite_first: Vec<DroppedRecord>,
    /// Most memory that the process has held while it was at this asset (since it began, without worker processes);
    /// `None` where the system does not tell.
    pub peak_bytes: Option<u64>,
}

impl Outcome {
    /// Of a job that has not begun.
    pub fn skipped(name: &str, seed: u64) -> Self {
        Self {
            kiln: env!("CARGO_PKG_VERSION").into(),
            input: name.into(),
            content: None,
            files: Vec::new(),
            missing: Vec::new(),
            settings: None,
            time: None,
            limits: None,
            seed,
            status: Status::Skipped,
            error_code: None,
            error_message: None,
            light: None,
            outputs: Vec::new(),
            warnings: Vec::new(),
            scene: None,
            seconds: StageSeconds::default(),
            cpu_seconds: StageSeconds::default(),
            rays: Rays::default(),
            nonfinite: 0,
            nonfinite_causes: BTreeMap::new(),
            nonfinite_first: Vec::new(),
            peak_bytes: None,
        }
    }

    /// Of a job that is about to begin.
    pub fn of(job: &Job) -> Self {
        Self { time: job.settings.goal.time, ..Self::skipped(&job.name, job.settings.render.seed) }
    }

    /// Counts dropped samples, of this view's picture where they are in one.
    pub fn count_dropped(&mut self, dropped: &Dropped, view: Option<u32>) {
        self.nonfinite += dropped.count();
        for (cause, count) in dropped.by_cause() {
            *self.nonfinite_causes.entry(cause).or_default() += count;
        }
        let records =
            view.into_iter().flat_map(|view| dropped.first().map(move |sample| DroppedRecord { view, sample }));
        let room = PLACES - self.nonfinite_first.len().min(PLACES);
        self.nonfinite_first.extend(records.take(room));
    }

    /// The manifest line, without a line end.
    ///
    /// # Errors
    /// Only should a number not be finite, which JSON cannot say.
    pub fn to_line(&self) -> serde_json::Result<String> {
        serde_json::to_string(self)
    }
}
