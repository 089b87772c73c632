//! What can be asked for: plain data that the command line, presets and the manifest share.

mod effects;
mod environment;
mod goal;
mod look;
pub mod path_text;
mod pictures;
mod views;

pub use effects::{Effect, EffectSet, EffectSettings};
pub use environment::{EnvironmentFile, EnvironmentSettings};
pub use goal::{Goal, Preset};
pub use look::LookSettings;
pub use path_text::PathText;
pub use pictures::{Background, BitDepth, Exposure, Layer, PictureFormat, PictureSettings, ToneMap};
pub use views::{CameraChoice, FixedView, UpChoice, ViewSettings};

use serde::{Deserialize, Serialize};

/// How the direct light at a path's vertex is estimated. All converge to the same picture.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, clap::ValueEnum)]
#[serde(rename_all = "lowercase")]
#[value(rename_all = "lowercase")]
pub enum Strategy {
    /// Uniform directions on the hemisphere, no light sampling but for punctual lights: the 2018 way.
    Hemisphere,
    /// Cosine-weighted directions, no light sampling but for punctual lights.
    Cosine,
    /// BSDF sampling, no light sampling but for punctual lights.
    Bsdf,
    /// Light sampling wherever light sampling can find the light; BSDF sampling for delta lobes.
    Light,
    /// Both, weighted by the power heuristic (multiple importance sampling).
    #[default]
    Mis,
}

/// Where random numbers come from.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, clap::ValueEnum)]
#[serde(rename_all = "lowercase")]
#[value(rename_all = "lowercase")]
pub enum SamplerKind {
    /// Owen-scrambled Sobol' points (Burley 2020), addressed.
    #[default]
    Sobol,
    /// The PCG hash (Jarzynski & Olano 2020), addressed: independent numbers.
    Pcg,
    /// A linear congruential generator per camera path, in sequence.
    Lcg,
    /// Marsaglia's xorshift32 per camera path, in sequence: the 2018 generator with its shifts mended.
    Xorshift32,
}

/// How light is computed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, clap::ValueEnum)]
#[serde(rename_all = "lowercase")]
#[value(rename_all = "lowercase")]
pub enum Integrator {
    /// Path tracing, unbiased: thousands of paths side by side.
    #[default]
    Path,
    /// The same paths one after the other: slower, and the same picture but for rounding.
    Plain,
    /// Whitted's ray tracing as in the course tracers of `.ray` scenes: no light but from lights, mirrors and glass.
    Whitted,
}

/// How the kd-tree is built.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, clap::ValueEnum)]
#[serde(rename_all = "lowercase")]
#[value(rename_all = "lowercase")]
pub enum KdTreeBuilder {
    /// The surface area heuristic, or random samples where so few rays are planned that a better tree does not pay.
    #[default]
    Auto,
    /// Splits at the spatial or object median of the longest axis.
    Median,
    /// Split planes from random samples of the primitives: the 2018 semi-randomised tree, reproducible.
    Sampled,
    /// The surface area heuristic.
    Sah,
}

/// Which pixels get more samples than others.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, clap::ValueEnum)]
#[serde(rename_all = "lowercase")]
#[value(rename_all = "lowercase")]
pub enum Adaptive {
    /// All get the same.
    Off,
    /// From the eighth sample on, those with more noise around them.
    #[default]
    Variance,
}

/// Whether pixels use each other's paths (Bekaert, Sbert & Halton 2002).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, clap::ValueEnum)]
#[serde(rename_all = "lowercase")]
#[value(rename_all = "lowercase")]
pub enum Reuse {
    /// Each pixel has its own paths: its noise is independent of all others'.
    #[default]
    Off,
    /// Sixteen pixels use each other's paths from the second surface on where that is diffuse: less noise in indirect light, and
    /// pixels four apart have noise in common. All pixels then get the same number of samples.
    On,
}

/// Whether part of the directions from diffuse surfaces are aimed at bodies of glass and metal (`lighting::casters`).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, clap::ValueEnum)]
#[serde(rename_all = "lowercase")]
#[value(rename_all = "lowercase")]
pub enum Caustics {
    /// Part of the paths are aimed at such bodies where lamps are small as seen from them (with `--strategy mis`): less noise in caustics.
    #[default]
    Aimed,
    /// Paths meet such bodies by chance, as the BSDF sends them.
    Met,
}

/// Whether triangles that several nodes draw are kept once, with one tree for all of them. Does not change pixels.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, clap::ValueEnum)]
#[serde(rename_all = "lowercase")]
#[value(rename_all = "lowercase")]
pub enum Instances {
    /// Where it saves much memory.
    #[default]
    Auto,
    /// Wherever it can be done.
    Always,
    /// Every node has triangles of its own.
    Never,
}

