use std::path::PathBuf;
use std::time::Duration;

/// How assets are kept apart.
#[derive(Clone, Debug)]
pub struct Isolation {
    /// The program that is started as `PROGRAM worker`: Kiln.
    pub program: PathBuf,
    /// Threads that each worker renders with, ≥ 1.
    pub threads: usize,
    /// Bytes that one asset may take, enforced by the system; `None`: what there is.
    pub memory: Option<u64>,
    /// Bytes for a second try, alone, of assets that ran out of memory beside others; `None`: there is none.
    pub alone: Option<u64>,
    /// An asset that takes longer is killed; `None`: however long it takes.
    pub timeout: Option<Duration>,
    /// An asset that shows no progress for so long is killed.
    pub patience: Duration,
    /// A file on which workers hold a shared lock, so that one can wait for the last of them to be gone.
    pub presence: Option<PathBuf>,
}

impl Isolation {
    /// How long an asset may show no progress unless told otherwise: the longest stage that tells none, the kd-tree of a
    /// hundred million triangles, takes a fraction of that.
    pub const PATIENCE: Duration = Duration::from_secs(600);

    /// The running program itself, even when its file has been replaced meanwhile.
    ///
    /// # Errors
    /// When the system does not tell where it is.
    pub fn this_program() -> std::io::Result<PathBuf> {
        let itself = PathBuf::from("/proc/self/exe");
        if itself.exists() { Ok(itself) } else { std::env::current_exe() }
    }

    /// Threads for each of `jobs` workers on `cores` cores: all of them, where that is not many more than there are cores.
    ///
    /// With one thread each the last assets of a batch would leave cores idle; more than four times too many cost time.
    pub fn threads_each(cores: usize, jobs: usize) -> usize {
        cores.div_ceil(jobs.max(1)).max(4).min(cores.max(1))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn threads_suit_cores_and_jobs() {
        let each = Isolation::threads_each;
        assert_eq!([each(1, 1), each(2, 1), each(2, 2), each(64, 64), each(64, 8), each(64, 1)], [1, 2, 2, 4, 8, 64]);
    }
}
