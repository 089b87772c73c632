use std::fs;
use std::path::{Path, PathBuf};

/// Bytes of memory that are free for new work, within the limit of the control group (container, batch system) that the
/// process runs in; `None` where the system does not tell.
pub fn available_memory() -> Option<u64> {
    let text = fs::read_to_string("/proc/meminfo").ok()?;
    let free = kilobytes(&text, "MemAvailable:")?;
    Some(cgroup_room().map_or(free, |room| room.min(free)))
}

/// The number after a word in the texts of `/proc`, in bytes.
pub(super) fn kilobytes(text: &str, word: &str) -> Option<u64> {
    let line = text.lines().find_map(|l| l.strip_prefix(word))?;
    line.trim().strip_suffix("kB")?.trim().parse::<u64>().ok()?.checked_mul(1024)
}

/// What the control groups of the process (version 2) leave to it: the least of all levels.
fn cgroup_room() -> Option<u64> {
    let own = fs::read_to_string("/proc/self/cgroup").ok()?;
    let path = own.lines().find_map(|line| line.strip_prefix("0::"))?;
    let root = Path::new("/sys/fs/cgroup");
    let own: PathBuf = root.join(path.trim_start_matches('/'));
    let number = |file: PathBuf| fs::read_to_string(file).ok()?.trim().parse::<u64>().ok();
    let room =
        |folder: &Path| Some(number(folder.join("memory.max"))?.saturating_sub(number(folder.join("memory.current"))?));
    own.ancestors().take_while(|folder| folder.starts_with(root)).filter_map(room).min()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_found() {
        let text = "MemTotal:   10 kB\nMemAvailable:    7 kB\n";
        assert_eq!(kilobytes(text, "MemAvailable:"), Some(7 * 1024));
        assert_eq!(kilobytes(text, "MemFree:"), None);
    }

    #[cfg(target_os = "linux")]
    #[test]
    fn there_is_memory() {
        assert!(available_memory().is_some_and(|bytes| bytes > 1 << 20));
    }
}
