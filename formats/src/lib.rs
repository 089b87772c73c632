//! Bytes in, [`Scene`] out: the only place that reads scene files.
//!
//! [`import`] reads a `.gltf`, `.glb`, `.obj` or `.ray` file with everything that it refers to and gives one
//! validated [`Scene`], warnings about what it could not honour, or an error that names the place.

mod contents;
mod control;
mod dds;
mod error;
pub mod gltf;
pub mod images;
mod limits;
pub mod obj;
pub mod parallel;
pub mod ray;
pub mod repair;
pub mod resources;
pub mod scene;
mod show;
mod straight;
pub mod support;

pub use contents::{Clip, Contents, SourceMaterial};
pub use control::{Control, Stopped};
pub use error::{ErrorCode, ImportError, Place, Warning};
pub use limits::Limits;
pub use resources::{FileRead, Resources, Touched};
pub use scene::Scene;
pub use show::Show;

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::{Path, PathBuf};

/// A file format that Kiln imports.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Format {
    /// glTF 2.0, `.gltf` or `.glb`.
    Gltf,
    /// Wavefront OBJ with MTL.
    Obj,
    /// `SBT-raytracer` scene.
    Ray,
}

impl Format {
    /// The format by the file's ending, in any case.
    pub fn of(path: &Path) -> Option<Self> {
        match path.extension()?.to_str()?.to_ascii_lowercase().as_str() {
            "gltf" | "glb" => Some(Self::Gltf),
            "obj" => Some(Self::Obj),
            "ray" => Some(Self::Ray),
            _ => None,
        }
    }
}

/// How to import.
#[derive(Clone, Debug, Default)]
pub struct ImportOptions {
    /// Bounds on sizes.
    pub limits: Limits,
    /// The folder that references may not leave; by default the parent of the asset's folder.
    pub root: Option<PathBuf>,
    /// Which of its looks to show.
    pub show: Show,
    /// How `.ray` files are taken.
    pub ray: ray::RayOptions,
}

/// What one asset gives.
#[derive(Clone, Debug)]
pub struct Imported {
    /// The scene; passes [`Scene::validate`].
    pub scene: Scene,
    /// What was mended or left out.
    pub warnings: Vec<Warning>,
    /// Canonical paths of all files read, the asset first.
    pub files: Vec<PathBuf>,
    /// What the file says about itself.
    pub contents: Contents,
}

/// Reads an asset.
///
/// # Errors
/// [`ImportError`] when nothing can be shown. Never panics: a panic in a third-party decoder becomes
/// [`ErrorCode::Internal`].
pub fn import(path: &Path, options: &ImportOptions, control: &Control) -> Result<Imported, ImportError> {
    read(path, options, control, &mut Touched::default(), Wanted::Scene)
}

/// An asset whose files have been read, with its geometry: as far as importers of editors go, which leave images encoded until something is drawn.
/// What only pixels need is left to [`Opened::finish`].
#[derive(Debug)]
pub struct Opened {
    state: State,
    resources: Resources,
    contents: Contents,
    warnings: Vec<Warning>,
    wanted: Wanted,
}

enum State {
    Gltf(Box<gltf::Opened>),
    /// Nothing is left to be done.
    Whole(Scene),
}

impl std::fmt::Debug for State {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(if matches!(self, Self::Gltf(_)) { "Gltf" } else { "Whole" })
    }
}

/// Does the first part of [`import()`]: reads the files and the geometry. Images of glTF files stay encoded, and meshes without the tangents that they do not
/// bring. `touched` is told of the files that were read and looked for, whether it goes well or not.
///
/// # Errors
/// As [`import()`].
pub fn open(
    path: &Path,
    options: &ImportOptions,
    control: &Control,
    touched: &mut Touched,
) -> Result<Opened, ImportError> {
    open_for(path, options, control, touched, Wanted::SceneAndHashes)
}