/// The instruction set of the hot loops. Every tier gives the same pixels.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, clap::ValueEnum)]
#[serde(rename_all = "lowercase")]
#[value(rename_all = "lowercase")]
pub enum SimdTier {
    /// The widest that the machine has.
    #[default]
    Auto,
    /// No explicit SIMD.
    Scalar,
    /// AVX2, 8 floats wide.
    Avx2,
    /// AVX-512, 16 floats wide.
    Avx512,
}

/// What a scene is prepared with.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct PrepareSettings {
    /// How the kd-tree is built.
    pub kdtree: KdTreeBuilder,
    /// Whether triangles that several nodes draw are kept once. Does not change pixels.
    pub instances: Instances,
    /// Every point light becomes a soft light of this radius (world units): the 2018 switch.
    pub point_lights: Option<f64>,
    /// `area_light`s become true sphere emitters instead of "point shading × visible fraction".
    pub physical_lights: bool,
    /// The instruction set that traversal may use. Does not change pixels.
    pub simd: SimdTier,
    /// Which effects are simulated.
    pub effects: EffectSettings,
    /// How many rays are to be traced, about, if that is known. Does not change pixels, and is no setting that anybody chooses:
    /// whoever plans the pictures fills it in.
    #[serde(skip)]
    pub planned_rays: Option<u64>,
}

/// What a picture is rendered with. Pixels depend on the scene, the view and this alone, and on the [`Goal`] in how many
/// samples there are.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct RenderSettings {
    /// Camera paths per pixel; with a [`Goal`], at most.
    pub spp: u32,
    /// Whether [`Self::spp`] is an average, and noise decides which pixels get more.
    pub adaptive: Adaptive,
    /// Selects the random numbers.
    pub seed: u64,
    /// Scattering events per path at most.
    pub max_depth: u32,
    /// How light is computed.
    pub integrator: Integrator,
    /// How direct light is estimated.
    pub strategy: Strategy,
    /// Light samples at each vertex of a path; `None`: two at the first one where they differ, since most noise is theirs there, and one at
    /// the others.
    pub light_samples: Option<u32>,
    /// Where random numbers come from.
    pub sampler: SamplerKind,
    /// Scattering events after which Russian roulette may end a path that carries less than a quarter, the survivors weighing more;
    /// [`u32::MAX`]: never.
    pub roulette_after: u32,
    /// How caustics are found.
    #[serde(default)]
    pub caustics: Caustics,
    /// Whether pixels use each other's paths.
    #[serde(default)]
    pub reuse: Reuse,
    /// Channels of a sample's radiance are cut off here, > 0; `None`: never. Takes away fireflies, and light with them.
    pub clamp: Option<f32>,
}

impl Default for RenderSettings {
    fn default() -> Self {
        Self {
            spp: 64,
            adaptive: Adaptive::default(),
            seed: 0,
            max_depth: 16,
            integrator: Integrator::default(),
            strategy: Strategy::default(),
            light_samples: None,
            sampler: SamplerKind::default(),
            roulette_after: 3,
            caustics: Caustics::default(),
            reuse: Reuse::default(),
            clamp: None,
        }
    }
}

impl RenderSettings {
    /// Whether pixels do use each other's paths: those that come one by one do not.
    pub fn shares(&self) -> bool {
        self.reuse == Reuse::On && self.integrator == Integrator::Path
    }

    /// Which pixels get more samples than others. None do where pixels use each other's paths (`shares`): which of them are there to be used at
    /// a sample would depend on how a film is cut into passes, and a film must not.
    pub fn allotted(&self, shares: bool) -> Adaptive {
        if shares { Adaptive::Off } else { self.adaptive }
    }
}

/// What [`RenderSettings::roulette_after`] is called by people: a number, or off.
pub fn roulette_after(text: &str) -> Option<u32> {
    if text == "off" { Some(u32::MAX) } else { text.parse().ok() }
}

/// Everything that decides what the pictures of an asset look like and what files they become.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Settings {
    /// Which of the asset's looks.
    pub look: LookSettings,
    /// Cameras and sizes.
    pub views: ViewSettings,
    /// Light beside the asset's own.
    pub environment: EnvironmentSettings,
    /// Preparation.
    pub prepare: PrepareSettings,
    /// Light transport.
    pub render: RenderSettings,
    /// When pictures are good enough.
    pub goal: Goal,
    /// From light to files.
    pub pictures: PictureSettings,
}
