//! Dependencies between modules point one way.

#![allow(clippy::disallowed_methods, reason = "expected values may come from std's functions")]

use std::fs;
use std::path::{Path, PathBuf};

/// Each module of the crate and the modules that it may use.
const ARROWS: &[(&str, &[&str])] = &[
    ("cpu_clock", &[]),
    ("math", &[]),
    ("lanes", &["math"]),
    ("settings", &["math"]),
    ("geometry", &["lanes", "math"]),
    ("sampling", &["lanes", "math", "settings"]),
    ("shading", &["lanes", "math"]),
    ("film", &["sampling"]),
    ("lighting", &["geometry", "lanes", "math", "sampling", "settings"]),
    ("effects", &["geometry", "settings"]),
    ("prepare", &["cpu_clock", "effects", "geometry", "lanes", "lighting", "math", "settings", "shading"]),
    ("denoise", &["film"]),
    (
        "integrate",
        &["cpu_clock", "film", "geometry", "lanes", "lighting", "math", "prepare", "sampling", "settings", "shading"],
    ),
    ("write", &["film", "lanes", "math", "sampling", "settings"]),
    ("metrics", &["film", "settings", "write"]),
    ("gallery", &["metrics", "write"]),
    ("accuracy", &["cpu_clock", "film", "integrate", "lanes", "math", "prepare", "sampling", "settings", "write"]),
    ("batch", &["accuracy", "denoise", "film", "geometry", "integrate", "math", "prepare", "settings", "write"]),
    ("plan", &["batch", "settings"]),
    (
        "lab",
        &[
            "accuracy",
            "batch",
            "cpu_clock",
            "denoise",
            "film",
            "integrate",
            "math",
            "metrics",
            "prepare",
            "sampling",
            "settings",
            "write",
        ],
    ),
    ("checks", &["film", "integrate", "math", "prepare", "settings"]),
    ("measure", &["geometry", "math", "prepare"]),
    ("cli", &["batch", "checks", "denoise", "gallery", "lab", "measure", "metrics", "plan", "settings", "write"]),
];

fn rust_files(folder: &Path, found: &mut Vec<PathBuf>) {
    for entry in fs::read_dir(folder).expect("a folder of sources") {
        let path = entry.expect("an entry").path();
        if path.is_dir() {
            rust_files(&path, found);
        } else if path.extension().is_some_and(|e| e == "rs") {
            found.push(path);
        }
    }
}

/// Modules named as `crate::NAME` in a source text, comments left out.
fn used_modules(text: &str) -> Vec<String> {
    let code = text.lines().filter(|l| !l.trim_start().starts_with("//")).collect::<Vec<_>>().join("\n");
    let name = |rest: &str| rest.chars().take_while(|c| c.is_alphanumeric() || *c == '_').collect::<String>();
    let plain = code.match_indices("crate::").map(|(at, word)| &code[at + word.len()..]);
    let mut names = Vec::new();
    for rest in plain {
        match rest.strip_prefix('{') {
            Some(list) => names.extend(list.split('}').next().unwrap_or("").split(',').map(|n| name(n.trim()))),
            None => names.push(name(rest)),
        }
    }
    names
}

#[test]
fn modules_use_only_what_lies_below_them() {
    let src = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    let mut files = Vec::new();
    rust_files(&src, &mut files);
    assert!(files.len() > 20);
    let mut wrong = Vec::new();
    for file in files {
        let inside = file.strip_prefix(&src).expect("below src");
        let module = inside.components().next().expect("a name").as_os_str().to_string_lossy().replace(".rs", "");
        if module == "lib" || module == "main" {
            continue;
        }
        let (_, allowed) =
            ARROWS.iter().find(|(m, _)| *m == module).unwrap_or_else(|| panic!("add {module} to ARROWS"));
        for used in used_modules(&fs::read_to_string(&file).expect("text")) {
            let is_module = ARROWS.iter().any(|(m, _)| *m == used);
            if is_module && used != module && !allowed.contains(&used.as_str()) {
                wrong.push(format!("{}: {module} -> {used}", inside.display()));
            }
        }
    }
    assert!(wrong.is_empty(), "arrows that are not allowed:\n{}", wrong.join("\n"));
}
