use crate::support::{OBJ, code, folder, kiln, stderr};
use kiln::film::Picture;
use kiln::write::exr;
use std::fs;
use std::path::Path;

/// A camera at (0, 0.5, 4) that looks along −Z with 40° of height.
const VIEW: &str = r#""camera_to_world": [[1,0,0,0],[0,1,0,0.5],[0,0,1,4],[0,0,0,1]], "vfov_deg": 40"#;

fn render(folder: &Path, arguments: &[&str]) -> Picture {
    let fixed = ["render", "a.obj", "-o", "a.exr", "--spp", "4"];
    let output = kiln(folder, &[&fixed, arguments].concat());
    assert_eq!(code(&output), 0, "{}", stderr(&output));
    exr::decode(&fs::read(folder.join("a.exr")).expect("a picture"), 1 << 24).expect("an EXR file")
}

#[test]
fn a_view_file_gives_camera_size_and_light() {
    let light = r#""environment": {"type": "constant", "radiance": [0.25, 0.5, 2]}"#;
    let view = format!(r#"{{{VIEW}, "width": 24, "height": 12, "max_scatter": 3, {light}}}"#);
    let dir = folder(&[("a.obj", OBJ), ("view.json", &view)]);
    let picture = render(dir.path(), &["--view", "view.json"]);
    assert_eq!((picture.width, picture.height), (24, 12));
    // The environment is shown behind the asset, exactly, and the asset covers the middle.
    assert_eq!(picture.pixels[0], [0.25, 0.5, 2.0, 1.0]);
    assert_ne!(picture.pixels[6 * 24 + 12], picture.pixels[0]);
    // Flags come before the file.
    let picture = render(dir.path(), &["--view", "view.json", "--width", "8", "--height", "8", "--env", "none"]);
    assert_eq!((picture.width, picture.height), (8, 8));
    assert_eq!(picture.pixels[0][..3], [0.0; 3]);
}

#[test]
fn automatic_views_show_the_whole_asset() {
    let dir = folder(&[("a.obj", OBJ)]);
    for size in [["--width", "48", "--height", "48"], ["--width", "144", "--height", "48"]] {
        let picture = render(dir.path(), &size);
        let (w, h) = (picture.width as usize, picture.height as usize);
        let covered = |x: usize, y: usize| picture.pixels[y * w + x][3] > 0.0;
        let border =
            (0..w).any(|x| covered(x, 0) || covered(x, h - 1)) || (0..h).any(|y| covered(0, y) || covered(w - 1, y));
        assert!(!border, "nothing touches the border");
        let rows = (0..h).filter(|y| (0..w).any(|x| covered(x, *y))).count();
        let columns = (0..w).filter(|x| (0..h).any(|y| covered(*x, y))).count();
        let fill = (rows as f64 / h as f64).max(columns as f64 / w as f64);
        assert!(fill > 0.85, "the asset fills the frame in one direction: {fill}");
    }
}

#[test]
fn environments_are_shown_on_request_and_transparent_otherwise() {
    let dir = folder(&[("a.obj", OBJ)]);
    let light = ["--width", "16", "--env", "constant:0.5"];
    assert_eq!(render(dir.path(), &light).pixels[0], [0.0; 4]);
    let shown = render(dir.path(), &[&light[..], &["--background", "environment"]].concat());
    assert_eq!(shown.pixels[0], [0.5, 0.5, 0.5, 1.0]);
}

#[test]
fn an_exr_environment_lights_the_asset() {
    let dir = folder(&[("a.obj", OBJ)]);
    // A picture of ours serves as environment: transparent black but for the asset.
    render(dir.path(), &["--width", "16"]);
    fs::rename(dir.path().join("a.exr"), dir.path().join("sky.exr")).expect("rename");
    let picture = render(dir.path(), &["--width", "16", "--env", "sky.exr"]);
    assert!(picture.pixels.iter().any(|p| p[3] > 0.0 && p[0] > 0.0));
}

#[test]
fn turntables_show_every_side_and_only_the_asset_moves() {
    let dir = folder(&[("in/a.obj", OBJ)]);
    let arguments = ["batch", "in", "--out", "out", "--turntable", "4", "--width", "32", "--spp", "2"];
    let output = kiln(dir.path(), &arguments);
    assert_eq!(code(&output), 0, "{}", stderr(&output));
    for k in 0..4 {
        let frame = frame(dir.path(), k);
        assert!(frame.pixels.iter().any(|p| p[3] > 0.0), "frame {k} is not empty");
        assert_ne!(frame, self::frame(dir.path(), (k + 1) % 4), "frames differ");
    }
    assert!(!dir.path().join("out/a.obj.004.exr").exists());
}

fn frame(dir: &Path, k: u32) -> Picture {
    let bytes = fs::read(dir.join(format!("out/a.obj.{k:03}.exr"))).expect("a frame");
    exr::decode(&bytes, 1 << 24).expect("an EXR file")
}
