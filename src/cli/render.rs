use super::batch::environment;
use super::console::Console;
use super::exit::{Exit, Fatal};
use super::interrupt::Interrupt;
use super::options::SettingOptions;
use super::progress::Progress;
use super::replay::{self, PathAddress};
use clap::Args;
use kiln::Control;
use kiln::batch::{Assignment, FileSink, Job, MemorySink, Output, Tally, run};
use kiln::formats::Limits;
use kiln::settings::PictureFormat;
use std::io::Write;
use std::path::{Path, PathBuf};

const EXAMPLES: &str = "\
Examples:
  kiln render chair.glb                             chair.glb.png in the current folder
  kiln render chair.glb -o chair.exr --spp 1024
  kiln render chair.glb -o turn.png --turntable 24  turn.000.png … turn.023.png
  kiln render chair.glb -o - | display
  kiln render chair.glb --replay 12,34,5            what happens to sample 5 of the pixel in column 12, row 34
  kiln render helmet.glb --view bench.json --env studio.hdr --format png,exr";

/// `kiln render`.
#[derive(Args)]
#[command(after_help = EXAMPLES)]
pub struct RenderCommand {
    /// A .gltf, .glb, .obj or .ray file
    asset: PathBuf,
    /// Picture to write, .png or .exr; - writes a PNG to stdout [default: the asset's name with .png]
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
    /// Files to write, where -o does not say it [default: png]
    #[arg(long, value_enum, value_delimiter = ',', conflicts_with = "output")]
    format: Vec<PictureFormat>,
    /// Follows one path instead, by column, row and sample (and view), and prints its steps
    #[arg(long, value_name = "X,Y,SAMPLE", conflicts_with_all = ["output", "format"])]
    replay: Option<PathAddress>,
    #[command(flatten)]
    options: SettingOptions,
}

impl RenderCommand {
    /// Does it.
    ///
    /// # Errors
    /// When nothing can be begun.
    pub fn run(self) -> Result<Exit, Fatal> {
        let to_stdout = self.output.as_deref() == Some(Path::new("-"));
        if to_stdout && (self.options.json || self.options.is_turntable() || self.options.denoise.is_some()) {
            let message =
                "-o - writes one picture to stdout: neither --json nor --turntable nor --denoise goes with it";
            return Err(Fatal::usage(message));
        }
        let (output, formats) = self.output()?;
        let settings = self.options.settings(formats)?;
        let environment = environment(&settings)?;
        let job = Job {
            name: self.asset.display().to_string(),
            input: self.asset.clone(),
            root: self.options.root.clone(),
            limits: Limits::default(),
            output,
            settings,
        };
        self.options.start_threads()?;
        if let Some(address) = self.replay {
            return replay::run(&job, address, environment, self.options.json);
        }
        let control = Control::default();
        let interrupt = Interrupt::watch(&control);
        let console = Console::new(self.options.quiet, self.options.verbose);
        let progress = Progress::new(console, self.options.json, 1, 1);
        let memory = MemorySink::default();
        let files = FileSink { folder: job.output.folder.clone() };
        let outcomes = run(&Assignment {
            jobs: std::slice::from_ref(&job),
            workers: 1,
            sink: if to_stdout { &memory } else { &files },
            environment,
            control: &control,
            observer: &progress,
        });
        progress.end();
        for (_, bytes) in memory.into_files() {
            let mut stdout = std::io::stdout().lock();
            let written = stdout.write_all(&bytes).and_then(|()| stdout.flush());
            written.map_err(|e| Fatal::failed(format!("stdout cannot be written to: {e}")))?;
        }
        Ok(Exit::of(&Tally::of(&outcomes), true, interrupt.happened()))
    }

    /// Where the picture goes, and the formats that this means.
    fn output(&self) -> Result<(Output, Vec<PictureFormat>), Fatal> {
        let name = self.asset.file_name().map(PathBuf::from);
        let name = name.ok_or_else(|| Fatal::usage(format!("{} is not a file", self.asset.display())))?;
        let path = match self.output.as_deref() {
            None => {
                let formats = if self.format.is_empty() { vec![PictureFormat::Png] } else { self.format.clone() };
                return Ok((Output { folder: PathBuf::new(), stem: name, ending: None }, formats));
            }
            Some(path) if path == Path::new("-") => {
                return Ok((Output { folder: PathBuf::new(), stem: name, ending: None }, vec![PictureFormat::Png]));
            }
            Some(path) => path,
        };
        let ending = path.extension().and_then(|e| e.to_str()).unwrap_or_default();
        let format = match ending.to_ascii_lowercase().as_str() {
            "png" => PictureFormat::Png,
            "exr" => PictureFormat::Exr,
            _ => return Err(Fatal::usage(format!("{}: pictures end in .png or .exr", path.display()))),
        };
        Ok((
            Output { folder: PathBuf::new(), stem: path.with_extension(""), ending: Some(ending.into()) },
            vec![format],
        ))
    }
}
