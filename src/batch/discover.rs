use super::job::slashed;
use globset::GlobSet;
use kiln_formats::Format;
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use walkdir::{DirEntry, WalkDir};

/// Where to look for assets.
#[derive(Clone, Debug)]
pub struct Discovery {
    /// Folders to be searched with all that is below them, and files that are taken as they are, whatever their endings and the
    /// patterns.
    pub folders: Vec<PathBuf>,
    /// Only assets whose path below the folder matches, when it is not empty. `*` matches `/` too.
    pub include: GlobSet,
    /// No assets and no folders whose path below the folder matches.
    pub exclude: GlobSet,
    /// A folder that is not searched: the batch's own output.
    pub output: PathBuf,
}

/// An asset's file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Found {
    /// The file.
    pub path: PathBuf,
    /// The folder given under which it was found; `None`: it was given itself.
    pub folder: Option<Arc<Path>>,
    /// Its path below that folder; with several folders, the folder's name is put before it. Of a file that was given, its name.
    pub relative: PathBuf,
}

impl Found {
    /// What the manifest calls it.
    pub fn name(&self) -> String {
        slashed(&self.relative)
    }
}

/// A place that could not be searched.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Unreadable {
    /// The place.
    pub path: PathBuf,
    /// Why.
    pub message: String,
}

/// What a search gave.
#[derive(Clone, Debug, Default)]
pub struct Discovered {
    /// Assets: folder by folder as given, each sorted by names.
    pub found: Vec<Found>,
    /// Places that could not be searched.
    pub unreadable: Vec<Unreadable>,
}

/// Finds the assets: files that end in `.gltf`, `.glb`, `.obj` or `.ray` in any case.
///
/// Links are followed, but not in circles. The order depends on names alone.
pub fn discover(discovery: &Discovery) -> Discovered {
    let mut discovered = Discovered::default();
    for (place, name) in discovery.folders.iter().zip(names(&discovery.folders)) {
        if place.is_file() {
            discovered.found.push(Found { path: place.clone(), folder: None, relative: name });
        } else {
            search(discovery, place, &name, &mut discovered);
        }
    }
    refuse_doubles(&mut discovered);
    discovered
}

/// Takes out assets whose names cannot be told apart when written as text, but for the first.
fn refuse_doubles(discovered: &mut Discovered) {
    if discovered.found.iter().all(|found| found.relative.to_str().is_some()) {
        return;
    }
    let mut names = BTreeSet::new();
    let Discovered { found, unreadable } = discovered;
    found.retain(|asset| {
        let new = names.insert(asset.name());
        if !new {
            let message = format!("another asset is called {} as well", asset.name());
            unreadable.push(Unreadable { path: asset.path.clone(), message });
        }
        new
    });
}

fn search(discovery: &Discovery, folder: &Path, prefix: &Path, discovered: &mut Discovered) {
    let output = discovery.output.canonicalize().ok();
    let shared: Arc<Path> = folder.into();
    let below = |path: &Path| path.strip_prefix(folder).unwrap_or(path).to_path_buf();
    let enter = |entry: &DirEntry| {
        let is_output = || output.is_some() && entry.path().canonicalize().ok() == output;
        let excluded = || discovery.exclude.is_match(below(entry.path()));
        // The folder that was asked for is always searched, even when the pictures go there too.
        entry.depth() == 0 || !(excluded() || entry.file_type().is_dir() && is_output())
    };
    let add = |path: &Path, discovered: &mut Discovered| {
        let relative = below(path);
        if Format::of(path).is_some() && (discovery.include.is_empty() || discovery.include.is_match(&relative)) {
            let relative = prefix.join(relative);
            discovered.found.push(Found { path: path.to_path_buf(), folder: Some(shared.clone()), relative });
        }
    };
    for entry in WalkDir::new(folder).follow_links(true).sort_by_file_name().into_iter().filter_entry(enter) {
        match entry {
            Ok(entry) if entry.file_type().is_dir() => (),
            Ok(entry) => add(entry.path(), discovered),
            Err(error) if error.loop_ancestor().is_some() => (),
            Err(error) => {
                let path = error.path().unwrap_or(folder);
                let dangling = path.symlink_metadata().is_ok_and(|m| m.is_symlink());
                if dangling {
                    // Importing it tells the cause, when it is called like an asset.
                    if !discovery.exclude.is_match(below(path)) {
                        add(path, discovered);
                    }
                } else {
                    let message = error.io_error().map_or_else(|| error.to_string(), ToString::to_string);
                    discovered.unreadable.push(Unreadable { path: path.to_path_buf(), message });
                }
            }
        }
    }
}

