mod bars;

use super::console::{Color, Console, harmless, print_line};
use bars::Bars;
use kiln::Control;
use kiln::batch::{Job, Observer, Outcome, Stage, Status};
use std::sync::atomic::{AtomicUsize, Ordering};

/// Tells people and machines how the work goes.
pub struct Progress {
    console: Console,
    json: bool,
    total: usize,
    done: AtomicUsize,
    bars: Option<Bars>,
}

impl Progress {
    /// For `total` assets with `workers` at a time.
    pub fn new(console: Console, json: bool, total: usize, workers: usize) -> Self {
        let bars = (console.terminal && !console.quiet).then(|| Bars::new(total, workers, console.color));
        Self { console, json, total, done: AtomicUsize::new(0), bars }
    }

    /// Takes the bars off the screen.
    pub fn end(self) {
        if let Some(bars) = self.bars {
            bars.end();
        }
    }

    fn digits(&self) -> usize {
        self.total.to_string().len()
    }

    fn tell(&self, line: &str) {
        match &self.bars {
            Some(bars) => bars.print(line),
            None => eprintln!("{line}"),
        }
    }
}

/// The line about a finished asset: status, seconds, name, and the first thing to know about it.
pub fn line(console: &Console, outcome: &Outcome) -> String {
    let color = match outcome.status {
        Status::Ok => Color::Green,
        Status::Warned | Status::Partial | Status::Skipped => Color::Yellow,
        Status::Failed => Color::Red,
    };
    let word = console.paint(&format!("{:7}", outcome.status.word()), color);
    let mut line = format!("{word} {:8.2} s  {}{}", outcome.seconds.total, harmless(&outcome.input), accuracy(outcome));
    if let Some(message) = &outcome.error_message {
        line += &format!(": {}", harmless(message));
    } else if let Some(first) = outcome.warnings.first().filter(|_| !console.verbose) {
        line += &format!(": {}", warning(first));
        if outcome.warnings.len() > 1 {
            line += &format!(" (and {} more)", outcome.warnings.len() - 1);
        }
    }
    if console.verbose {
        outcome.warnings.iter().for_each(|w| line += &format!("\n    warning: {}", warning(w)));
    }
    line
}

/// The error of the worst picture.
fn accuracy(outcome: &Outcome) -> String {
    let stated = outcome.outputs.iter().filter_map(|o| Some((o.error?, o.error_bound?, o.target_met)));
    let worst = stated.max_by(|a, b| a.1.total_cmp(&b.1));
    worst.map_or_else(String::new, |(error, bound, met)| {
        let missed = if met == Some(false) { ": not what was asked for" } else { "" };
        format!("  error {error:.2} (at most {bound:.2}{missed})")
    })
}

/// Where the pictures are, on a line of its own.
fn pictures(outcome: &Outcome) -> String {
    match &outcome.outputs[..] {
        [] => String::new(),
        [one] => format!("\n  {}", harmless(&one.path)),
        [first, .., last] => {
            format!("\n  {} … {} ({} files)", harmless(&first.path), harmless(&last.path), outcome.outputs.len())
        }
    }
}

/// A warning on one line.
pub fn warning(warning: &kiln::formats::Warning) -> String {
    let place = if warning.place.is_empty() { String::new() } else { format!(" at {}", warning.place) };
    harmless(&format!("{}{place}: {}", warning.code, warning.message))
}

impl Observer for Progress {
    fn started(&self, worker: usize, job: &Job, control: &Control) {
        if let Some(bars) = &self.bars {
            bars.started(worker, &harmless(&job.name), control);
        }
    }

    fn stage(&self, worker: usize, stage: Stage) {
        if let Some(bars) = &self.bars {
            bars.stage(worker, stage);
        }
    }

    fn kept(&self, outcome: &Outcome) {
        let done = self.done.fetch_add(1, Ordering::Relaxed) + 1;
        if let Some(bars) = &self.bars {
            bars.kept();
        }
        if self.json
            && let Ok(line) = outcome.to_line()
        {
            print_line(&line);
        }
        if self.console.verbose {
            self.tell(&format!(
                "[{done:width$}/{}] up to date {}",
                self.total,
                harmless(&outcome.input),
                width = self.digits()
            ));
        }
    }

    fn finished(&self, worker: usize, outcome: &Outcome) {
        let done = self.done.fetch_add(1, Ordering::Relaxed) + 1;
        if let Some(bars) = &self.bars {
            bars.finished(worker);
        }
        if self.json
            && let Ok(line) = outcome.to_line()
        {
            print_line(&line);
        }
        let failed = outcome.status == Status::Failed;
        // Those that were never begun are counted in the summary.
        let begun = outcome.status != Status::Skipped || outcome.seconds.total > 0.0;
        if begun && (!self.console.quiet || failed) {
            let line = line(&self.console, outcome);
            if self.total > 1 {
                self.tell(&format!("[{done:width$}/{}] {line}", self.total, width = self.digits()));
            } else {
                self.tell(&format!("{line}{}", pictures(outcome)));
            }
        }
    }
}
