//! Real files from several projects; skipped where there are none (environment variable `KILN_SHARED`).

#![allow(clippy::disallowed_methods, reason = "expected values may come from std's functions")]

mod shared;

use kiln_formats::{Control, ErrorCode, ImportOptions, import};
use shared::shared;
use std::path::{Path, PathBuf};
use std::time::Instant;

fn files_below(folder: &Path, found: &mut Vec<PathBuf>) {
    let mut entries: Vec<PathBuf> = folder.read_dir().unwrap().map(|e| e.unwrap().path()).collect();
    entries.sort();
    for path in entries {
        if path.is_dir() {
            files_below(&path, found);
        } else if path.extension().is_some_and(|e| e.eq_ignore_ascii_case("obj")) {
            found.push(path);
        }
    }
}

/// Sum of (corners − 2) over the faces, by a reader that shares nothing with the importer but the idea.
fn naive_triangle_count(path: &Path) -> Option<u64> {
    let text = String::from_utf8(std::fs::read(path).unwrap()).ok()?.replace("\\\r\n", " ").replace("\\\n", " ");
    let corners = |line: &str| {
        let line = line.split('#').next().unwrap().trim();
        let mut words = line.split_whitespace();
        (words.next() == Some("f")).then(|| words.count() as u64)
    };
    Some(text.lines().filter_map(corners).map(|n| n.saturating_sub(2)).sum())
}

#[test]
fn good_files_import_with_all_their_triangles() {
    let Some(folder) = shared("assets/obj") else { return };
    let mut files = Vec::new();
    files_below(&folder, &mut files);
    files_below(&folder.join("../../scenes/bench"), &mut files);
    assert!(files.len() >= 70, "only {} files", files.len());
    let mut counted = 0;
    for path in &files {
        let shown = path.strip_prefix(&folder).unwrap_or(path).display();
        let naive = naive_triangle_count(path);
        match import(path, &ImportOptions::default(), &Control::default()) {
            Ok(imported) => {
                let warnings: Vec<String> =
                    imported.warnings.iter().map(|w| format!("{} {}: {}", w.code, w.place, w.message)).collect();
                println!("{shown}: {} triangles, {warnings:#?}", imported.scene.triangle_count());
                let damaged = imported.warnings.iter().any(|w| w.code == "bad-index" || w.code == "bad-face");
                if let Some(naive) = naive.filter(|_| !damaged) {
                    assert_eq!(imported.scene.triangle_count(), naive, "{shown}");
                    counted += 1;
                }
            }
            Err(error) => {
                println!("{shown}: {error} ({})", error.code.as_str());
                // This one lists no positions; the others have no faces.
                if path.ends_with("box-incomplete-positions.obj") {
                    assert_eq!(error.code, ErrorCode::Invalid, "{shown}");
                } else {
                    assert_eq!((error.code, naive), (ErrorCode::Empty, Some(0)), "{shown}");
                }
            }
        }
    }
    assert!(counted >= 65, "only {counted} counted");
}

#[test]
fn malformed_files_end_soon_and_never_in_an_internal_error() {
    let Some(folder) = shared("assets/malformed") else { return };
    let mut files = Vec::new();
    files_below(&folder, &mut files);
    assert!(files.len() >= 20, "only {} files", files.len());
    for path in &files {
        let start = Instant::now();
        let result = import(path, &ImportOptions::default(), &Control::default());
        assert!(start.elapsed().as_secs_f64() < 5.0, "{}", path.display());
        match result {
            Ok(imported) => {
                println!("{}: {} triangles, {:?}", path.display(), imported.scene.triangle_count(), imported.warnings)
            }
            Err(error) => {
                println!("{}: {error} ({})", path.display(), error.code.as_str());
                assert_ne!(error.code, ErrorCode::Internal, "{}: {error}", path.display());
            }
        }
    }
}
