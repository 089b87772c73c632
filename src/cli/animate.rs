use super::exit::{Exit, Fatal};
use super::options::start_threads;
use clap::{Args, value_parser};
use kiln::gallery::{Animation, AnimationFormat, animate};
use kiln::settings::Background;
use std::path::PathBuf;

const EXAMPLES: &str = "\
Examples:
  kiln batch assets --out turns --turntable 24 --format png
  kiln animate turns                                an animated PNG of each: turns/chair.glb.apng
  kiln animate turns --format webp,mp4 --fps 24     animated WebP, and films by ffmpeg

Browsers play .apng and .webp files, which lose nothing; viewers that know nothing of animations show the first frame of an
.apng file once it is called .png. Films are H.264, over --background, and need ffmpeg on the system's path.";

/// `kiln animate`.
#[derive(Args)]
#[command(after_help = EXAMPLES)]
pub struct AnimateCommand {
    /// A folder that kiln batch --turntable has written PNG files to
    folder: PathBuf,
    /// Files to make of each turntable
    #[arg(long, value_enum, value_delimiter = ',', default_value = "apng")]
    format: Vec<AnimationFormat>,
    /// What is behind transparent pixels in films: #rrggbb
    #[arg(long, default_value = "#ffffff", value_name = "COLOR", value_parser = color)]
    background: [u8; 3],
    /// Frames a second
    #[arg(long, default_value_t = 12, value_name = "N", value_parser = value_parser!(u16).range(1..=120))]
    fps: u16,
    /// Threads [default: one per core]
    #[arg(long, value_name = "N", value_parser = value_parser!(u16).range(1..=4096))]
    threads: Option<u16>,
    /// Say nothing but errors
    #[arg(short, long)]
    quiet: bool,
}

fn color(text: &str) -> Result<[u8; 3], String> {
    match text.parse() {
        Ok(Background::Color(color)) => Ok(color),
        _ => Err(format!("'{text}' is not a colour such as #ffffff")),
    }
}

impl AnimateCommand {
    /// Does it.
    ///
    /// # Errors
    /// When there is no manifest, no turntable in it, or no ffmpeg for films.
    pub fn run(mut self) -> Result<Exit, Fatal> {
        start_threads(self.threads)?;
        self.format.sort_unstable();
        self.format.dedup();
        let (formats, frames_per_second, background) = (self.format, self.fps, self.background);
        let animation = Animation { formats, frames_per_second, background };
        let all = animate(&self.folder, &animation).map_err(|e| Fatal::failed(e.to_string()))?;
        if all.is_empty() {
            let folder = self.folder.display();
            return Err(Fatal::failed(format!("{folder}: has no turntables in PNG files (kiln batch --turntable N)")));
        }
        let mut made = 0;
        for one in &all {
            match &one.result {
                Ok(path) => {
                    made += 1;
                    if !self.quiet {
                        eprintln!("{}", self.folder.join(path).display());
                    }
                }
                Err(message) => eprintln!("failed: {}: {message}", one.input),
            }
        }
        Ok(if made == all.len() {
            Exit::Done
        } else if made > 0 {
            Exit::Partial
        } else {
            Exit::Failed
        })
    }
}
