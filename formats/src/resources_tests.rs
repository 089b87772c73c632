//! Files within and outside the root, and limits.

use super::*;
use std::fs;

/// `top/{root/{asset/{a.obj, Tex/Wood.PNG}, beside.png}, secret.txt}`.
fn tree() -> (tempfile::TempDir, PathBuf) {
    let top = tempfile::tempdir().unwrap();
    let asset = top.path().join("root/asset");
    fs::create_dir_all(asset.join("Tex")).unwrap();
    for (name, content) in
        [("a.obj", "asset"), ("Tex/Wood.PNG", "wood"), ("../beside.png", "beside"), ("../../secret.txt", "secret")]
    {
        fs::write(asset.join(name), content).unwrap();
    }
    (top, asset)
}

fn resources(asset: &Path) -> Resources {
    Resources::new(&asset.join("a.obj"), None, Limits::default()).unwrap()
}

#[test]
fn references_inside_the_root_are_read_and_remembered() {
    let (_top, asset) = tree();
    let mut resources = resources(&asset);
    assert_eq!(resources.read_asset(&asset.join("a.obj")).unwrap(), b"asset");
    for (reference, content) in [
        ("Tex/Wood.PNG", "wood"),
        ("./Tex/../Tex/Wood.PNG", "wood"),
        ("tex\\wood.png", "wood"),
        ("../beside.png", "beside"),
        ("../ASSET/tex/WOOD.png", "wood"),
    ] {
        assert_eq!(resources.read(reference).unwrap(), content.as_bytes(), "{reference}");
    }
    let touched = resources.touched();
    let names: Vec<_> = touched.read.iter().filter_map(|f| f.path.file_name()?.to_str()).collect();
    assert_eq!(names, ["a.obj", "Wood.PNG", "beside.png"]);
    assert_eq!(touched.read[1].hash, *blake3::hash(b"wood").as_bytes());
}

#[test]
fn what_leads_out_of_the_root_is_refused() {
    let (top, asset) = tree();
    let mut resources = resources(&asset);
    let absolute = top.path().join("secret.txt").display().to_string();
    for reference in [
        "../../secret.txt",
        "..\\..\\secret.txt",
        "Tex/../../../SECRET.txt",
        &absolute,
        "file:///etc/passwd",
        "http://example.org/a.png",
        "C:\\a.png",
        "c:a.png",
        "\\\\server\\share\\a.png",
        "",
        "a\0b",
    ] {
        assert_eq!(resources.read(reference).unwrap_err().code, ErrorCode::Refused, "{reference:?}");
    }
    assert_eq!(resources.read("gone.png").unwrap_err().code, ErrorCode::Io);
    let missing = asset.canonicalize().unwrap().join("gone.png");
    assert_eq!(resources.touched(), Touched { read: Vec::new(), missing: vec![missing] });
    let wide = Resources::new(&asset.join("a.obj"), Some(top.path()), Limits::default());
    assert_eq!(wide.unwrap().read("../../secret.txt").unwrap(), b"secret");
    let narrow = Resources::new(&asset.join("a.obj"), Some(&asset), Limits::default());
    assert_eq!(narrow.unwrap().read("../beside.png").unwrap_err().code, ErrorCode::Refused);
}

#[cfg(unix)]
#[test]
fn links_are_followed_before_they_are_judged() {
    let (top, asset) = tree();
    std::os::unix::fs::symlink(top.path().join("secret.txt"), asset.join("link.png")).unwrap();
    std::os::unix::fs::symlink(top.path(), asset.join("folder")).unwrap();
    std::os::unix::fs::symlink("loop", asset.join("loop")).unwrap();
    std::os::unix::fs::symlink(asset.join("Tex/Wood.PNG"), asset.join("inside.png")).unwrap();
    let mut resources = resources(&asset);
    assert_eq!(resources.read("link.png").unwrap_err().code, ErrorCode::Refused);
    assert_eq!(resources.read("folder/secret.txt").unwrap_err().code, ErrorCode::Refused);
    assert_eq!(resources.read("loop").unwrap_err().code, ErrorCode::Io);
    assert_eq!(resources.read("inside.png").unwrap(), b"wood");
}

#[test]
fn only_regular_files_within_the_limit_are_read() {
    let (_top, asset) = tree();
    assert_eq!(resources(&asset).read("Tex").unwrap_err().code, ErrorCode::Refused);
    assert_eq!(resources(&asset).read(".").unwrap_err().code, ErrorCode::Refused);
    let with = |max_file_bytes| {
        let limits = Limits { max_file_bytes, ..Limits::default() };
        Resources::new(&asset.join("a.obj"), None, limits).unwrap().read("Tex/Wood.PNG")
    };
    assert_eq!(with(3).unwrap_err().code, ErrorCode::TooLarge);
    assert_eq!(with(4).unwrap(), b"wood");
    assert_eq!(with(u64::MAX).unwrap(), b"wood");
    let sparse = File::create(asset.join("sparse.bin")).unwrap();
    if sparse.set_len(1 << 42).is_ok() {
        assert_eq!(resources(&asset).read("sparse.bin").unwrap_err().code, ErrorCode::TooLarge);
    }
}
