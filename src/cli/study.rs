use super::batch::environment;
use super::console::{Console, print_line};
use super::exit::{Exit, Fatal};
use super::interrupt::Interrupt;
use clap::{Args, value_parser};
use indicatif::{HumanDuration, ProgressBar, ProgressStyle};
use kiln::Control;
use kiln::batch::{Job, Output, ViewFile};
use kiln::effects::{called_for, normalise};
use kiln::formats::{ImportOptions, Limits, import};
use kiln::lab::{Cell, Observer, Progress, Store, Study, WAYS, effect_ways, publish, run, ways};
use kiln::settings::{CameraChoice, Effect, EnvironmentSettings, Exposure, Settings, ToneMap, ViewSettings};
use std::collections::BTreeSet;
use std::fmt::Write;
use std::path::PathBuf;
use std::time::Duration;

const EXAMPLES: &str = "\
Examples:
  kiln study scenes/samples/cornell_box.glb --out out/study
  kiln study chair.glb table.glb --out study --budget 600 --width 256
  kiln study chair.glb --out study --ways kiln,trees --seeds 4
  kiln study chair.glb --out study --effects
  kiln study chair.glb --out study --ways kiln --way 'mine: light-samples=3 sampler=pcg'

Open DIR/report.html in a browser. Beside it: study.json, cells.csv, plots (SVG and PNG), strips of pictures, and the
references (EXR). A study that was interrupted goes on where it was when it is asked for again; with a larger --budget it
goes further.";

/// `kiln study`.
#[derive(Args)]
#[command(after_help = EXAMPLES, after_long_help = long_help())]
pub struct StudyCommand {
    /// .gltf, .glb, .obj or .ray files
    #[arg(required = true, value_name = "ASSET")]
    assets: Vec<PathBuf>,
    /// Folder for the report and all that belongs to it
    #[arg(short, long, value_name = "DIR")]
    out: PathBuf,

    /// Ways to compare: names and groups (strategies, samplers, trees, depth, lights, roulette, adaptive, caustics, reuse, presets), usual, all; --help lists them
    ///
    /// [default: usual; with --effects: kiln]
    #[arg(long, value_name = "LIST", help_heading = "Study")]
    ways: Option<String>,
    /// Price the effects that the assets call for: without each of them, and with all of them reckoned with at every hit
    #[arg(long, help_heading = "Study")]
    effects: bool,
    /// A way of your own: NAME: KEY=VALUE … with strategy, sampler, kdtree, max-depth, light-samples, roulette, adaptive, caustics, reuse, effects, denoise, preset (may be repeated)
    #[arg(long, value_name = "WAY", help_heading = "Study")]
    way: Vec<String>,
    /// Seconds for each asset, about, on a machine that does nothing else
    #[arg(long, value_name = "SECONDS", default_value_t = 40.0, value_parser = positive, help_heading = "Study")]
    budget: f64,
    /// Seeds for each way
    #[arg(long, value_name = "N", default_value_t = 2, value_parser = value_parser!(u32).range(1..=1000), help_heading = "Study")]
    seeds: u32,
    /// The first seed
    #[arg(long, value_name = "N", default_value_t = 0, help_heading = "Study")]
    seed: u64,
    /// Samples per pixel to try at most; they double from 1
    #[arg(long, value_name = "N", default_value_t = 4096, value_parser = value_parser!(u32).range(1..=1 << 20), help_heading = "Study")]
    spp: u32,
    /// Samples per pixel of the references [default: what a third of the budget allows]
    #[arg(long, value_name = "N", value_parser = value_parser!(u32).range(4..=1 << 20), help_heading = "Study")]
    reference_spp: Option<u32>,

