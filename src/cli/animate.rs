use super::exit::{Exit, Fatal};
use super::options::start_threads;
use clap::{Args, value_parser};
use kiln::gallery::animate;
use std::path::PathBuf;

const EXAMPLES: &str = "\
Examples:
  kiln batch assets --out turns --turntable 24 --format png
  kiln animate turns                                an animated PNG of each: turns/chair.glb.apng
  kiln animate turns --fps 24 --threads 2

Browsers play .apng files; viewers that know nothing of animations show the first frame once the file is called .png.";

/// `kiln animate`.
#[derive(Args)]
#[command(after_help = EXAMPLES)]
pub struct AnimateCommand {
    /// A folder that kiln batch --turntable has written PNG files to
    folder: PathBuf,
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

impl AnimateCommand {
    /// Does it.
    ///
    /// # Errors
    /// When there is no manifest, or no turntable in it.
    pub fn run(self) -> Result<Exit, Fatal> {
        start_threads(self.threads)?;
        let all = animate(&self.folder, self.fps).map_err(|e| Fatal::failed(e.to_string()))?;
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
