use super::exit::Fatal;
use super::looks::LookOptions;
use clap::{Args, value_parser};
use kiln::batch::ViewFile;
use kiln::denoise::Denoiser;
use kiln::settings::{
    Adaptive, Background, BitDepth, CameraChoice, Caustics, EffectSettings, EnvironmentSettings, Exposure, Goal,
    Instances, Integrator, KdTreeBuilder, Layer, LookSettings, PathText, PictureFormat, PictureSettings,
    PrepareSettings, Preset, RenderSettings, Reuse, SamplerKind, Settings, SimdTier, Strategy, ToneMap, UpChoice,
    ViewSettings,
};
use std::path::PathBuf;

/// What `render` and `batch` have in common.
#[derive(Args, Clone, Debug)]
pub struct SettingOptions {
    /// Width of the pictures in pixels [default: 256, or the view file's]
    #[arg(long, value_name = "N", value_parser = value_parser!(u32).range(1..=32768), help_heading = "Pictures")]
    width: Option<u32>,
    /// Height of the pictures in pixels [default: the width, or the view file's]
    #[arg(long, value_name = "N", value_parser = value_parser!(u32).range(1..=32768), help_heading = "Pictures")]
    height: Option<u32>,
    /// Tone mapping of PNG files
    #[arg(long, value_enum, default_value_t, help_heading = "Pictures")]
    tonemap: ToneMap,
    /// Exposure of PNG files in EV, or auto
    #[arg(long, value_name = "auto|EV", default_value = "0", allow_hyphen_values = true, help_heading = "Pictures")]
    exposure: Exposure,
    /// transparent, environment, or a colour as #rrggbb [default: transparent; environment with a --view that has one]
    #[arg(long, value_name = "WHAT", help_heading = "Pictures")]
    background: Option<Background>,
    /// Bits per channel of PNG files
    #[arg(long, value_enum, default_value_t, help_heading = "Pictures")]
    bits: BitDepth,
    /// Further layers of EXR files: what the first surfaces are; objects and materials as Cryptomatte
    #[arg(long, value_enum, value_delimiter = ',', value_name = "LAYER", help_heading = "Pictures")]
    layers: Vec<Layer>,
    /// A picture without noise beside each, by Open Image Denoise (docs/denoising.md): oidnDenoise, or that program's place
    #[arg(
        long,
        num_args = 0..=1,
        require_equals = true,
        default_missing_value = kiln::denoise::PROGRAM,
        value_name = "PROGRAM",
        help_heading = "Pictures"
    )]
    pub denoise: Option<PathBuf>,

    /// The asset's camera with this name or index, or auto [default: the asset's first, auto without one]
    #[arg(long, value_name = "NAME|auto", help_heading = "View and light", conflicts_with_all = ["view", "turntable"])]
    camera: Option<CameraChoice>,
    /// Camera, size, depth and environment from a JSON file
    #[arg(long, value_name = "FILE.json", help_heading = "View and light")]
    view: Option<PathBuf>,
    /// N auto-framed pictures around the asset
    #[arg(long, value_name = "N", value_parser = value_parser!(u32).range(1..=100_000), conflicts_with = "view", help_heading = "View and light")]
    turntable: Option<u32>,
    /// Which axis is up for auto-framing and turntables
    #[arg(long, value_enum, default_value_t, help_heading = "View and light")]
    up: UpChoice,
    /// Light: auto (studio for assets without light), none, studio, constant:R,G,B, or an equirectangular HDR or EXR file
    #[arg(long, value_name = "FILE|WORD", help_heading = "View and light")]
    env: Option<EnvironmentSettings>,

    #[command(flatten)]
    looks: LookOptions,
    /// The turntable plays the animation once, from --time-code on
    #[arg(long, requires = "turntable", help_heading = "Looks")]
    play: bool,

    /// Camera paths per pixel, at most [default: 64; with --error 4096, with --time 65536]
    #[arg(long, value_name = "N", value_parser = value_parser!(u32).range(1..=1 << 24), help_heading = "Quality")]
    spp: Option<u32>,
    /// Stop when the displayed picture is within E levels (of 255, RMS) of the converged one, with 95 % confidence
    #[arg(long, value_name = "E", value_parser = positive, help_heading = "Quality")]
    error: Option<f64>,
    /// Stop after so many seconds for the whole asset, reading and writing included; the picture counts as partial
    #[arg(long, value_name = "SECONDS", value_parser = positive, help_heading = "Quality")]
    time: Option<f64>,
    /// Error and samples at most by name; --error and --spp still count
    #[arg(long, value_enum, help_heading = "Quality")]
    preset: Option<Preset>,
    /// Cut off each channel of a sample's light here: fewer fireflies, but light is lost [default: never]
    #[arg(long, value_name = "RADIANCE", value_parser = positive, help_heading = "Quality")]
    clamp: Option<f64>,
    /// Selects the random numbers
    #[arg(long, value_name = "N", default_value_t = 0, help_heading = "Sampling")]
    seed: u64,
    /// Which pixels get more samples than others: with variance --spp is an average
    #[arg(long, value_enum, default_value_t, help_heading = "Quality")]
    adaptive: Adaptive,
    /// Scattering events per path at most [default: 16, or the view file's]
    #[arg(long, value_name = "N", help_heading = "Sampling")]
    max_depth: Option<u32>,
    /// How light is computed
    #[arg(long, value_enum, default_value_t, help_heading = "Sampling")]
    integrator: Integrator,
    /// How direct light is estimated
    #[arg(long, value_enum, default_value_t, help_heading = "Sampling")]
    strategy: Strategy,
    /// Light samples per path vertex [default: 2 at a path's first one, 1 at others]
    #[arg(long, value_name = "N", value_parser = value_parser!(u32).range(1..=4096), help_heading = "Sampling")]
    light_samples: Option<u32>,
    /// Where random numbers come from
    #[arg(long, value_enum, default_value_t, help_heading = "Sampling")]
    sampler: SamplerKind,
    /// Scattering events after which paths that carry little may end (Russian roulette, unbiased), or off
    #[arg(long, value_name = "N|off", default_value = "3", value_parser = roulette, help_heading = "Sampling")]
    roulette: u32,
    /// How light that glass and metal throw on diffuse surfaces is found
    #[arg(long, value_enum, default_value_t, help_heading = "Sampling")]
    caustics: Caustics,
    /// Whether pixels use each other's paths: less noise in indirect light, but pixels have noise in common; all get the same number of
    /// samples
    #[arg(long, value_enum, value_name = "on|off", default_value_t, help_heading = "Sampling")]
    reuse: Reuse,
    /// How the kd-tree is built
    #[arg(long, value_enum, default_value_t, help_heading = "Sampling")]
    kdtree: KdTreeBuilder,
    /// Whether triangles that several nodes draw are kept once; does not change the pictures
    #[arg(long, value_enum, default_value_t, help_heading = "Machine")]
    instances: Instances,
    /// Every point light becomes a soft light of this radius [1 unless given]
    #[arg(long, value_name = "RADIUS", num_args = 0..=1, default_missing_value = "1", value_parser = radius, help_heading = "Sampling")]
    point_lights: Option<f64>,
    /// Area lights of .ray files become true sphere emitters
    #[arg(long, help_heading = "Sampling")]
    physical_lights: bool,

    /// Effects: auto (what the scene calls for), all or +NAME,… (reckoned with at every hit: the same picture, slower), raw (nothing
    /// that the file says is rewritten), or -NAME,… without some: another picture. `kiln inspect --effects` names them
    #[arg(
        long,
        value_name = "auto|all|raw|±NAME,…",
        default_value = "auto",
        allow_hyphen_values = true,
        help_heading = "Sampling"
    )]
    effects: EffectSettings,

    /// Instruction set; does not change the pictures
    #[arg(long, value_enum, value_name = "TIER", default_value_t, help_heading = "Machine")]
    simd: SimdTier,
    /// Threads that render [default: one per core]
    #[arg(long, value_name = "N", value_parser = value_parser!(u16).range(1..=4096), help_heading = "Machine")]
    threads: Option<u16>,
    /// Files that assets refer to must lie below this folder [default: batch: the searched folder; render: the parent
    /// of the asset's folder]
    #[arg(long, value_name = "DIR", help_heading = "Machine")]
    pub root: Option<PathBuf>,

    /// Say nothing but errors
    #[arg(short, long, help_heading = "Messages", conflicts_with = "verbose")]
    pub quiet: bool,
    /// Say more: every warning
    #[arg(short, long, help_heading = "Messages")]
    pub verbose: bool,
    /// Print manifest lines (one JSON object per asset) on stdout
    #[arg(long, help_heading = "Messages")]
    pub json: bool,
}