    /// Width of the pictures in pixels [default: 128, or the view file's]
    #[arg(long, value_name = "N", value_parser = value_parser!(u32).range(1..=4096), help_heading = "Pictures")]
    width: Option<u32>,
    /// Height of the pictures in pixels [default: the width, or the view file's]
    #[arg(long, value_name = "N", value_parser = value_parser!(u32).range(1..=4096), help_heading = "Pictures")]
    height: Option<u32>,
    /// The assets' camera with this name or index, or auto
    #[arg(long, value_name = "NAME|auto", conflicts_with = "view", help_heading = "Pictures")]
    camera: Option<CameraChoice>,
    /// Camera, size, depth and environment from a JSON file
    #[arg(long, value_name = "FILE.json", help_heading = "Pictures")]
    view: Option<PathBuf>,
    /// Light: auto, none, studio, constant:R,G,B, or an equirectangular HDR or EXR file
    #[arg(long, value_name = "FILE|WORD", help_heading = "Pictures")]
    env: Option<EnvironmentSettings>,
    /// Tone mapping
    #[arg(long, value_enum, default_value_t, help_heading = "Pictures")]
    tonemap: ToneMap,
    /// Exposure in EV, or auto
    #[arg(long, value_name = "auto|EV", default_value = "0", allow_hyphen_values = true, help_heading = "Pictures")]
    exposure: Exposure,
    /// Scattering events per path at most [default: 16, or the view file's]
    #[arg(long, value_name = "N", help_heading = "Pictures")]
    max_depth: Option<u32>,
    /// Every point light becomes a soft light of this radius
    #[arg(long, value_name = "RADIUS", value_parser = positive, help_heading = "Pictures")]
    point_lights: Option<f64>,

    /// Threads that render [default: one per core]
    #[arg(long, value_name = "N", value_parser = value_parser!(u16).range(1..=4096), help_heading = "Machine")]
    threads: Option<u16>,
    /// Files that assets refer to must lie below this folder [default: the parent of the asset's folder]
    #[arg(long, value_name = "DIR", help_heading = "Machine")]
    root: Option<PathBuf>,
    /// Say nothing but errors
    #[arg(short, long, help_heading = "Messages")]
    quiet: bool,
    /// Print study.json on stdout
    #[arg(long, help_heading = "Messages")]
    json: bool,
}

fn positive(text: &str) -> Result<f64, String> {
    let number = text.parse::<f64>().ok().filter(|n| n.is_finite() && *n > 0.0);
    number.ok_or_else(|| format!("'{text}' is not a number greater than 0"))
}

fn long_help() -> String {
    let mut text = format!("{EXAMPLES}\n\nWays:\n");
    for (name, group, title, _) in WAYS {
        // Writing to a string does not fail.
        let _ = writeln!(text, "  {name:11} {group:11} {title}");
    }
    text
}

impl StudyCommand {
    /// Does it.
    ///
    /// # Errors
    /// When nothing can be begun, or results cannot be written.
    pub fn run(self) -> Result<Exit, Fatal> {
        let list = self.ways.as_deref().unwrap_or(if self.effects { "kiln" } else { "usual" });
        let mut ways = ways(list, &self.way).map_err(Fatal::usage)?;
        let settings = self.settings()?;
        let environment = environment(&settings)?;
        super::options::start_threads(self.threads)?;
        if self.effects {
            ways.extend(effect_ways(self.called()));
        }
        let output = Output { folder: self.out.clone(), stem: PathBuf::new(), ending: None };
        let job = |asset: &PathBuf| Job {
            input: asset.clone(),
            name: asset.file_name().unwrap_or_default().to_string_lossy().into_owned(),
            root: self.root.clone(),
            limits: Limits::default(),
            output: output.clone(),
            settings: settings.clone(),
        };
        let jobs: Vec<Job> = self.assets.iter().map(job).collect();
        let ladder: Vec<u32> = (0..=20).map(|k| 1 << k).filter(|n| *n <= self.spp).collect();
        let study = Study {
            jobs: &jobs,
            ways: &ways,
            ladder: &ladder,
            seeds: self.seeds,
            budget: self.budget,
            reference_spp: self.reference_spp,
            environment,
        };
        let unwritable =
            |e: std::io::Error| Fatal::failed(format!("{}: cannot be written to: {e}", self.out.display()));
        let mut store = Store::open(&self.out).map_err(unwritable)?;
        let control = Control::default();
        let interrupt = Interrupt::watch(&control);
        let watcher = Watcher::new(Console::new(self.quiet, false), self.budget * jobs.len() as f64);
        let studied = run(&study, &mut store, &control, &watcher).map_err(Fatal::failed)?;
        watcher.end();
        let verdicts = publish(&study, &studied, &self.out).map_err(Fatal::failed)?;
        if self.json {
            let path = self.out.join("study.json");
            print_line(&std::fs::read_to_string(path).map_err(unwritable)?);
        } else if !self.quiet {
            verdicts.iter().for_each(|(asset, text)| print_line(&format!("{asset}: {text}")));
            print_line(&self.out.join("report.html").display().to_string());
        }
        let failed = studied.subjects.iter().filter(|s| s.reference.is_none()).count();
        Ok(match failed {
            _ if interrupt.happened() => Exit::Interrupted,
            0 => Exit::Done,
            n if n == jobs.len() => Exit::Failed,
            _ => Exit::Partial,
        })
    }

