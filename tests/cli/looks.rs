//! Variants, moments, and turntables that play.

use crate::support::{base64, code, folder, gltf, kiln, stderr};
use kiln::film::Picture;
use kiln::write::exr;
use serde_json::{Value, json};
use std::fs;
use std::path::Path;

fn picture(path: &Path) -> Picture {
    exr::decode(&fs::read(path).expect("a picture"), 1 << 24).expect("an EXR file")
}

fn paths(line: &Value) -> Vec<&str> {
    line["outputs"].as_array().expect("outputs").iter().map(|o| o["path"].as_str().expect("a path")).collect()
}

fn render(folder: &Path, arguments: &[&str]) -> Value {
    let fixed = ["render", "a.gltf", "--format", "exr", "--json", "--width", "24", "--spp", "8"];
    let output = kiln(folder, &[&fixed, arguments].concat());
    assert_eq!(code(&output), 0, "{}", stderr(&output));
    serde_json::from_slice(&output.stdout).expect("one line")
}

#[test]
fn every_variant_has_pictures() {
    let mut asset: Value = serde_json::from_str(&gltf()).expect("JSON");
    asset["extensionsUsed"] = json!(["KHR_materials_variants", "KHR_materials_unlit"]);
    asset["extensions"] = json!({"KHR_materials_variants": {"variants": [{"name": "red"}, {"name": "a/b"}]}});
    let unlit = |color: Value| {
        json!({"pbrMetallicRoughness": {"baseColorFactor": color}, "extensions": {"KHR_materials_unlit": {}},
               "doubleSided": true})
    };
    asset["materials"] = json!([unlit(json!([1, 0, 0, 1])), unlit(json!([0, 1, 0, 1]))]);
    let mappings = json!([{"material": 0, "variants": [0]}, {"material": 1, "variants": [1]}]);
    asset["meshes"][0]["primitives"][0]["extensions"] = json!({"KHR_materials_variants": {"mappings": mappings}});
    let dir = folder(&[("a.gltf", &asset.to_string())]);
    let line = render(dir.path(), &["--variant", "all"]);
    assert_eq!(line["status"], "ok", "{line}");
    assert_eq!(paths(&line), ["a.gltf.red.exr", "a.gltf.a_b.exr"]);
    let strongest = |name: &str| {
        let seen = picture(&dir.path().join(name));
        let sum = |c: usize| seen.pixels.iter().map(|p| p[c]).sum::<f32>();
        assert!(sum(3) > 20.0, "nothing to see");
        [sum(0), sum(1), sum(2)]
    };
    assert!(matches!(strongest("a.gltf.red.exr"), [r, 0.0, 0.0] if r > 0.0));
    assert!(matches!(strongest("a.gltf.a_b.exr"), [0.0, g, 0.0] if g > 0.0));
    render(dir.path(), &["--variant", "a/b"]);
    assert!(matches!(strongest("a.gltf.exr"), [0.0, g, 0.0] if g > 0.0));
    let failed = kiln(dir.path(), &["render", "a.gltf", "--variant", "blue"]);
    assert_eq!(code(&failed), 1);
    assert!(stderr(&failed).contains("there is no variant 'blue', but 'red', 'a/b'"), "{}", stderr(&failed));
}

#[test]
fn turntables_play_and_moments_are_chosen() {
    // Grows from a tenth to its size in two seconds.
    let values: [f32; 8] = [0.0, 2.0, 0.1, 0.1, 0.1, 1.0, 1.0, 1.0];
    let bytes: Vec<u8> = values.iter().flat_map(|v| v.to_le_bytes()).collect();
    let mut asset: Value = serde_json::from_str(&gltf()).expect("JSON");
    let mut push = |list: &str, item: Value| asset[list].as_array_mut().expect("a list").push(item);
    push("buffers", json!({"byteLength": 32, "uri": format!("data:;base64,{}", base64(&bytes))}));
    push("bufferViews", json!({"buffer": 1, "byteLength": 8}));
    push("bufferViews", json!({"buffer": 1, "byteOffset": 8, "byteLength": 24}));
    push("accessors", json!({"bufferView": 1, "componentType": 5126, "count": 2, "type": "SCALAR", "max": [2]}));
    push("accessors", json!({"bufferView": 2, "componentType": 5126, "count": 2, "type": "VEC3"}));
    asset["materials"] = json!([{"doubleSided": true}]);
    asset["meshes"][0]["primitives"][0]["material"] = json!(0);
    asset["animations"] = json!([{
        "name": "grow", "samplers": [{"input": 1, "output": 2}],
        "channels": [{"sampler": 0, "target": {"node": 0, "path": "scale"}}]
    }]);
    let dir = folder(&[("a.gltf", &asset.to_string())]);
    let view = r#"{"camera_to_world": [[1,0,0,0.5],[0,1,0,0.5],[0,0,1,4],[0,0,0,1]], "vfov_deg": 30, "environment": {"type": "constant", "radiance": [1, 1, 1]}}"#;
    fs::write(dir.path().join("view.json"), view).expect("write");
    let cover = |name: &str| picture(&dir.path().join(name)).pixels.iter().map(|p| p[3]).sum::<f32>();
    let moment = |time: &str| {
        render(dir.path(), &["--view", "view.json", "--background", "transparent", "--time-code", time]);
        cover("a.gltf.exr")
    };
    let (half, whole) = (moment("1"), moment("2"));
    assert!((half / whole - 0.55 * 0.55).abs() < 0.05, "{half} of {whole}");

    let line = render(dir.path(), &["--turntable", "4", "--play", "--animation", "grow"]);
    assert_eq!(line["status"], "ok", "{line}");
    assert_eq!(paths(&line), [0, 1, 2, 3].map(|k| format!("a.gltf.{k:03}.exr")));
    let views: Vec<&Value> = line["outputs"].as_array().expect("outputs").iter().map(|o| &o["view"]).collect();
    assert_eq!(views, [0, 1, 2, 3]);
    // 0.1, 0.325, 0.55 and 0.775 of its size, and seen from the front and the back in the first and third.
    let (first, third) = (cover("a.gltf.000.exr"), cover("a.gltf.002.exr"));
    assert!(first > 0.0 && third > 10.0 * first, "{first} {third}");
    let seconds = &line["seconds"];
    assert!(seconds["total"].as_f64() >= seconds["render"].as_f64(), "{seconds}");
}
