use super::Foretold;
use super::schedule::play;
use crate::batch::StageSeconds;
use serde::Serialize;

/// A figure and the interval that it lies in, nine times of ten.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Interval {
    /// The most likely.
    pub expected: f64,
    /// Lower end.
    pub low: f64,
    /// Upper end.
    pub high: f64,
}

/// What is foretold of one asset.
#[derive(Clone, Debug, Serialize)]
pub struct Entry {
    /// What the batch calls it.
    pub input: String,
    /// Its share of all CPU seconds.
    pub share: f64,
    /// CPU seconds by stage.
    pub cpu_seconds: StageSeconds,
    /// Samples per pixel.
    pub spp: u32,
    /// Bytes that it needs.
    pub bytes: Option<u64>,
    /// Why it will fail, if so.
    pub error_message: Option<String>,
}

/// What a batch will take.
#[derive(Clone, Debug, Serialize)]
pub struct Forecast {
    /// Wall seconds.
    pub seconds: Interval,
    /// CPU seconds.
    pub cpu_seconds: Interval,
    /// Most memory at a time, bytes; `None` where the system does not tell.
    pub peak_bytes: Option<Interval>,
    /// How many times as long as on a machine that does nothing else, by what the probes took.
    pub slowdown: f64,
    /// The assets, the longest first.
    pub assets: Vec<Entry>,
}

/// Relative uncertainty (about two standard deviations) that all assets share: a machine that is cooler, busier, or has other
/// things in its caches than while probing. Measured: scripts/runs/2026-11-22-plan.md.
const COMMON: f64 = 0.18;
/// The same for each asset by itself: a small picture and few samples stand for all.
const OWN: f64 = 0.3;

impl Forecast {
    /// Of a batch with so many `workers` on so many `cores`, in the order of the batch. `base` are the bytes that the process
    /// holds without any asset, `waited` the seconds that the probes waited for a processor for each one that they had it
    /// ([`Waiting`](super::Waiting)), if that is known.
    pub fn of(foretold: &[Foretold], workers: usize, cores: usize, base: u64, waited: Option<f64>) -> Self {
        let stages: Vec<StageSeconds> = foretold.iter().map(|f| f.cpu_seconds).collect();
        let cpu: f64 = stages.iter().map(|s| s.total).sum();
        let slowdown = waited.map_or_else(|| slowdown(foretold, cores), |waited| 1.0 + waited);
        let played = play(&stages, workers, cores as f64);
        let squares: f64 = stages.iter().map(|s| s.total * s.total).sum();
        let own = if cpu > 0.0 { OWN * squares.sqrt() / cpu } else { 0.0 };
        let width = (COMMON * COMMON + own * own).sqrt().min(0.3);
        let around =
            |expected: f64| Interval { expected, low: expected * (1.0 - width), high: expected * (1.0 + width) };
        let mut assets: Vec<Entry> = foretold.iter().map(|f| entry(f, cpu)).collect();
        assets.sort_by(|a, b| b.share.total_cmp(&a.share).then_with(|| a.input.cmp(&b.input)));
        Self {
            seconds: around(played.seconds * slowdown),
            cpu_seconds: around(cpu),
            peak_bytes: peak(foretold, &played.together, workers, base),
            slowdown,
            assets,
        }
    }
}

fn entry(foretold: &Foretold, cpu: f64) -> Entry {
    Entry {
        input: foretold.name.clone(),
        share: if cpu > 0.0 { foretold.cpu_seconds.total / cpu } else { 0.0 },
        cpu_seconds: foretold.cpu_seconds,
        spp: foretold.spp,
        bytes: foretold.bytes,
        error_message: foretold.error_message.clone(),
    }
}

/// How much longer a probe takes than its CPU seconds explain on a machine that does nothing else: few tiles do not come out even.
/// Measured: scripts/runs/2026-11-22-plan.md.
const UNEVEN: f64 = 1.1;

/// How much longer the probes took than their CPU seconds explain, where the system does not tell who waited: other work on the machine, and
/// waiting for files.
fn slowdown(foretold: &[Foretold], cores: usize) -> f64 {
    let (mut ideal, mut real) = (0.0, 0.0);
    for Foretold { probe, .. } in foretold {
        let (cpu, wall) = (&probe.cpu_seconds, &probe.seconds);
        ideal += cpu.import + cpu.prepare + cpu.write + (cpu.kdtree + cpu.render) / cores as f64;
        real += wall.import + wall.prepare + wall.write + wall.kdtree + wall.render;
    }
    if ideal > 0.0 { (real / ideal / UNEVEN).max(1.0) } else { 1.0 }
}

fn peak(foretold: &[Foretold], together: &[Vec<usize>], workers: usize, base: u64) -> Option<Interval> {
    let bytes: Vec<u64> = foretold.iter().map(|f| f.bytes).collect::<Option<_>>()?;
    let most_together = together.iter().map(|t| t.iter().map(|i| bytes[*i]).sum::<u64>()).max().unwrap_or(0);
    let mut sorted = bytes.clone();
    sorted.sort_unstable_by(|a, b| b.cmp(a));
    let worst: u64 = sorted.iter().take(workers.max(1)).sum();
    let with_base = |bytes: u64| (base + bytes) as f64;
    Some(Interval {
        expected: with_base(most_together),
        // A probe may find less that was freed before it to take again than the batch does.
        low: 0.85 * with_base(sorted.first().copied().unwrap_or(0)),
        // What was freed is not given back at once.
        high: 1.15 * with_base(worst),
    })
}
