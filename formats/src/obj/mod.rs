//! The obj importer.

use crate::{Control, ErrorCode, ImportError, Resources, Scene, Warning};

/// Reads the bytes of a file and what it refers to.
///
/// # Errors
/// [`ImportError`] when nothing can be shown.
pub fn import(
    _bytes: Vec<u8>,
    _resources: &mut Resources,
    _warnings: &mut Vec<Warning>,
    _control: &Control,
) -> Result<Scene, ImportError> {
    Err(ImportError::new(ErrorCode::Unsupported, "this format is not read yet"))
}