/// What keeps the outputs of several places apart: the names of folders and files, counted up where they repeat (`oak.glb` and
/// `oak-2.glb`). Nothing for one folder.
fn names(places: &[PathBuf]) -> Vec<PathBuf> {
    if let [folder] = places
        && !folder.is_file()
    {
        return vec![PathBuf::new()];
    }
    let mut taken = BTreeSet::new();
    let name = |place: &PathBuf| {
        let is_file = place.is_file();
        // A link to a file has the name of the link, whose ending counts; `.` has the name of the folder that it is.
        let whole = if is_file { None } else { place.canonicalize().ok() };
        let path = whole.as_deref().unwrap_or(place);
        let name = PathBuf::from(path.file_name().unwrap_or_else(|| "root".as_ref()));
        let (stem, ending) = if is_file { (name.file_stem(), name.extension()) } else { (name.file_name(), None) };
        let counted = |count: u32| {
            let mut counted = stem.unwrap_or_default().to_os_string();
            if count > 1 {
                counted.push(format!("-{count}"));
            }
            if let Some(ending) = ending {
                counted.push(".");
                counted.push(ending);
            }
            PathBuf::from(counted)
        };
        let mut unique = name.clone();
        let mut count = 1;
        while !taken.insert(unique.clone()) {
            count += 1;
            unique = counted(count);
        }
        unique
    };
    places.iter().map(name).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use globset::{Glob, GlobSetBuilder};
    use std::fs;

    fn globs(patterns: &[&str]) -> GlobSet {
        let mut builder = GlobSetBuilder::new();
        patterns.iter().for_each(|p| {
            builder.add(Glob::new(p).expect("sound"));
        });
        builder.build().expect("sound")
    }

    fn tree(files: &[&str]) -> tempfile::TempDir {
        let folder = tempfile::tempdir().expect("temporary folder");
        for file in files {
            let path = folder.path().join(file);
            fs::create_dir_all(path.parent().expect("below")).expect("folder");
            fs::write(path, b"x").expect("write");
        }
        folder
    }

    fn names(folders: &[PathBuf], include: &[&str], exclude: &[&str]) -> Vec<String> {
        let output = folders[0].join("out");
        let (include, exclude) = (globs(include), globs(exclude));
        let discovery = Discovery { folders: folders.to_vec(), include, exclude, output };
        discover(&discovery).found.iter().map(Found::name).collect()
    }

    #[test]
    fn assets_of_any_case_are_found_in_order() {
        let tree = tree(&["b.OBJ", "a.glb", "c/z.Ray", "c/a.gltf", "c/readme.txt", "out/old.glb", "d.glb/inner.obj"]);
        let folder = [tree.path().to_path_buf()];
        assert_eq!(names(&folder, &[], &[]), ["a.glb", "b.OBJ", "c/a.gltf", "c/z.Ray", "d.glb/inner.obj"]);
        assert_eq!(names(&folder, &["*.gl*"], &[]), ["a.glb", "c/a.gltf", "d.glb/inner.obj"]);
        assert_eq!(names(&folder, &[], &["c", "*.obj"]), ["a.glb", "b.OBJ"]);
        assert_eq!(names(&folder, &["c/*"], &["c/z*"]), ["c/a.gltf"]);
    }

    #[test]
    fn several_folders_are_kept_apart() {
        let tree = tree(&["x/chairs/oak.glb", "y/chairs/oak.glb", "chairs-2/oak.glb"]);
        let folders = ["x/chairs", "y/chairs", "chairs-2"].map(|f| tree.path().join(f));
        assert_eq!(names(&folders, &[], &[]), ["chairs/oak.glb", "chairs-2/oak.glb", "chairs-2-2/oak.glb"]);
    }

    #[test]
    fn files_are_taken_as_they_are() {
        let tree = tree(&["x/oak.glb", "y/oak.glb", "y/ash.obj", "notes.txt"]);
        let places = |list: &[&str]| list.iter().map(|f| tree.path().join(f)).collect::<Vec<_>>();
        let found = |list: &[&str]| names(&places(list), &["*.obj"], &["*.txt"]);
        assert_eq!(found(&["x/oak.glb"]), ["oak.glb"]);
        let want = ["oak.glb", "oak-2.glb", "oak-3.glb", "y/ash.obj", "notes.txt"];
        assert_eq!(found(&["x/oak.glb", "y/oak.glb", "x/oak.glb", "y", "notes.txt"]), want);
    }

    #[cfg(unix)]
    #[test]
    fn circles_and_dangling_links_are_survived() {
        let tree = tree(&["a/oak.glb"]);
        let link = |to: &str, from: &str| std::os::unix::fs::symlink(to, tree.path().join(from)).expect("link");
        link("..", "a/up");
        link("nowhere", "lost.glb");
        link("nowhere", "lost.txt");
        link("a/oak.glb", "linked.glb");
        let folder = [tree.path().to_path_buf()];
        assert_eq!(names(&folder, &[], &[]), ["a/oak.glb", "linked.glb", "lost.glb"]);
    }

    #[test]
    fn a_missing_folder_is_told() {
        let missing = PathBuf::from("/there/is/no/such/folder");
        let (include, exclude) = (GlobSet::empty(), GlobSet::empty());
        let discovery = Discovery { folders: vec![missing.clone()], include, exclude, output: "out".into() };
        let discovered = discover(&discovery);
        assert!(discovered.found.is_empty());
        assert_eq!(discovered.unreadable[0].path, missing);
    }
}
