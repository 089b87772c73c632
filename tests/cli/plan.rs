use crate::support::{OBJ, code, files, folder, kiln, stderr};
use serde_json::Value;

#[test]
fn a_plan_names_what_dominates_and_writes_nothing() {
    // A floor of many triangles beside a small thing.
    let mut floor = String::new();
    for i in 0..150 * 150 {
        let (x, y) = (f64::from(i % 150), f64::from(i / 150));
        floor += &format!("v {x} {y} {}\n", 0.3 * f64::from(i * 7919 % 13));
    }
    for i in (1..149 * 150).filter(|i| i % 150 != 0) {
        floor += &format!("f {} {} {} {}\n", i, i + 1, i + 151, i + 150);
    }
    let dir = folder(&[("in/small.obj", OBJ), ("in/large.obj", &floor), ("in/broken.obj", "f 1 2 3\n")]);
    let arguments = ["plan", "in", "--json", "--width", "200", "--spp", "32"];
    let output = kiln(dir.path(), &arguments);
    assert_eq!(code(&output), 3, "one of three will fail: {}", stderr(&output));
    let plan: Value = serde_json::from_slice(&output.stdout).expect("one JSON object");
    let assets = plan["assets"].as_array().expect("assets");
    assert_eq!(assets.len(), 3);
    assert!(assets[0]["input"] == "large.obj" && assets[2]["input"] == "broken.obj", "{plan}");
    assert!(assets[2]["error_message"].as_str().expect("why").contains("no face is sound"), "{plan}");
    let of = |v: &Value, key: &str| v[key].as_f64().unwrap_or_else(|| panic!("{key} in {v}"));
    for figure in [&plan["seconds"], &plan["cpu_seconds"]] {
        let (low, expected, high) = (of(figure, "low"), of(figure, "expected"), of(figure, "high"));
        assert!(low > 0.0 && low < expected && expected < high, "{figure}");
        assert!(low >= 0.7 * expected - 1e-9 && high <= 1.3 * expected + 1e-9, "{figure}");
    }
    let shares: f64 = assets.iter().map(|a| of(a, "share")).sum();
    assert!((shares - 1.0).abs() < 1e-9);
    assert_eq!(files(dir.path()), ["in/broken.obj", "in/large.obj", "in/small.obj"]);
    // Four times the pixels, about four times the rendering.
    let output = kiln(dir.path(), &["plan", "in", "--json", "--width", "400", "--spp", "32"]);
    let larger: Value = serde_json::from_slice(&output.stdout).expect("one JSON object");
    let render = |plan: &Value| {
        let asset = plan["assets"].as_array().expect("assets").iter().find(|a| a["input"] == "large.obj");
        of(&asset.expect("there")["cpu_seconds"], "render")
    };
    let factor = render(&larger) / render(&plan);
    assert!((2.0..8.0).contains(&factor), "{factor}");
}

#[test]
fn an_error_asked_for_decides_about_the_samples() {
    let dir = folder(&[("in/a.obj", OBJ)]);
    let spp = |error: &str| {
        let output = kiln(dir.path(), &["plan", "in", "--json", "--width", "96", "--error", error]);
        assert_eq!(code(&output), 0, "{}", stderr(&output));
        let plan: Value = serde_json::from_slice(&output.stdout).expect("one JSON object");
        plan["assets"][0]["spp"].as_u64().expect("spp")
    };
    let (rough, fine) = (spp("12"), spp("1.5"));
    assert!(fine > 2 * rough, "{rough} {fine}");
}