/// A number greater than 0.
pub(super) fn positive(text: &str) -> Result<f64, String> {
    let number = text.parse::<f64>().ok().filter(|x| x.is_finite() && *x > 0.0);
    number.ok_or_else(|| format!("'{text}' is not a number greater than 0"))
}

/// Each once, in one order.
fn sorted<T: Ord>(mut list: Vec<T>) -> Vec<T> {
    list.sort_unstable();
    list.dedup();
    list
}

fn roulette(text: &str) -> Result<u32, String> {
    kiln::settings::roulette_after(text).ok_or_else(|| format!("'{text}' is neither a number nor off"))
}

fn radius(text: &str) -> Result<f64, String> {
    let radius = text.parse::<f64>().ok().filter(|r| r.is_finite() && *r > 0.0);
    radius.ok_or_else(|| format!("'{text}' is not a radius: a number greater than 0"))
}

impl SettingOptions {
    /// The settings asked for.
    ///
    /// # Errors
    /// When the view file cannot be read, or the denoiser is not there.
    pub fn settings(&self, mut formats: Vec<PictureFormat>) -> Result<Settings, Fatal> {
        if let Some(program) = &self.denoise {
            Denoiser::new(program).check().map_err(Fatal::failed)?;
        }
        if self.reuse == Reuse::On && self.integrator != Integrator::Path {
            return Err(Fatal::usage("--reuse on needs --integrator path: the others follow each path alone"));
        }
        let file = self.view.as_deref().map(ViewFile::read).transpose().map_err(Fatal::usage)?;
        let of_file = |get: fn(&ViewFile) -> Option<u32>| file.as_ref().and_then(get);
        let views = ViewSettings::default();
        let width = self.width.or_else(|| of_file(|f| f.size.0)).unwrap_or(views.width);
        let height = self.height.or_else(|| of_file(|f| f.size.1)).unwrap_or(width);
        let depth = match self.integrator {
            Integrator::Path | Integrator::Plain => RenderSettings::default().max_depth,
            // What the course's checker runs with.
            Integrator::Whitted => 5,
        };
        let (goal, spp) = self.goal();
        formats = sorted(formats);
        let environment = self.env.clone().or_else(|| file.as_ref().map(|f| f.environment.clone()));
        let background = self.background.or_else(|| file.as_ref().map(|f| f.background));
        Ok(Settings {
            look: LookSettings { play: self.play, ..self.looks.settings() },
            views: ViewSettings {
                width,
                height,
                camera: self.camera.clone().unwrap_or_default(),
                turntable: self.turntable,
                up: self.up,
                fixed: file.as_ref().map(|f| f.view),
            },
            environment: environment.unwrap_or_default(),
            prepare: PrepareSettings {
                kdtree: self.kdtree,
                instances: self.instances,
                point_lights: self.point_lights,
                physical_lights: self.physical_lights,
                simd: self.simd,
                effects: self.effects,
                ..PrepareSettings::default()
            },
            render: RenderSettings {
                spp,
                adaptive: self.adaptive,
                seed: self.seed,
                max_depth: self.max_depth.or_else(|| of_file(|f| f.max_depth)).unwrap_or(depth),
                integrator: self.integrator,
                strategy: self.strategy,
                light_samples: self.light_samples,
                sampler: self.sampler,
                roulette_after: self.roulette,
                caustics: self.caustics,
                reuse: self.reuse,
                clamp: self.clamp.map(|c| c as f32),
            },
            goal,
            pictures: PictureSettings {
                tonemap: self.tonemap,
                exposure: self.exposure,
                background: background.unwrap_or_default(),
                bits: self.bits,
                formats,
                layers: sorted(self.layers.clone()),
                denoise: self.denoise.clone().map(PathText),
            },
        })
    }

