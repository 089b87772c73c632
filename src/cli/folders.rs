use super::console::harmless;
use super::exit::Fatal;
use clap::Args;
use globset::{Glob, GlobSet, GlobSetBuilder};
use kiln::batch::{Discovered, Discovery, Found, Job, Output, Unreadable, discover};
use kiln::formats::Limits;
use kiln::settings::Settings;
use std::path::{Path, PathBuf};

/// Which assets a batch is about.
#[derive(Args, Clone, Debug)]
pub struct Folders {
    /// Folders that are searched for .gltf, .glb, .obj and .ray files, and such files themselves
    #[arg(required = true, value_name = "DIR|FILE")]
    folders: Vec<PathBuf>,
    /// Only assets whose path below the folder matches (may be repeated; * matches / too)
    #[arg(long, value_name = "GLOB", value_parser = |text: &str| Glob::new(text))]
    include: Vec<Glob>,
    /// No assets and no folders whose path below the folder matches (may be repeated)
    #[arg(long, value_name = "GLOB", value_parser = |text: &str| Glob::new(text))]
    exclude: Vec<Glob>,
}

impl Folders {
    /// Finds the assets, and tells of places that cannot be searched.
    ///
    /// # Errors
    /// When there are no assets.
    pub fn search(&self, out: &Path) -> Result<Discovered, Fatal> {
        let discovered = discover(&self.discovery(out)?);
        for Unreadable { path, message } in &discovered.unreadable {
            eprintln!("warning: {} cannot be searched: {message}", harmless(&path.display().to_string()));
        }
        if discovered.found.is_empty() {
            let folders: Vec<String> = self.folders.iter().map(|f| f.display().to_string()).collect();
            let matching = if self.include.is_empty() && self.exclude.is_empty() { "" } else { " that matches" };
            return Err(Fatal::failed(format!(
                "no .gltf, .glb, .obj or .ray file{matching} below {}",
                folders.join(", ")
            )));
        }
        Ok(discovered)
    }

    /// As [`Self::search`], with nothing told.
    pub fn look(&self, out: &Path) -> Discovered {
        self.discovery(out).map_or_else(|_| Discovered::default(), |discovery| discover(&discovery))
    }

    fn discovery(&self, out: &Path) -> Result<Discovery, Fatal> {
        Ok(Discovery {
            folders: self.folders.clone(),
            include: globs(&self.include)?,
            exclude: globs(&self.exclude)?,
            output: out.to_path_buf(),
        })
    }
}

/// The job of an asset that was found.
pub fn job(found: &Found, root: Option<&Path>, out: &Path, limits: Limits, settings: &Settings) -> Job {
    Job {
        input: found.path.clone(),
        name: found.name(),
        root: root.or(found.folder.as_deref()).map(Path::to_path_buf),
        limits,
        output: Output { folder: out.to_path_buf(), stem: found.name().into(), ending: None },
        settings: settings.clone(),
    }
}

fn globs(patterns: &[Glob]) -> Result<GlobSet, Fatal> {
    let mut set = GlobSetBuilder::new();
    patterns.iter().for_each(|glob| {
        set.add(glob.clone());
    });
    set.build().map_err(|e| Fatal::usage(format!("the globs together: {e}")))
}
