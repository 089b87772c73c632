use super::console::print_line;
use super::exit::{Exit, Fatal};
use clap::Args;
use kiln::formats::Limits;
use kiln::metrics::{Comparison, Show, Shown, compare, heat_map};
use kiln::settings::{Background, ToneMap};
use kiln::write::{atomic, png};
use serde_json::json;
use std::path::PathBuf;
use std::str::FromStr;

const EXAMPLES: &str = "\
Examples:
  kiln compare new.png old.png
  kiln compare draft.exr final.exr --heat-map difference.png
  kiln compare new.png old.png --json | jq .flip
  kiln compare new.png old.png --fail-above rmse=2 --fail-above flip=0.05 --fail-below ssim=0.98 --quiet

Metrics:
  rmse   root mean square difference as displayed, levels 0-255, over the pixels that either picture covers
         (transparent pictures as they look on black, or on --background)
  max    largest difference of a displayed channel, levels 0-255
  alpha  root mean square difference of the coverage, levels 0-255
  relmse relative mean square error against B in linear light: of the radiance when both files are linear (EXR, HDR),
         else of the display's light
  ssim   structural similarity of the displayed luma (Wang 2004, Gaussian window): 1 when equal
  flip   mean of FLIP, the difference that a person sees when flipping between the pictures (Andersson 2020, 67 pixels
         per degree): 0 when equal, at most 1; 0.10 is just noticeable

Exit codes: 0 compared and within the limits, 1 beyond a limit, 2 cannot be compared";

/// `kiln compare`.
#[derive(Args)]
#[command(after_help = EXAMPLES)]
pub struct CompareCommand {
    /// A picture: PNG, EXR, HDR or any other that Kiln reads
    a: PathBuf,
    /// The reference, of the same size
    b: PathBuf,
    /// Write the map of FLIP to this PNG file: black where nothing differs, pale yellow where all does
    #[arg(long, value_name = "FILE")]
    heat_map: Option<PathBuf>,
    /// Exit with 1 when rmse, max, alpha, relmse or flip is above the value (may be repeated)
    #[arg(long, value_name = "METRIC=VALUE")]
    fail_above: Vec<Limit>,
    /// Exit with 1 when ssim is below the value
    #[arg(long, value_name = "ssim=VALUE")]
    fail_below: Vec<Limit>,
    /// Tone mapping of linear pictures
    #[arg(long, value_enum, default_value_t)]
    tonemap: ToneMap,
    /// Exposure of linear pictures in EV
    #[arg(long, value_name = "EV", default_value_t = 0.0, allow_hyphen_values = true, value_parser = exposure)]
    exposure: f64,
    /// What is laid under transparent pictures, #rrggbb
    #[arg(long, value_name = "COLOUR", default_value = "#000000", value_parser = colour)]
    background: [u8; 3],
    /// Print one JSON object
    #[arg(long)]
    json: bool,
    /// Print nothing
    #[arg(short, long, conflicts_with = "json")]
    quiet: bool,
}

/// What a metric may be at most or at least.
#[derive(Clone, Debug)]
struct Limit {
    metric: Metric,
    value: f64,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
enum Metric {
    Rmse,
    Max,
    Alpha,
    Relmse,
    Ssim,
    Flip,
}

impl FromStr for Limit {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let explain =
            || format!("'{text}' is not METRIC=VALUE with rmse, max, alpha, relmse, ssim or flip and a number");
        let (name, value) = text.split_once('=').ok_or_else(explain)?;
        let metric = <Metric as clap::ValueEnum>::from_str(name, false).map_err(|_| explain())?;
        let value = value.parse::<f64>().ok().filter(|v| v.is_finite()).ok_or_else(explain)?;
        Ok(Self { metric, value })
    }
}

fn exposure(text: &str) -> Result<f64, String> {
    text.parse::<f64>().ok().filter(|ev| ev.abs() <= 64.0).ok_or(format!("'{text}' is not a number from -64 to 64"))
}

fn colour(text: &str) -> Result<[u8; 3], String> {
    match text.parse() {
        Ok(Background::Color(rgb)) => Ok(rgb),
        _ => Err(format!("'{text}' is not a colour as #rrggbb")),
    }
}

