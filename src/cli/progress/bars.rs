use indicatif::{HumanDuration, MultiProgress, ProgressBar, ProgressState, ProgressStyle};
use kiln::Control;
use kiln::batch::Stage;
use std::fmt::Write;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread::JoinHandle;
use std::time::Duration;

/// Bars on a terminal: one for the whole batch and one for each asset that is worked on.
pub struct Bars {
    shared: Arc<Shared>,
    poller: Option<JoinHandle<()>>,
}

struct Shared {
    multi: MultiProgress,
    total: ProgressBar,
    workers: Vec<Worker>,
    over: AtomicBool,
}

struct Worker {
    bar: ProgressBar,
    control: Mutex<Option<Control>>,
}

const STAGE: &str = "  {prefix:8} {bar:24} {share:>5} {left:>6}                 {wide_msg}";
const RENDER: &str = "  {prefix:8} {bar:24} {share:>5} {left:>6} {rate:>14}  {wide_msg}";

fn style(template: &str) -> ProgressStyle {
    let style = ProgressStyle::with_template(template).unwrap_or_else(|_| ProgressStyle::default_bar());
    // Some stages do not tell how much there is to do.
    let told = |state: &ProgressState| state.pos() > 0;
    let tell = |tell: fn(&ProgressState) -> String| {
        move |state: &ProgressState, text: &mut dyn Write| {
            // Writing to a string does not fail.
            let _ = if told(state) { text.write_str(&tell(state)) } else { Ok(()) };
        }
    };
    style
        .with_key("share", tell(|s| format!("{:.0} %", 100.0 * s.fraction())))
        .with_key("rate", tell(|s| format!("{:.0} kpaths/s", 1e-3 * s.per_sec())))
        .with_key("left", tell(|s| format!("{:#}", HumanDuration(s.eta()))))
        .progress_chars("━╸ ")
}

impl Bars {
    /// Empty bars.
    pub fn new(total: usize, workers: usize, color: bool) -> Self {
        let paint = if color { ".green" } else { "" };
        let multi = MultiProgress::new();
        let workers = (0..workers.min(total.max(1)))
            .map(|_| {
                let bar = multi.add(ProgressBar::new(1));
                bar.set_style(style(STAGE));
                Worker { bar, control: Mutex::new(None) }
            })
            .collect();
        let bar = ProgressBar::new(total as u64);
        let bar = if total > 1 { multi.add(bar) } else { ProgressBar::hidden() };
        let template = format!("{{bar:34{paint}}} {{pos}}/{{len}} assets  {{per_sec}}  {{elapsed}} gone, {{eta}} left");
        bar.set_style(style(&template));
        let shared = Arc::new(Shared { multi, total: bar, workers, over: AtomicBool::new(false) });
        let polled = shared.clone();
        let poll = move || {
            while !polled.over.load(Ordering::Relaxed) {
                polled.workers.iter().for_each(Worker::poll);
                polled.total.tick();
                std::thread::park_timeout(Duration::from_millis(100));
            }
        };
        let poller = std::thread::Builder::new().name("progress".into()).spawn(poll).ok();
        Self { shared, poller }
    }

    /// Prints a line above the bars.
    pub fn print(&self, line: &str) {
        // When the terminal is gone there is nobody to tell.
        let _ = self.shared.multi.println(line);
    }

    /// A worker takes up an asset.
    pub fn started(&self, worker: usize, name: &str, control: &Control) {
        if let Some(worker) = self.shared.workers.get(worker) {
            worker.bar.set_message(name.to_string());
            *worker.control.lock().unwrap_or_else(PoisonError::into_inner) = Some(control.clone());
        }
    }

    /// A worker begins a stage.
    pub fn stage(&self, worker: usize, stage: Stage) {
        if let Some(worker) = self.shared.workers.get(worker) {
            worker.bar.reset();
            worker.bar.set_length(1);
            let (prefix, template) = match stage {
                Stage::Render { view, views } if views > 1 => (format!("{}/{views}", view + 1), RENDER),
                Stage::Render { .. } => ("render".into(), RENDER),
                _ => (stage.word().into(), STAGE),
            };
            worker.bar.set_style(style(template));
            worker.bar.set_prefix(prefix);
        }
    }

    /// A worker is done with its asset.
    pub fn finished(&self, worker: usize) {
        if let Some(worker) = self.shared.workers.get(worker) {
            *worker.control.lock().unwrap_or_else(PoisonError::into_inner) = None;
            worker.bar.set_message("");
            worker.bar.set_prefix("");
            worker.bar.set_position(0);
        }
        self.shared.total.inc(1);
    }

    /// An asset was up to date.
    pub fn kept(&self) {
        self.shared.total.inc(1);
    }

    /// Takes the bars off the screen.
    pub fn end(mut self) {
        self.shared.over.store(true, Ordering::Relaxed);
        if let Some(poller) = self.poller.take() {
            poller.thread().unpark();
            // It only draws.
            let _ = poller.join();
        }
        self.shared.workers.iter().for_each(|w| w.bar.finish_and_clear());
        self.shared.total.finish_and_clear();
    }
}

impl Worker {
    fn poll(&self) {
        if let Some(control) = &*self.control.lock().unwrap_or_else(PoisonError::into_inner) {
            let (done, total) = control.progress();
            // A bar of nothing would be full.
            self.bar.set_length(total.max(1));
            self.bar.set_position(done.min(total));
        }
    }
}