impl Opened {
    /// Does the rest: tangents and images. `touched` is then complete.
    ///
    /// # Errors
    /// As [`import()`].
    pub fn finish(self, control: &Control, touched: &mut Touched) -> Result<Imported, ImportError> {
        let Self { state, mut resources, contents, mut warnings, wanted } = self;
        let run = AssertUnwindSafe(|| match state {
            State::Gltf(opened) => opened.finish(&mut resources, &mut warnings, control),
            State::Whole(scene) => Ok(scene),
        });
        let finished = catch_unwind(run);
        *touched = resources.touched();
        let scene = finished.unwrap_or_else(|_| Err(panicked()))?;
        let sound = if wanted == Wanted::Survey { scene.validate_but_images() } else { scene.validate() };
        sound.map_err(|e| ImportError::new(ErrorCode::Internal, format!("importer made an invalid scene: {e}")))?;
        let limit = resources.limits().max_triangles;
        if scene.triangle_count() > limit {
            let message = format!("{} triangles exceed the limit of {limit}", scene.triangle_count());
            return Err(ImportError::new(ErrorCode::TooLarge, message));
        }
        Ok(Imported { scene, warnings, files: touched.read.iter().map(|file| file.path.clone()).collect(), contents })
    }
}

fn panicked() -> ImportError {
    ImportError::new(ErrorCode::Internal, "a decoder panicked on this file")
}

/// An asset as its files describe it, read to be told of and not to be shown: images of glTF files are known by their headers, and no tangents are
/// made (which would double vertices at seams).
#[derive(Clone, Debug)]
pub struct Survey(Imported);

impl Survey {
    /// What was found. The scene is sound but for its images: where only the header was read, they have a size and a kind of pixels, but no pixels.
    pub fn found(&self) -> &Imported {
        &self.0
    }
}

/// Reads an asset as [`import()`] does, but decodes no image that geometry and materials don't depend on, and makes no tangents. Damaged images and normal maps
/// that cannot be used are not noticed then.
///
/// # Errors
/// As [`import()`].
pub fn survey(path: &Path, options: &ImportOptions, control: &Control) -> Result<Survey, ImportError> {
    read(path, options, control, &mut Touched::default(), Wanted::Survey).map(Survey)
}

/// What an asset is read for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Wanted {
    SceneAndHashes,
    Scene,
    Survey,
}

fn read(
    path: &Path,
    options: &ImportOptions,
    control: &Control,
    touched: &mut Touched,
    wanted: Wanted,
) -> Result<Imported, ImportError> {
    open_for(path, options, control, touched, wanted)?.finish(control, touched)
}

fn open_for(
    path: &Path,
    options: &ImportOptions,
    control: &Control,
    touched: &mut Touched,
    wanted: Wanted,
) -> Result<Opened, ImportError> {
    let format = Format::of(path)
        .ok_or_else(|| ImportError::new(ErrorCode::UnknownFormat, "is not a .gltf, .glb, .obj or .ray file"))?;
    let mut resources = Resources::new(path, options.root.as_deref(), options.limits)?;
    if wanted != Wanted::SceneAndHashes {
        resources.skip_hashes();
    }
    if wanted == Wanted::Survey {
        resources.only_survey();
    }
    let (mut warnings, mut contents) = (Vec::new(), Contents::default());
    let run = AssertUnwindSafe(|| {
        let bytes = resources.read_asset(path)?;
        match format {
            Format::Gltf => {
                let opened = gltf::open(bytes, &mut resources, &options.show, &mut contents, &mut warnings, control)?;
                Ok(State::Gltf(Box::new(opened)))
            }
            Format::Obj => obj::import(bytes, &mut resources, &mut warnings, control).map(State::Whole),
            Format::Ray => ray::import(bytes, &mut resources, options.ray, &mut warnings, control).map(State::Whole),
        }
    });
    let opened = catch_unwind(run);
    *touched = resources.touched();
    let state = opened.unwrap_or_else(|_| Err(panicked()))?;
    Ok(Opened { state, resources, contents, warnings, wanted })
}
