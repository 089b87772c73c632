use super::failure::{Failure, guarded};
use super::stages::StageClock;
use super::{Job, Outcome, digest, views};
use crate::integrate::View;
use crate::settings::{Background, PathText};
use kiln_formats::{Control, FileRead, ImportError, ImportOptions, Imported, Show, Touched, open};
use std::path::{Component, Path, PathBuf};

/// An asset that has been read.
pub(super) struct Read {
    pub imported: Imported,
    pub views: Result<Vec<View>, Failure>,
    /// Wall and CPU seconds of decoding images and making tangents, which belong to the preparation.
    pub finishing: (f64, f64),
}

/// Reads a job's asset and plans its views. The files behind it are told in any case.
pub(super) fn read(job: &Job, control: &Control) -> (Touched, Result<Read, Failure>) {
    let mut touched = Touched::default();
    let read = guarded(|| {
        let settings = &job.settings;
        let opened = open(&job.input, &options(job, settings.look.show.clone()), control, &mut touched)?;
        let (clock, helped) = (StageClock::begin(), control.helpers_cpu());
        let imported = opened.finish(control, &mut touched)?;
        let (wall, cpu) = clock.seconds();
        let finishing = (wall, cpu + control.helpers_cpu().saturating_sub(helped).as_secs_f64());
        control.check()?;
        let show_environment = settings.pictures.background == Background::Environment;
        let views = views::plan(&imported.scene, &settings.views, show_environment);
        Ok(Read { views: views.map_err(|e| Failure::new("camera", e)), imported, finishing })
    });
    (touched, read.and_then(|read| read))
}

/// Imports a job's asset in one of its looks.
pub(super) fn import(job: &Job, show: Show, control: &Control, touched: &mut Touched) -> Result<Imported, ImportError> {
    open(&job.input, &options(job, show), control, touched)?.finish(control, touched)
}

fn options(job: &Job, show: Show) -> ImportOptions {
    ImportOptions { limits: job.limits, root: job.root.clone(), show, ray: job.settings.look.ray }
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
