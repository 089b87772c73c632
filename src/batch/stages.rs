use super::StageSeconds;
use cpu_time::ThreadTime;
use std::time::Instant;

/// Wall seconds, and CPU seconds of the calling thread, since a stage began.
pub struct StageClock {
    wall: Instant,
    cpu: Option<ThreadTime>,
}

impl StageClock {
    /// Begins a stage on the calling thread.
    pub fn begin() -> Self {
        Self { wall: Instant::now(), cpu: ThreadTime::try_now().ok() }
    }

    /// Wall and CPU seconds so far. Call it on the thread that began the stage.
    pub fn seconds(&self) -> (f64, f64) {
        let cpu = self.cpu.and_then(|c| c.try_elapsed().ok()).map_or(0.0, |d| d.as_secs_f64());
        (self.wall.elapsed().as_secs_f64(), cpu)
    }
}

impl StageSeconds {
    /// The sum of the stages.
    pub fn sum(&self) -> f64 {
        self.import + self.prepare + self.kdtree + self.render + self.write
    }
}

/// Most memory that the process has held at a time, bytes; `None` where the system does not tell.
pub fn peak_bytes() -> Option<u64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find_map(|l| l.strip_prefix("VmHWM:"))?;
    line.trim().strip_suffix("kB")?.trim().parse::<u64>().ok()?.checked_mul(1024)
}

#[cfg(all(test, target_os = "linux"))]
mod tests {
    use super::*;

    #[test]
    fn cpu_time_is_the_threads_own() {
        let clock = StageClock::begin();
        std::thread::sleep(std::time::Duration::from_millis(30));
        let (wall, cpu) = clock.seconds();
        assert!(wall >= 0.03 && cpu < 0.02, "sleeping costs no CPU: {wall} {cpu}");
    }

    #[test]
    fn the_peak_is_plausible() {
        let before = peak_bytes().expect("Linux tells");
        let block = vec![1u8; 64 << 20];
        std::hint::black_box(&block);
        let after = peak_bytes().expect("Linux tells");
        assert!(before > 1 << 20 && after >= 64 << 20);
    }
}
