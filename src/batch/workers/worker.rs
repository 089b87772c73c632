use super::{Death, Isolation, Report, Request};
use crate::batch::{Job, Outcome, Stage};
use kiln_formats::Control;
use std::io::{self, BufRead, BufReader, Read, Write};
use std::process::{Child, ChildStdin, Command, Stdio};
use std::sync::mpsc::{Receiver, RecvTimeoutError, channel};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

/// How often the one who waits looks at the clock and whether somebody asks for a stop.
const LOOK: Duration = Duration::from_millis(50);
/// How long an asset may take to stop when asked to: the picture so far is still encoded.
const GRACE: Duration = Duration::from_secs(60);
/// As much of what a worker complains about is kept.
const COMPLAINTS: usize = 4096;
/// A worker that holds more than this share of its memory after a job is replaced.
const HOARD: f64 = 0.25;

/// A worker process.
pub struct Worker {
    child: Child,
    /// `None` once it has been told to end.
    input: Option<ChildStdin>,
    reports: Receiver<Report>,
    complaints: Arc<Mutex<Vec<u8>>>,
    listener: Option<JoinHandle<()>>,
    /// Jobs that it has done.
    pub jobs: u64,
    hoards: bool,
}

impl Worker {
    /// Starts one.
    ///
    /// # Errors
    /// Those of the system.
    pub fn start(isolation: &Isolation) -> io::Result<Self> {
        let mut command = Command::new(&isolation.program);
        command.arg("worker").args(["--threads", &isolation.threads.to_string()]);
        if let Some(bytes) = isolation.memory {
            command.args(["--memory", &bytes.to_string()]);
        }
        if let Some(file) = &isolation.presence {
            command.arg("--presence").arg(file);
        }
        let mut child = command.stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn()?;
        let (sender, reports) = channel();
        let complaints = Arc::<Mutex<Vec<u8>>>::default();
        let output = child.stdout.take().ok_or(io::ErrorKind::BrokenPipe)?;
        let errors = child.stderr.take().ok_or(io::ErrorKind::BrokenPipe)?;
        let kept = complaints.clone();
        let named = |name: &str| std::thread::Builder::new().name(name.into()).stack_size(256 << 10);
        named("worker-reports").spawn(move || {
            // What is no report is the end: a process that writes something else is not well.
            let reports = BufReader::new(output).lines().map_while(Result::ok);
            for report in reports.map_while(|line| serde_json::from_str(&line).ok()) {
                if sender.send(report).is_err() {
                    break;
                }
            }
        })?;
        let listener = named("worker-complaints").spawn(move || listen(errors, &kept))?;
        let input = child.stdin.take();
        Ok(Self { child, input, reports, complaints, listener: Some(listener), jobs: 0, hoards: false })
    }

    /// Whether it can take another job.
    pub fn is_well(&self) -> bool {
        !self.hoards && self.input.is_some()
    }

    /// Has a job done.
    ///
    /// # Errors
    /// How the worker died of it. Then it is gone.
    pub fn run(
        &mut self,
        job: &Job,
        isolation: &Isolation,
        control: &Control,
        on_stage: &dyn Fn(Stage),
    ) -> Result<Outcome, Death> {
        let begin = Instant::now();
        if let Err(error) = self.ask(&Request::Do(Box::new(job.clone()))) {
            return Err(self.end_of(|| Death::Unreachable(error.to_string())));
        }
        self.jobs += 1;
        let (mut moved, mut last, mut asked) = (begin, (0, 0), None::<Instant>);
        loop {
            match self.reports.recv_timeout(LOOK) {
                Ok(Report::Done(outcome, held)) => {
                    let share = |held: u64, all: u64| held as f64 > HOARD * all as f64;
                    self.hoards = held.zip(isolation.memory).is_some_and(|(held, all)| share(held, all));
                    return Ok(*outcome);
                }
                Ok(Report::Stage(stage)) => {
                    moved = Instant::now();
                    control.begin(0);
                    on_stage(stage);
                }
                Ok(Report::Progress(done, total)) => {
                    control.begin_at(done, total);
                    if (done, total) != last {
                        (moved, last) = (Instant::now(), (done, total));
                    }
                }
                Err(RecvTimeoutError::Timeout) => (),
                Err(RecvTimeoutError::Disconnected) => {
                    return Err(self.end_of(|| Death::Crashed("it fell silent".into())));
                }
            }
            if asked.is_none() && control.was_asked_to_stop() {
                asked = Some(Instant::now());
                // Should it have died, the next report tells.
                let _ = self.ask(&Request::Stop);
            }
            let death = match isolation.timeout {
                Some(limit) if begin.elapsed() > limit => Death::Timeout(limit),
                _ if moved.elapsed() > isolation.patience => Death::Stalled(isolation.patience),
                _ if asked.is_some_and(|asked| asked.elapsed() > GRACE) => Death::Stopped,
                _ => continue,
            };
            self.kill();
            return Err(death);
        }
    }

    fn ask(&mut self, request: &Request) -> io::Result<()> {
        let input = self.input.as_mut().ok_or(io::ErrorKind::BrokenPipe)?;
        let mut line = serde_json::to_vec(request)?;
        line.push(b'\n');
        input.write_all(&line)
    }

    /// The death of a process that has ended, or is about to.
    fn end_of(&mut self, otherwise: impl FnOnce() -> Death) -> Death {
        self.input = None;
        let begin = Instant::now();
        let status = loop {
            match self.child.try_wait() {
                Ok(Some(status)) => break Some(status),
                Ok(None) if begin.elapsed() < Duration::from_secs(5) => std::thread::sleep(Duration::from_millis(1)),
                _ => break None,
            }
        };
        self.kill();
        if let Some(listener) = self.listener.take() {
            // It ends with the process.
            let _ = listener.join();
        }
        let complaints = self.complaints.lock().unwrap_or_else(PoisonError::into_inner);
        status.map_or_else(otherwise, |status| Death::of(status, &String::from_utf8_lossy(&complaints)))
    }

    fn kill(&mut self) {
        self.input = None;
        // It may be gone already.
        let _ = self.child.kill();
        let begin = Instant::now();
        // One that hangs in the system (a network drive that is gone) ends when the system lets it.
        while matches!(self.child.try_wait(), Ok(None)) && begin.elapsed() < Duration::from_secs(2) {
            std::thread::sleep(Duration::from_millis(1));
        }
    }
}

impl Drop for Worker {
    fn drop(&mut self) {
        self.kill();
    }
}

/// Keeps the last of what is said.
fn listen(mut errors: impl Read, kept: &Mutex<Vec<u8>>) {
    let tell = std::env::var_os("RUST_BACKTRACE").is_some();
    let mut block = [0; 1024];
    while let Ok(count @ 1..) = errors.read(&mut block) {
        let mut kept = kept.lock().unwrap_or_else(PoisonError::into_inner);
        kept.extend_from_slice(&block[..count]);
        let surplus = kept.len().saturating_sub(COMPLAINTS);
        kept.drain(..surplus);
        if tell {
            // Whoever asks for backtraces wants those of workers, too.
            let _ = io::stderr().write_all(&block[..count]);
        }
    }
}