    /// When pictures are good enough, and the most camera paths per pixel.
    fn goal(&self) -> (Goal, u32) {
        let (preset, most) = self.preset.map(Preset::goal).unzip();
        let goal = Goal { error: self.error.or(preset.unwrap_or_default().error), time: self.time };
        (goal, self.spp.or(most).or(goal.most_spp()).unwrap_or(RenderSettings::default().spp))
    }

    /// Whether the pictures are turntables.
    pub fn is_turntable(&self) -> bool {
        self.turntable.is_some()
    }

    /// Threads that render, in all processes together.
    pub fn cores(&self) -> usize {
        let cores = || std::thread::available_parallelism().map_or(1, usize::from);
        self.threads.map_or_else(cores, usize::from)
    }

    /// Makes the rayon pool that all assets share and gives its number of threads.
    ///
    /// # Errors
    /// When threads cannot be made.
    pub fn start_threads(&self) -> Result<usize, Fatal> {
        start_threads(self.threads)
    }
}

/// Makes the rayon pool, with one thread per core unless told otherwise, and gives its number of threads.
///
/// # Errors
/// When threads cannot be made.
pub fn start_threads(threads: Option<u16>) -> Result<usize, Fatal> {
    let made = rayon::ThreadPoolBuilder::new().num_threads(threads.map_or(0, usize::from)).build_global();
    made.map_err(|e| Fatal::failed(format!("threads cannot be made: {e}")))?;
    Ok(rayon::current_num_threads())
}