impl Metric {
    /// `None`: not finite.
    fn of(self, comparison: &Comparison) -> Option<f64> {
        match self {
            Self::Rmse => Some(comparison.rmse),
            Self::Max => Some(comparison.max),
            Self::Alpha => Some(comparison.alpha),
            Self::Relmse => comparison.relmse,
            Self::Ssim => Some(comparison.ssim),
            Self::Flip => Some(comparison.flip),
        }
    }
}

impl CompareCommand {
    /// Does it.
    ///
    /// # Errors
    /// When the pictures cannot be compared or the heat map cannot be written.
    pub fn run(self) -> Result<Exit, Fatal> {
        if self.fail_above.iter().any(|l| l.metric == Metric::Ssim) {
            return Err(Fatal::usage("the higher the ssim, the better: use --fail-below for it"));
        }
        if self.fail_below.iter().any(|l| l.metric != Metric::Ssim) {
            return Err(Fatal::usage(
                "--fail-below is for ssim; of all other metrics less is better: use --fail-above",
            ));
        }
        let show = Show { tonemap: self.tonemap, exposure_ev: self.exposure, background: self.background };
        let read = |path| Shown::read(path, &show, Limits::default().max_texels).map_err(Fatal::usage);
        let (comparison, map) = compare(&read(&self.a)?, &read(&self.b)?).map_err(Fatal::usage)?;
        if let Some(path) = &self.heat_map {
            let unwritable = |e: String| Fatal::usage(format!("{}: cannot be written: {e}", path.display()));
            let bytes = png::encode_rgb8(comparison.width, &heat_map(&map)).map_err(|e| unwritable(e.to_string()))?;
            atomic::write(path, &bytes).map_err(|e| unwritable(e.to_string()))?;
        }
        let failed = self.failed(&comparison);
        if self.json {
            let mut value = json!(comparison);
            value["a"] = self.a.display().to_string().into();
            value["b"] = self.b.display().to_string().into();
            value["failed"] = json!(failed);
            print_line(&value.to_string());
        } else if !self.quiet {
            print_line(&text(&comparison));
        }
        if !self.quiet {
            failed.iter().for_each(|reason| eprintln!("{reason}"));
        }
        Ok(if failed.is_empty() { Exit::Done } else { Exit::Failed })
    }

    /// A sentence for each limit that is not kept. What is not finite keeps none.
    fn failed(&self, comparison: &Comparison) -> Vec<String> {
        let limits = self.fail_above.iter().map(|l| (l, "above", 1.0));
        let limits = limits.chain(self.fail_below.iter().map(|l| (l, "below", -1.0)));
        let broken = |(limit, word, sign): (&Limit, &str, f64)| {
            let name = format!("{:?}", limit.metric).to_lowercase();
            match limit.metric.of(comparison) {
                Some(value) if sign * value <= sign * limit.value => None,
                Some(value) => Some(format!("{name} is {value:.6}, {word} {}", limit.value)),
                None => Some(format!("{name} is not finite")),
            }
        };
        limits.filter_map(broken).collect()
    }
}

fn text(c: &Comparison) -> String {
    let relmse = c.relmse.map_or("not finite".into(), |v| format!("{v:.6}"));
    let light = if c.scene_referred { "linear radiance" } else { "the display's linear light" };
    let seen = if c.flip_p95 < kiln::metrics::flip::just_noticeable() { "nobody sees it" } else { "can be seen" };
    let covered = 100.0 * c.covered as f64 / (f64::from(c.width) * f64::from(c.height));
    [
        format!("rmse     {:.4} of 255 levels as displayed, over the {covered:.0} % that is covered", c.rmse),
        format!("max      {:.1} of 255 levels", c.max),
        format!("alpha    {:.4} of 255 levels", c.alpha),
        format!("relmse   {relmse} in {light}"),
        format!("ssim     {:.6}", c.ssim),
        format!("flip     {:.6}; in 95 % of what is covered below {:.3}: {seen}", c.flip, c.flip_p95),
    ]
    .join("\n")
}
