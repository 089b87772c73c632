use crate::support::{OBJ, code, folder, kiln, stderr};
use serde_json::Value;

/// The same asset twice, the second with more samples, as PNG and EXR.
fn rendered() -> tempfile::TempDir {
    let dir = folder(&[("a.obj", OBJ), ("not.png", "no picture")]);
    for (stem, spp) in [("few", "1"), ("many", "64")] {
        for ending in ["png", "exr"] {
            let name = format!("{stem}.{ending}");
            let arguments = ["render", "a.obj", "-o", &name, "--width", "24", "--height", "16", "--spp", spp];
            assert_eq!(code(&kiln(dir.path(), &arguments)), 0);
        }
    }
    let small = ["render", "a.obj", "-o", "small.png", "--width", "8", "--spp", "1"];
    assert_eq!(code(&kiln(dir.path(), &small)), 0);
    dir
}

#[test]
fn exit_codes_say_whether_limits_are_kept() {
    let dir = rendered();
    for (arguments, want, told) in [
        (&["few.png", "many.png"][..], 0, ""),
        (
            &[
                "many.png",
                "many.png",
                "--fail-above",
                "rmse=0",
                "--fail-above",
                "max=0",
                "--fail-below",
                "ssim=0.99999",
            ],
            0,
            "",
        ),
        (&["few.exr", "many.exr", "--fail-above", "relmse=0.000001"], 1, "relmse is"),
        (&["few.png", "many.png", "--fail-above", "flip=1", "--fail-below", "ssim=1"], 1, "ssim is"),
        (&["few.png", "small.png"], 2, "sizes differ: 24×16 and 8×8"),
        (&["few.png", "none.png"], 2, "none.png: cannot be read"),
        (&["few.png", "not.png"], 2, "not.png"),
        (&["few.png", "many.png", "--fail-above", "ssim=0.9"], 2, "--fail-below"),
        (&["few.png", "many.png", "--fail-above", "psnr=30"], 2, "METRIC=VALUE"),
    ] {
        let output = kiln(dir.path(), &[&["compare"], arguments].concat());
        assert_eq!(code(&output), want, "{arguments:?}: {}", stderr(&output));
        assert!(stderr(&output).contains(told), "{arguments:?}: {}", stderr(&output));
    }
}

#[test]
fn json_and_heat_map_tell_where_and_how_much() {
    let dir = rendered();
    let output = kiln(dir.path(), &["compare", "few.exr", "many.exr", "--json", "--heat-map", "maps/heat.png"]);
    assert_eq!(code(&output), 0, "{}", stderr(&output));
    let exr: Value = serde_json::from_slice(&output.stdout).expect("one JSON object");
    for metric in ["rmse", "relmse", "flip", "max", "flip_p95"] {
        assert!(exr[metric].as_f64().expect(metric) > 0.0, "{exr}");
    }
    assert!(exr["ssim"].as_f64().expect("ssim") < 1.0 && exr["scene_referred"] == true, "{exr}");
    let map = image::open(dir.path().join("maps/heat.png")).expect("a PNG").into_rgb8();
    assert_eq!(map.dimensions(), (24, 16));
    // The corner is empty in both; magma's zero is nearly black.
    assert_eq!(map.get_pixel(0, 0).0, [0, 0, 4]);
    assert!(map.pixels().any(|p| p.0[0] > 20));
    // PNG files hold the same, rounded to levels.
    let output = kiln(dir.path(), &["compare", "few.png", "many.png", "--json"]);
    let png: Value = serde_json::from_slice(&output.stdout).expect("one JSON object");
    let rmse = |v: &Value| v["rmse"].as_f64().expect("rmse");
    assert!((rmse(&png) - rmse(&exr)).abs() < 0.2, "{png} {exr}");
}
