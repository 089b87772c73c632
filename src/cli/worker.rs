use super::exit::{Exit, Fatal};
use super::options::start_threads;
use clap::Args;
use kiln::Control;
use kiln::batch::workers::{Report, Request, bound_memory, forget_peak, held_bytes};
use kiln::batch::{Desk, FileSink, Job, LoadedEnvironment, run_asset_with};
use kiln::settings::{EnvironmentFile, EnvironmentSettings};
use std::fs::File;
use std::io::{BufRead, Write};
use std::path::PathBuf;
use std::sync::mpsc::{Receiver, channel};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;

/// How often progress is told.
const PACE: Duration = Duration::from_millis(200);
/// Stack of the thread that works: importers may recurse as deep as the limit on nesting allows.
const STACK_BYTES: usize = 16 << 20;

/// `kiln worker`: what `kiln batch` starts for itself.
#[derive(Args)]
pub struct WorkerCommand {
    /// Threads that render
    #[arg(long)]
    threads: u16,
    /// Bytes of memory that may be taken
    #[arg(long)]
    memory: Option<u64>,
    /// File on which a shared lock is held
    #[arg(long)]
    presence: Option<PathBuf>,
}

/// The job under way, for those who tell of it and those who stop it.
type Current = Arc<Mutex<Control>>;

impl WorkerCommand {
    /// Does jobs until its input ends.
    ///
    /// # Errors
    /// When nothing can be begun.
    pub fn run(self) -> Result<Exit, Fatal> {
        // Ctrl-C and its like reach the whole group of processes; what they mean for a worker is decided by its master.
        let _ = ctrlc::set_handler(|| ());
        let presence = self.presence.as_deref().and_then(|path| File::open(path).ok());
        let _held = presence.as_ref().map(File::try_lock_shared);
        start_threads(Some(self.threads))?;
        let (jobs, due) = channel();
        let current = Current::default();
        let listened = current.clone();
        let spawn = |name: &str, work: Box<dyn FnOnce() + Send>| {
            let made = std::thread::Builder::new().name(name.into()).stack_size(STACK_BYTES).spawn(work);
            made.map_err(|e| Fatal::failed(format!("threads cannot be made: {e}")))
        };
        spawn("requests", Box::new(move || listen(&jobs, &listened)))?;
        let told = current.clone();
        spawn("progress", Box::new(move || tell_progress(&told)))?;
        let memory = self.memory;
        let work = spawn("asset", Box::new(move || work(&due, memory)))?;
        // It ends with the input, and then with the process.
        let _ = work.join();
        Ok(Exit::Done)
    }
}

/// Takes requests. With the last of them the process ends, whatever it is at.
fn listen(jobs: &std::sync::mpsc::Sender<(Box<Job>, Control)>, current: &Current) {
    for line in std::io::stdin().lock().lines().map_while(Result::ok) {
        match serde_json::from_str(&line) {
            Ok(Request::Do(job)) => {
                let control = Control::default();
                *current.lock().unwrap_or_else(PoisonError::into_inner) = control.clone();
                if jobs.send((job, control)).is_err() {
                    break;
                }
            }
            Ok(Request::Stop) => current.lock().unwrap_or_else(PoisonError::into_inner).stop(),
            Err(error) => {
                eprintln!("worker: no request: {error}");
                break;
            }
        }
    }
    std::process::exit(0);
}

fn tell_progress(current: &Current) {
    let mut last = (0, 0);
    loop {
        std::thread::sleep(PACE);
        let progress = current.lock().unwrap_or_else(PoisonError::into_inner).progress();
        if progress != last {
            last = progress;
            tell(&Report::Progress(progress.0, progress.1));
        }
    }
}

fn work(due: &Receiver<(Box<Job>, Control)>, memory: Option<u64>) {
    if let Some(Err(error)) = memory.map(bound_memory) {
        eprintln!("worker: memory is not bounded: {error}");
    }
    let mut environment = None;
    for (job, control) in due {
        forget_peak();
        fault::happen(&job.input);
        let sink = FileSink { folder: job.output.folder.clone() };
        let on_stage = |stage| tell(&Report::Stage(stage));
        let environment = load(&mut environment, &job.settings.environment);
        let outcome = run_asset_with(&job, &control, &Desk { sink: &sink, on_stage: &on_stage, environment });
        tell(&Report::Done(Box::new(outcome), held_bytes()));
    }
}

/// The environment file of a job, read once for all jobs in a row that have the same.
fn load(
    kept: &mut Option<(EnvironmentFile, Arc<LoadedEnvironment>)>,
    settings: &EnvironmentSettings,
) -> Option<Arc<LoadedEnvironment>> {
    let EnvironmentSettings::File(file) = settings else { return None };
    if kept.as_ref().is_none_or(|(path, _)| path != file) {
        // One that cannot be read is told by the job.
        *kept = LoadedEnvironment::read(&file.path).ok().map(|read| (file.clone(), Arc::new(read)));
    }
    kept.as_ref().map(|(_, environment)| environment.clone())
}

fn tell(report: &Report) {
    let Ok(mut line) = serde_json::to_vec(report) else { return };
    line.push(b'\n');
    let mut stdout = std::io::stdout().lock();
    // A master that does not listen is gone, and the input will end.
    let _ = stdout.write_all(&line).and_then(|()| stdout.flush());
}

/// Faults on purpose, so that tests of the real program see what becomes of them: `KILN_FAULT=NAME=KIND,…` lets the asset with
/// that file name `abort`, `loop`, `allocate`, `overflow` the stack or `panic`.
mod fault {
    use std::hint::black_box;
    use std::path::Path;

    pub fn happen(asset: &Path) {
        let Some(faults) = std::env::var_os("KILN_FAULT") else { return };
        let faults = faults.to_string_lossy().into_owned();
        let name = asset.file_name().unwrap_or_default().to_string_lossy();
        match faults.split(',').filter_map(|f| f.split_once('=')).find(|(n, _)| *n == name).map(|(_, kind)| kind) {
            Some("abort") => std::process::abort(),
            Some("loop") => loop {
                std::thread::sleep(std::time::Duration::from_secs(1));
            },
            Some("allocate") => {
                let mut all = Vec::new();
                loop {
                    all.push(black_box(vec![1u8; 16 << 20]));
                }
            }
            Some("overflow") => {
                black_box(deeper(black_box(1)));
            }
            _ => (),
        }
    }

    fn deeper(depth: u64) -> u64 {
        let place = black_box([depth; 64]);
        if depth == 0 { 0 } else { deeper(depth + 1) + place[(depth % 64) as usize] }
    }
}
