//! Memory of this process: how much it holds, and how much it may.

use super::machine::kilobytes;
use std::fs;
use std::io;

/// Bytes held now; `None` where the system does not tell.
pub fn held_bytes() -> Option<u64> {
    kilobytes(&fs::read_to_string("/proc/self/status").ok()?, "VmRSS:")
}

/// Begins the peak anew, so that it is the peak of what follows.
pub fn forget_peak() {
    // Where this cannot be written the peak is that of the whole process: too much rather than too little.
    let _ = fs::write("/proc/self/clear_refs", "5");
}

/// Lets the process have so many bytes more than it has now; what would go beyond is refused by the system.
///
/// On Linux this bounds the writable private memory (`RLIMIT_DATA`) and not the address space, of which threads and
/// allocators reserve much more than they use; elsewhere it is the address space (`RLIMIT_AS`).
///
/// # Errors
/// When the system has no such limit, or refuses it.
#[cfg(unix)]
pub fn bound_memory(bytes: u64) -> io::Result<()> {
    use nix::sys::resource::{Resource, getrlimit, setrlimit};
    let text = fs::read_to_string("/proc/self/status").unwrap_or_default();
    let (resource, held) = match kilobytes(&text, "VmData:") {
        Some(held) => (Resource::RLIMIT_DATA, held),
        None => (Resource::RLIMIT_AS, 0),
    };
    let (_, hard) = getrlimit(resource)?;
    let limit = bytes.saturating_add(held).min(hard);
    Ok(setrlimit(resource, limit, hard)?)
}

/// Not there.
///
/// # Errors
/// Always.
#[cfg(not(unix))]
pub fn bound_memory(_: u64) -> io::Result<()> {
    Err(io::Error::new(io::ErrorKind::Unsupported, "this system has no such limit"))
}
