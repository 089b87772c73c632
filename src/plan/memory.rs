//! Memory of this process, as Linux tells it.

use std::fs;

/// Bytes held now; `None` where the system does not tell.
pub fn held() -> Option<u64> {
    let status = fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find_map(|l| l.strip_prefix("VmRSS:"))?;
    line.trim().strip_suffix("kB")?.trim().parse::<u64>().ok()?.checked_mul(1024)
}

/// Begins the peak anew, so that it is the peak of what follows.
pub(super) fn forget_peak() {
    // Where this cannot be written the peak is that of the whole process: too much rather than too little.
    let _ = fs::write("/proc/self/clear_refs", "5");
}
