use super::failure::{Failure, guarded};
use super::{Job, digest, views};
use crate::integrate::View;
use crate::settings::Background;
use kiln_formats::{Control, ImportOptions, Imported, import};

/// An asset that has been read.
pub(super) struct Read {
    pub imported: Imported,
    /// Hash of its files.
    pub content: Result<String, Failure>,
    pub views: Result<Vec<View>, Failure>,
}

/// Reads a job's asset and plans its views.
///
/// # Errors
/// What went wrong before there was a scene.
pub(super) fn read(job: &Job, control: &Control) -> Result<Read, Failure> {
    guarded(|| {
        let settings = &job.settings;
        let (root, show, ray) = (job.root.clone(), settings.look.show.clone(), settings.look.ray);
        let options = ImportOptions { root, show, ray, ..ImportOptions::default() };
        let imported = import(&job.input, &options, control)?;
        let content = digest::of_files(&imported.files, control);
        control.check()?;
        let show_environment = settings.pictures.background == Background::Environment;
        let views = views::plan(&imported.scene, &settings.views, show_environment);
        Ok(Read {
            content: content.map_err(|e| Failure::new("io", format!("cannot be read again: {e}"))),
            views: views.map_err(|e| Failure::new("camera", e)),
            imported,
        })
    })?
}
