//! The command line: one file a subcommand, and what they share.

mod animate;
mod batch;
mod check;
mod compare;
mod config;
mod console;
mod effects;
mod exit;
mod folders;
mod gallery;
mod inspect;
mod interrupt;
mod isolation;
mod looks;
mod manual;
mod merge;
mod options;
mod plan;
mod progress;
mod rays;
mod render;
mod replay;
mod study;
mod summary;
mod thumbnail;
mod worker;

use clap::{CommandFactory, FromArgMatches, Parser, Subcommand};
use console::print_line;
use std::path::PathBuf;
use std::process::ExitCode;

const ABOUT: &str = "Turns folders of 3D assets into path-traced pictures";
const EXAMPLES: &str = "\
Examples:
  kiln batch assets --out pictures            every asset below assets, PNG and EXR, with a manifest and a gallery
  kiln batch assets --out turns --turntable 24
  kiln render chair.glb                       chair.glb.png in the current folder
  kiln render chair.glb -o chair.exr --width 1024 --spp 256
  kiln inspect chair.glb                      what is in it
  kiln plan assets                            how long a batch will take
  kiln study chair.glb --out study            what accuracy costs in time: study/report.html
  kiln gallery pictures --against earlier     what changed since an earlier run: pictures/index.html
  kiln merge shards/* --out pictures          joins what several machines have done
  kiln compare new.png old.png                how much two pictures differ
  kiln check                                  whether this installation computes light correctly

Exit codes: 0 all done, 1 failed, 2 usage, 3 done in part, 130 interrupted";

#[derive(Parser)]
#[command(name = "kiln", version, about = ABOUT, after_help = EXAMPLES, max_term_width = 110)]
struct Cli {
    /// Flags from this file [default: kiln.toml in the current folder or the nearest one above it]
    #[arg(long, global = true, value_name = "FILE", help_heading = "Configuration")]
    config: Option<PathBuf>,
    /// No flags from a file
    #[arg(long, global = true, conflicts_with = "config", help_heading = "Configuration")]
    no_config: bool,
    /// Print the flags as they count and where each comes from, and do nothing else
    #[arg(long, global = true, help_heading = "Configuration")]
    print_config: bool,
    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand)]
enum Command {
    /// Render one asset to one picture, or to a turntable
    Render(render::RenderCommand),
    /// Render every asset below folders to pictures and a manifest
    Batch(batch::BatchCommand),
    /// Tell what is in an asset
    Inspect(inspect::InspectCommand),
    /// Foretell how long a batch will take, and how much memory
    Plan(plan::PlanCommand),
    /// Measure what accuracy costs in time, and write a report
    Study(study::StudyCommand),
    /// Write the gallery of a batch's folder anew, or one that compares it with an earlier run
    Gallery(gallery::GalleryCommand),
    /// Make animations of a batch's turntables: animated PNG, WebP, MP4
    Animate(animate::AnimateCommand),
    /// Tell how much two pictures differ
    Compare(compare::CompareCommand),
    /// Render scenes whose light is known and compare
    Check(check::CheckCommand),
    /// Make a thumbnail of an asset, for file managers
    Thumbnail(thumbnail::ThumbnailCommand),
    /// Print the completions of a shell
    Completions(manual::CompletionsCommand),
    /// Print a page of the manual
    Man(manual::ManCommand),
    /// Join the outputs of several runs into one folder
    Merge(merge::MergeCommand),
    /// Do jobs from standard input (what batch starts for itself)
    #[command(hide = true)]
    Worker(worker::WorkerCommand),
}

/// Parses the arguments, does what they ask for and gives the exit code.
pub fn main() -> ExitCode {
    let arguments = match config::arguments(std::env::args_os().collect()) {
        Ok(arguments) => arguments,
        Err(error) => return error.report().into(),
    };
    let matches = Cli::command().get_matches_from(&arguments.list);
    let cli = Cli::from_arg_matches(&matches).unwrap_or_else(|e| e.exit());
    if cli.print_config {
        print_line(&arguments.text(&matches));
        return exit::Exit::Done.into();
    }
    // What panics is told in the outcome; the default hook's text would garble the progress bars.
    std::panic::set_hook(Box::new(|info| {
        if std::env::var_os("RUST_BACKTRACE").is_some() {
            eprintln!("{info}\n{}", std::backtrace::Backtrace::force_capture());
        }
    }));
    let done = match cli.command {
        Command::Render(command) => command.run(),
        Command::Batch(command) => command.run(),
        Command::Inspect(command) => command.run(),
        Command::Plan(command) => command.run(),
        Command::Study(command) => command.run(),
        Command::Gallery(command) => command.run(),
        Command::Animate(command) => command.run(),
        Command::Compare(command) => command.run(),
        Command::Check(command) => command.run(),
        Command::Thumbnail(command) => command.run(),
        Command::Completions(command) => command.run(),
        Command::Man(command) => command.run(),
        Command::Merge(command) => command.run(),
        Command::Worker(command) => command.run(),
    };
    done.unwrap_or_else(|error| error.report()).into()
}
