//! What `kiln inspect --rays` measures and tells.

use super::exit::Fatal;
use clap::Args;
use kiln::measure::{Measured, Tracing, measure_file, measure_set, parse, sets};
use kiln::prepare::PreparedScene;
use serde_json::{Value, json};
use std::path::PathBuf;

/// Options of `kiln inspect` about rays.
#[derive(Args)]
pub struct RayOptions {
    /// Measure rays a second: of a camera, a bounce and shadows; or those of FILE, in the asset's coordinates (u32 n, then n × ox
    /// oy oz tnear dx dy dz tfar, f32, little-endian)
    #[arg(long, value_name = "FILE", num_args = 0..=1)]
    rays: Option<Option<PathBuf>>,
    /// Ask whether the rays of FILE meet anything, not what they meet first
    #[arg(long, requires = "rays")]
    any_hit: bool,
    /// Trace rays in batches, many in flight, instead of one by one
    #[arg(long, requires = "rays")]
    stream: bool,
    /// Threads that trace
    #[arg(long, requires = "rays", default_value_t = 1, value_parser = clap::value_parser!(u16).range(1..=1024))]
    threads: u16,
}

/// What was measured.
pub enum RayReport {
    /// Sets of Kiln's own, by name.
    Sets(Vec<(&'static str, Measured)>),
    /// The rays of a file.
    File(Measured),
}

impl RayOptions {
    fn tracing(&self) -> Tracing {
        Tracing { any_hit: self.any_hit, stream: self.stream, threads: self.threads.into() }
    }

    /// Traces the rays.
    ///
    /// # Errors
    /// When the file cannot be read.
    pub fn measure(&self, prepared: &PreparedScene) -> Result<Option<RayReport>, Fatal> {
        let Some(file) = &self.rays else { return Ok(None) };
        let Some(file) = file else {
            let measured = |set| measure_set(prepared, set, self.tracing());
            return Ok(Some(RayReport::Sets(sets(prepared).iter().map(|set| (set.name, measured(set))).collect())));
        };
        let failed = |e: String| Fatal::failed(format!("{}: {e}", file.display()));
        let bytes = std::fs::read(file).map_err(|e| failed(e.to_string()))?;
        let rays = parse(&bytes).map_err(|e| failed(e.to_string()))?;
        Ok(Some(RayReport::File(measure_file(prepared, &rays, self.tracing()))))
    }

    /// Adds what was measured to the JSON of the asset.
    pub fn tell_json(&self, report: &RayReport, build_seconds: f64, object: &mut serde_json::Map<String, Value>) {
        let how = [("stream", json!(self.stream)), ("threads", json!(self.threads))];
        object.extend(how.map(|(key, value)| (key.to_string(), value)));
        object.insert("build_seconds".into(), build_seconds.into());
        match report {
            RayReport::Sets(sets) => {
                let named = sets.iter().map(|(name, measured)| (name.to_string(), json!(measured)));
                object.insert("ray_sets".into(), Value::Object(named.collect()));
            }
            RayReport::File(measured) => {
                object.insert("any_hit".into(), self.any_hit.into());
                if let Value::Object(fields) = json!(measured) {
                    object.extend(fields);
                }
            }
        }
    }

    /// Lines for people.
    pub fn tell(&self, report: &RayReport) -> Vec<String> {
        let line = |name: &str, m: &Measured| {
            let share = 100.0 * m.hits as f64 / m.rays.max(1) as f64;
            let how = if self.stream { "in batches" } else { "one by one" };
            format!(
                "  {name:8} {:8.2} million rays per CPU second {how}; {} rays, {share:.1} % hit, mean distance {:.6}",
                m.mrays_per_cpu_second, m.rays, m.mean_t
            )
        };
        let threads = if self.threads == 1 { "1 thread".into() } else { format!("{} threads", self.threads) };
        let mut lines = vec![format!("rays       on {threads}, the best of several passes")];
        match report {
            RayReport::Sets(sets) => lines.extend(sets.iter().map(|(name, measured)| line(name, measured))),
            RayReport::File(measured) => lines.push(line("file", measured)),
        }
        lines
    }
}
