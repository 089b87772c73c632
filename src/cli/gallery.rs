use super::console::Console;
use super::exit::{Exit, Fatal};
use clap::Args;
use kiln::gallery::Gallery;
use std::path::{Path, PathBuf};

const EXAMPLES: &str = "\
Examples:
  kiln gallery pictures                            pictures/index.html, as kiln batch wrote it
  kiln gallery pictures --against last-week        with sliders between the pictures of then and now

The page opens from disk and loads nothing but the pictures beside it. That of a comparison links to the earlier run's
folder where it is now, seen from this one.";

/// `kiln gallery`.
#[derive(Args)]
#[command(after_help = EXAMPLES)]
pub struct GalleryCommand {
    /// A folder that kiln batch has written to
    folder: PathBuf,
    /// Output folder of an earlier run to compare with
    #[arg(long, value_name = "DIR")]
    against: Option<PathBuf>,
    /// Say nothing but errors
    #[arg(short, long)]
    quiet: bool,
}

impl GalleryCommand {
    /// Does it.
    ///
    /// # Errors
    /// When there is no manifest or the page cannot be written.
    pub fn run(self) -> Result<Exit, Fatal> {
        let gallery = Gallery { folder: &self.folder, against: self.against.as_deref() };
        let written = gallery.write().map_err(|e| Fatal::failed(e.to_string()))?;
        if written.unreadable > 0 {
            eprintln!("warning: {} lines of the manifest cannot be read", written.unreadable);
        }
        if !self.quiet {
            eprintln!("{}: {} assets", written.path.display(), written.assets);
        }
        Ok(Exit::Done)
    }
}

/// Writes the gallery of a batch that is over, and tells whether that went well. What goes wrong is told.
pub fn write(folder: &Path, against: Option<&Path>, console: &Console) -> bool {
    let mut written = Gallery { folder, against }.write();
    if let (Err(error), Some(_)) = (&written, against) {
        // The pictures of now are worth a gallery without those of then.
        eprintln!("error: the gallery cannot compare: {error}");
        let alone = Gallery { folder, against: None }.write();
        if alone.is_ok() {
            return false;
        }
        written = alone;
    }
    match written {
        Ok(written) => {
            if !console.quiet {
                eprintln!("gallery: {}", written.path.display());
            }
            true
        }
        Err(error) => {
            eprintln!("error: the gallery cannot be written: {error}");
            false
        }
    }
}
