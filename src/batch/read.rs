use super::failure::{Failure, guarded};
use super::{Job, Outcome, digest, views};
use crate::integrate::View;
use crate::settings::{Background, PathText};
use kiln_formats::{Control, FileRead, ImportError, ImportOptions, Imported, Show, Touched, import_noting};
use std::path::{Component, Path, PathBuf};

/// An asset that has been read.
pub(super) struct Read {
    pub imported: Imported,
    pub views: Result<Vec<View>, Failure>,
}

/// Reads a job's asset and plans its views. The files behind it are told in any case.
pub(super) fn read(job: &Job, control: &Control) -> (Touched, Result<Read, Failure>) {
    let mut touched = Touched::default();
    let read = guarded(|| {
        let settings = &job.settings;
        let imported = import(job, settings.look.show.clone(), control, &mut touched)?;
        control.check()?;
        let show_environment = settings.pictures.background == Background::Environment;
        let views = views::plan(&imported.scene, &settings.views, show_environment);
        Ok(Read { views: views.map_err(|e| Failure::new("camera", e)), imported })
    });
    (touched, read.and_then(|read| read))
}

/// Imports a job's asset in one of its looks.
pub(super) fn import(job: &Job, show: Show, control: &Control, touched: &mut Touched) -> Result<Imported, ImportError> {
    let (root, ray, limits) = (job.root.clone(), job.settings.look.ray, job.limits);
    import_noting(&job.input, &ImportOptions { limits, root, show, ray }, control, touched)
}

/// Tells in an outcome which files an asset is made of.
pub(super) fn note(outcome: &mut Outcome, job: &Job, touched: &Touched) {
    let Some((asset, others)) = touched.read.split_first() else { return };
    // By its own name, for that may be a link that leads elsewhere another day.
    let name = job.input.file_name().map_or_else(|| asset.path.clone(), PathBuf::from);
    outcome.content = Some(digest::of_read(&touched.read));
    let folder = asset.path.parent().unwrap_or(Path::new(""));
    let seen = |path: &Path| PathText(seen_from(folder, path));
    outcome.files = std::iter::once(PathText(name)).chain(others.iter().map(|f: &FileRead| seen(&f.path))).collect();
    outcome.missing = touched.missing.iter().map(|path| seen(path)).collect();
}

/// A path as seen from a folder, both absolute.
fn seen_from(folder: &Path, path: &Path) -> PathBuf {
    let shared = folder.components().zip(path.components()).take_while(|(a, b)| a == b).count();
    let named = |c: &Component| matches!(c, Component::Normal(_));
    // Having nothing but the root in common is having nothing in common.
    if !folder.components().take(shared).any(|c| named(&c)) {
        return path.to_path_buf();
    }
    let up = folder.components().skip(shared).map(|_| Component::ParentDir);
    up.chain(path.components().skip(shared)).collect()
}

#[cfg(all(test, unix))]
mod tests {
    use super::*;

    #[test]
    fn paths_are_seen_from_the_assets_folder() {
        let seen = |path: &str| seen_from(Path::new("/lib/chairs"), Path::new(path));
        assert_eq!(seen("/lib/chairs/wood.png"), Path::new("wood.png"));
        assert_eq!(seen("/lib/shared/wood.png"), Path::new("../shared/wood.png"));
        assert_eq!(seen("/lib/chairs2/wood.png"), Path::new("../chairs2/wood.png"));
        assert_eq!(seen("/srv/wood.png"), Path::new("/srv/wood.png"));
    }
}
