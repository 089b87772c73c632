use super::exit::Fatal;
use clap::{Args, value_parser};
use kiln::batch::workers::{Isolation, available_memory};
use kiln::formats::Limits;
use std::path::PathBuf;
use std::time::Duration;

/// What is held to be enough memory for most assets: fewer are worked on at a time where there is less for each.
const ENOUGH: u64 = 2 << 30;
/// The share of the free memory that assets may take together.
const SHARE: f64 = 0.9;
/// Time that an asset with a deadline may take beyond it before it is killed: so many times as long, and seconds.
const LATE: (f64, f64) = (2.0, 30.0);

/// How a batch holds out against bad assets.
#[derive(Args, Clone, Debug)]
pub struct IsolationOptions {
    /// Assets worked on at a time [default: the number of threads, or fewer where memory is short]
    #[arg(long, value_name = "N", value_parser = value_parser!(u16).range(1..=4096), help_heading = "Isolation")]
    jobs: Option<u16>,
    /// Memory that an asset may take, as 800M or 4G [default: its share of what is free; alone, all of it]
    #[arg(long, value_name = "SIZE", value_parser = size, help_heading = "Isolation")]
    pub memory: Option<u64>,
    /// Kill an asset after so many seconds [default: when nothing has moved for 10 minutes]
    #[arg(long, value_name = "SECONDS", value_parser = super::options::positive, help_heading = "Isolation")]
    pub timeout: Option<f64>,
    /// Refuse assets with more triangles
    #[arg(long, value_name = "N", default_value_t = Limits::default().max_triangles, hide_default_value = true, help_heading = "Isolation")]
    max_triangles: u64,
    /// Refuse assets whose images have more texels together
    #[arg(long, value_name = "N", default_value_t = Limits::default().max_texels, hide_default_value = true, help_heading = "Isolation")]
    max_texels: u64,
    /// Work in this process instead of worker processes: a crash ends everything, and no asset can be killed
    #[arg(long, conflicts_with_all = ["memory", "timeout"], help_heading = "Isolation")]
    pub in_process: bool,
}

/// A number of bytes: digits, with K, M, G or T for powers of 1024.
fn size(text: &str) -> Result<u64, String> {
    let upper = text.trim().to_ascii_uppercase();
    let plain = upper.trim_end_matches('B').trim_end_matches('I');
    let (digits, power) = match plain.char_indices().next_back() {
        Some((at, unit)) if "KMGT".contains(unit) => (&plain[..at], 1 + "KMGT".find(unit).unwrap_or(0) as u32),
        _ => (plain, 0),
    };
    let number = digits.trim().parse::<f64>().ok().filter(|x| x.is_finite() && *x > 0.0);
    let bytes = number.map(|x| x * (1u64 << (10 * power)) as f64);
    bytes.map(|b| b as u64).ok_or_else(|| format!("'{text}' is not a size such as 800M or 4G"))
}

impl IsolationOptions {
    /// How large assets may be.
    pub fn limits(&self) -> Limits {
        Limits { max_triangles: self.max_triangles, max_texels: self.max_texels, ..Limits::default() }
    }

    /// How many assets to work on at a time, of `count`, on so many cores.
    pub fn jobs(&self, cores: usize, count: usize) -> usize {
        let room = || available_memory().map_or(usize::MAX, |free| ((SHARE * free as f64) as u64 / ENOUGH) as usize);
        let jobs = self.jobs.map_or_else(|| if self.in_process { cores } else { cores.min(room()) }, usize::from);
        jobs.clamp(1, count.max(1))
    }

    /// The worker processes, each with so many cores' threads at most; `time`: the deadline of an asset.
    ///
    /// # Errors
    /// When the program does not find itself.
    pub fn isolation(
        &self,
        cores: usize,
        jobs: usize,
        time: Option<f64>,
        presence: PathBuf,
    ) -> Result<Isolation, Fatal> {
        let program =
            Isolation::this_program().map_err(|e| Fatal::failed(format!("kiln does not find itself: {e}")))?;
        let free = available_memory().map(|free| (SHARE * free as f64) as u64);
        let timeout = self.timeout.or(time.map(|time| LATE.0 * time + LATE.1));
        let patience = self.timeout.map_or(Isolation::PATIENCE, Duration::from_secs_f64);
        Ok(Isolation {
            program,
            threads: Isolation::threads_each(cores, jobs),
            memory: self.memory.or(free.map(|free| free / jobs as u64)),
            alone: free.filter(|_| self.memory.is_none() && jobs > 1),
            timeout: timeout.and_then(|seconds| Duration::try_from_secs_f64(seconds).ok()),
            patience,
            presence: Some(presence),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sizes_have_units() {
        assert_eq!(size("4G"), Ok(4 << 30));
        assert_eq!(size("1.5GiB"), Ok(3 << 29));
        assert_eq!(size("800 mb"), Ok(800 << 20));
        assert_eq!(size("12345"), Ok(12345));
        for wrong in ["", "G", "-1G", "4X", "nan", "many"] {
            assert!(size(wrong).is_err(), "{wrong}");
        }
    }
}
