use super::console::{Console, print_line};
use super::exit::{Exit, Fatal};
use super::gallery;
use super::summary;
use clap::Args;
use kiln::batch::{MANIFEST, OutputLock, merge};
use std::path::PathBuf;
use std::time::Instant;

const EXAMPLES: &str = "\
Examples:
  kiln merge out/shard-* --out pictures

Takes the pictures and manifests that several runs of kiln batch have written (docs/farms.md). Pictures are linked where the
file system can, and copied elsewhere. Where several folders have an asset, the one with more of it counts. Exit code 3: a
shard is missing, or a picture is, or some assets failed.";

/// `kiln merge`.
#[derive(Args)]
#[command(after_help = EXAMPLES)]
pub struct MergeCommand {
    /// Output folders of kiln batch
    #[arg(required = true, value_name = "DIR")]
    folders: Vec<PathBuf>,
    /// Folder for all pictures and one manifest
    #[arg(short, long, value_name = "DIR")]
    out: PathBuf,
    /// Say nothing but errors
    #[arg(short, long)]
    quiet: bool,
    /// Print the merged manifest on stdout
    #[arg(long)]
    json: bool,
}

impl MergeCommand {
    /// Does it.
    ///
    /// # Errors
    /// When nothing can be begun.
    pub fn run(self) -> Result<Exit, Fatal> {
        let begin = Instant::now();
        let failed = |e: std::io::Error| Fatal::failed(format!("{}: cannot be written to: {e}", self.out.display()));
        let _lock = OutputLock::take(&self.out).map_err(failed)?;
        let merged = merge(&self.folders, &self.out).map_err(|e| Fatal::failed(e.to_string()))?;
        let path = self.out.join(MANIFEST);
        if self.json {
            std::fs::read_to_string(&path).unwrap_or_default().lines().for_each(print_line);
        }
        for problem in &merged.problems {
            eprintln!("warning: {problem}");
        }
        let console = Console::new(self.quiet, false);
        if !self.quiet {
            let seconds = begin.elapsed().as_secs_f64();
            eprintln!("{}", summary::text(&console, &merged.tally, seconds, &path.display().to_string()));
        }
        let shown = gallery::write(&self.out, None, &console);
        Ok(Exit::of(&merged.tally, merged.problems.is_empty() && shown, false))
    }
}
