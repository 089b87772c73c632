use clap::Args;
use kiln::formats::Show;
use kiln::settings::LookSettings;

/// Which looks of an asset are pictured.
#[derive(Args, Clone, Debug)]
pub struct LookOptions {
    /// Show the asset at a moment of its animation, seconds from its beginning [default: the rest pose]
    #[arg(long, value_name = "T", value_parser = seconds, allow_negative_numbers = true, help_heading = "Looks")]
    time_code: Option<f64>,
    /// The animation with this name or index, or all at once [default: the first]
    #[arg(long, value_name = "NAME|all", help_heading = "Looks")]
    animation: Option<String>,
    /// The turntable plays the animation once, from --time-code on
    #[arg(long, requires = "turntable", help_heading = "Looks")]
    play: bool,
    /// The material variant with this name or index, or pictures of all of them
    #[arg(long, value_name = "NAME|all", help_heading = "Looks")]
    variant: Option<String>,
}

fn seconds(text: &str) -> Result<f64, String> {
    let seconds = text.parse::<f64>().ok().filter(|t| t.is_finite() && *t >= 0.0);
    seconds.ok_or_else(|| format!("'{text}' is no time: seconds, 0 or more"))
}

impl LookOptions {
    pub(super) fn settings(&self) -> LookSettings {
        let every_variant = self.variant.as_deref() == Some("all");
        LookSettings {
            show: Show {
                animation: self.animation.clone(),
                time: self.time_code,
                variant: self.variant.clone().filter(|_| !every_variant),
            },
            every_variant,
            play: self.play,
        }
    }
}
