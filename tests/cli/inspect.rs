use crate::support::{OBJ, code, folder, gltf, kiln, stderr};
use serde_json::Value;

#[test]
fn it_tells_what_is_in_an_asset() {
    let dir = folder(&[("a.obj", OBJ), ("b.gltf", &gltf())]);
    let output = kiln(dir.path(), &["inspect", "a.obj"]);
    assert_eq!(code(&output), 0, "{}", stderr(&output));
    let text = String::from_utf8(output.stdout).expect("text");
    for told in ["OBJ", "3 triangles", "bounds", "1 material", "studio", "kd-tree"] {
        assert!(text.contains(told), "{told} in {text}");
    }
    let output = kiln(dir.path(), &["inspect", "b.gltf", "--json"]);
    assert_eq!(code(&output), 0, "{}", stderr(&output));
    let facts: Value = serde_json::from_slice(&output.stdout).expect("JSON");
    assert_eq!((facts["format"].as_str(), facts["triangles"].as_u64()), (Some("gltf"), Some(1)));
    assert_eq!(facts["bounds"], serde_json::json!([[0.0, 0.0, 0.0], [1.0, 1.0, 0.0]]));
    assert_eq!(facts["kdtree"]["triangles"], 1);
}

#[test]
fn what_cannot_be_read_is_an_error() {
    let dir = folder(&[("broken.gltf", "{")]);
    for name in ["broken.gltf", "nowhere.obj", "."] {
        let output = kiln(dir.path(), &["inspect", name]);
        assert_eq!(code(&output), 1, "{name}");
        assert!(stderr(&output).starts_with(&format!("error: {name}: ")), "{}", stderr(&output));
        assert!(output.stdout.is_empty());
    }
}
