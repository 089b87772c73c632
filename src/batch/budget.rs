use super::stages::StageClock;
use crate::settings::Goal;
use kiln_formats::Control;
use std::time::{Duration, Instant};

/// What writing a picture is taken to cost before one has been encoded: seconds per pixel and at all.
const WRITE_GUESS: (f64, f64) = (4e-7, 0.01);
/// How much longer than the trial the real encoding may take, and what the file system may take beside it.
const WRITE_MARGIN: (f64, f64) = (2.0, 0.01);
/// CPU seconds between two looks of the renderer at the clock, and until all its threads have noticed.
const LATENCY: f64 = 0.02;
/// The most that a busy machine is taken to slow down what is left.
const MOST_SLOWDOWN: f64 = 20.0;
/// The share of the time that is kept for what nobody can foretell: a busy machine takes the processor away.
const RESERVE: f64 = 0.03;

/// The wall time that an asset may take, reading and writing included.
pub(super) struct Budget {
    end: Option<Instant>,
    /// Seconds that writing one view takes.
    write: f64,
    /// Seconds kept for surprises.
    reserve: f64,
}

impl Budget {
    /// Of an asset whose work begins now, with pictures of `pixels` pixels. A deadline of the control counts too.
    pub fn begin(goal: &Goal, control: &Control, pixels: u64) -> Self {
        // A time beyond what the clock can say is no limit.
        let time = goal.time.and_then(|t| Duration::try_from_secs_f64(t).ok());
        let own = time.and_then(|t| Instant::now().checked_add(t));
        let end = own.into_iter().chain(control.deadline()).min();
        let all = end.map_or(0.0, |end| end.saturating_duration_since(Instant::now()).as_secs_f64());
        Self { end, write: WRITE_GUESS.0 * pixels as f64 + WRITE_GUESS.1, reserve: RESERVE * all }
    }

    /// For the first of `parts` parts of the work that are left, which takes care of its own writing.
    pub fn share(&self, control: &Control, parts: usize) -> Control {
        let Some(end) = self.end else { return control.clone() };
        let left = end.saturating_duration_since(Instant::now()).as_secs_f64();
        control.until(Instant::now() + Duration::from_secs_f64(left / parts.max(1) as f64))
    }

    /// For everything that must be done before the first picture can be written.
    pub fn before_the_first_pass(&self, control: &Control) -> Control {
        self.less(control, self.write + self.reserve)
    }

    /// For the remaining passes of the first of `views` views that are left: an equal share of the time, less what
    /// writing takes.
    pub fn of_view(&self, control: &Control, views: usize) -> Control {
        let Some(end) = self.end else { return control.clone() };
        let left = end.saturating_duration_since(Instant::now()).as_secs_f64();
        let share = (left / views.max(1) as f64 - self.write - self.reserve).max(0.0);
        control.until(Instant::now() + Duration::from_secs_f64(share))
    }

    /// Learns from a trial what writing a view takes, and how often other work on the machine takes the processor away.
    pub fn learn(&mut self, trial: &StageClock) {
        let (wall, cpu) = trial.seconds();
        let slowdown = if cpu > 0.0 { (wall / cpu).clamp(1.0, MOST_SLOWDOWN) } else { 1.0 };
        self.write = wall * WRITE_MARGIN.0 + WRITE_MARGIN.1;
        self.reserve = self.reserve.max(LATENCY * slowdown);
    }

    /// Whether there is time left to try out what writing takes.
    pub fn affords_trial(&self) -> bool {
        self.end.is_some_and(|end| end.saturating_duration_since(Instant::now()).as_secs_f64() > 3.0 * self.write)
    }

    fn less(&self, control: &Control, seconds: f64) -> Control {
        let less = |end: Instant| end.checked_sub(Duration::from_secs_f64(seconds)).unwrap_or(end);
        self.end.map_or_else(|| control.clone(), |end| control.until(less(end)))
    }
}
