//! Assets and scenes that are not part of the repository.

use std::path::{Path, PathBuf};

/// A folder below the one that `KILN_SHARED` names, or `None` when that is unset: then the test says that it skips,
/// and fails where `KILN_REQUIRE_SHARED` forbids that.
pub fn shared(folder: &str) -> Option<PathBuf> {
    let Some(root) = std::env::var_os("KILN_SHARED") else {
        println!("skipped: {folder} needs KILN_SHARED");
        assert!(std::env::var_os("KILN_REQUIRE_SHARED").is_none(), "KILN_SHARED is not set");
        return None;
    };
    Some(Path::new(&root).join(folder))
}