    /// The effects that any of the assets calls for; of those that cannot be read the study tells itself.
    fn called(&self) -> Vec<Effect> {
        let mut called = BTreeSet::new();
        for asset in &self.assets {
            let options = ImportOptions { root: self.root.clone(), ..ImportOptions::default() };
            let Ok(imported) = import(asset, &options, &Control::default()) else { continue };
            let mut scene = imported.scene;
            normalise(&mut scene);
            let drawn = vec![1.0; scene.meshes.len()];
            called.extend(called_for(&scene, &drawn).iter().map(|called| called.effect));
        }
        called.into_iter().collect()
    }

    fn settings(&self) -> Result<Settings, Fatal> {
        let file = self.view.as_deref().map(ViewFile::read).transpose().map_err(Fatal::usage)?;
        let width = self.width.or(file.as_ref().and_then(|f| f.size.0)).unwrap_or(128);
        let height = self.height.or(file.as_ref().and_then(|f| f.size.1)).unwrap_or(width);
        let mut settings = Settings {
            views: ViewSettings {
                width,
                height,
                camera: self.camera.clone().unwrap_or_default(),
                fixed: file.as_ref().map(|f| f.view),
                ..ViewSettings::default()
            },
            ..Settings::default()
        };
        let of_file = file.as_ref().map(|f| f.environment.clone());
        settings.environment = self.env.clone().or(of_file).unwrap_or_default();
        settings.pictures.background = file.as_ref().map(|f| f.background).unwrap_or_default();
        settings.pictures.tonemap = self.tonemap;
        settings.pictures.exposure = self.exposure;
        settings.prepare.point_lights = self.point_lights;
        settings.render.seed = self.seed;
        let depth = self.max_depth.or(file.as_ref().and_then(|f| f.max_depth));
        settings.render.max_depth = depth.unwrap_or(settings.render.max_depth);
        Ok(settings)
    }
}

/// Tells how a study goes: a bar on a terminal, lines elsewhere.
struct Watcher {
    console: Console,
    bar: Option<ProgressBar>,
    /// Seconds that the whole study may take.
    budget: f64,
}

/// Steps of the bar.
const STEPS: u64 = 1000;

impl Watcher {
    fn new(console: Console, budget: f64) -> Self {
        let bar = (console.terminal && !console.quiet).then(|| {
            let bar = ProgressBar::new(STEPS);
            let style = ProgressStyle::with_template("{bar:30} {percent:>3} %  {msg}");
            bar.set_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()).progress_chars("━╸ "));
            bar.enable_steady_tick(Duration::from_millis(200));
            bar
        });
        Self { console, bar, budget }
    }

    fn end(self) {
        if let Some(bar) = self.bar {
            bar.finish_and_clear();
        }
    }
}

impl Observer for Watcher {
    fn begins(&self, progress: &Progress) {
        let left = HumanDuration(Duration::from_secs_f64(self.budget * (1.0 - progress.share).max(0.0)));
        let text = format!("at most about {left} left; {}: {}", progress.asset, progress.doing);
        match &self.bar {
            Some(bar) => {
                bar.set_position((progress.share * STEPS as f64) as u64);
                bar.set_message(text);
            }
            None if !self.console.quiet => eprintln!("{:3.0} %, {text}", 100.0 * progress.share),
            None => (),
        }
    }

    fn measured(&self, _cell: &Cell) {}
}
