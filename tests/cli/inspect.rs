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
fn it_names_the_effects_and_what_is_left_away() {
    let mut asset: Value = serde_json::from_str(&gltf()).expect("JSON");
    asset["materials"] = serde_json::json!([{"name": "paint", "alphaMode": "BLEND"}]);
    asset["meshes"][0]["primitives"][0]["material"] = 0.into();
    let dir = folder(&[("a.gltf", &asset.to_string())]);
    let shown = |arguments: &[&str]| {
        let output = kiln(dir.path(), arguments);
        assert_eq!(code(&output), 0, "{}", stderr(&output));
        String::from_utf8(output.stdout).expect("text")
    };
    let text = shown(&["inspect", "a.gltf", "--effects"]);
    for told in ["metal", "material 'paint' on 1 mesh, all of the area", "environment", "is opaque (paint)"] {
        assert!(text.contains(told), "{told} in {text}");
    }
    assert!(!text.contains("alpha-blending"), "{text}");
    let facts = shown(&["inspect", "a.gltf", "--effects", "--measure", "--json"]);
    let facts: Value = serde_json::from_str(&facts).expect("JSON");
    assert_eq!(facts["measured"]["same_bits"], true, "{facts}");
    assert_eq!(
        (facts["attribute_bytes"]["held"].as_u64(), facts["attribute_bytes"]["full"].as_u64()),
        (Some(0), Some(180))
    );
    shown(&["render", "a.gltf", "--spp", "1", "--width", "8", "--effects", "-metal,-culling", "-o", "a.png"]);
    let output = kiln(dir.path(), &["render", "a.gltf", "--effects", "-brilliance"]);
    assert_eq!(code(&output), 2);
    assert!(stderr(&output).contains("'brilliance' is no effect"), "{}", stderr(&output));
}

#[test]
fn its_json_is_documented_and_tells_what_the_file_says_of_itself() {
    let mut asset: Value = serde_json::from_str(&gltf()).expect("JSON");
    asset["asset"]["generator"] = "by hand".into();
    asset["extensionsUsed"] = serde_json::json!(["KHR_materials_unlit", "KHR_materials_variants"]);
    asset["materials"] = serde_json::json!([{"name": "paint", "extensions": {"KHR_materials_unlit": {}}}]);
    asset["extensions"] = serde_json::json!({"KHR_materials_variants": {"variants": [{"name": "beach"}]}});
    asset["animations"] = serde_json::json!([{"name": "walk", "channels": [{}], "samplers": [{"input": 0}]}]);
    let dir = folder(&[("a.gltf", &asset.to_string())]);
    let output = kiln(dir.path(), &["inspect", "a.gltf", "--json"]);
    assert_eq!(code(&output), 0, "{}", stderr(&output));
    let facts: Value = serde_json::from_slice(&output.stdout).expect("JSON");
    let contents = serde_json::json!({
        "generator": "by hand", "extensions_used": ["KHR_materials_unlit", "KHR_materials_variants"],
        "extensions_required": [], "animations": [{"name": "walk", "seconds": 1.0, "channels": 1}],
        "variants": ["beach"], "materials": [{"name": "paint", "extensions": ["KHR_materials_unlit"]}]
    });
    assert_eq!(facts["contents"], contents);
    let page = std::fs::read_to_string(concat!(env!("CARGO_MANIFEST_DIR"), "/docs/inspect.md")).expect("a page");
    let listed: Vec<&str> = page.lines().filter_map(|line| line.strip_prefix("| `")?.split('`').next()).collect();
    let printed: Vec<&str> = facts.as_object().expect("an object").keys().map(String::as_str).collect();
    for key in &printed {
        assert!(listed.contains(key), "{key} is not documented");
    }
    // What --measure adds is not asked for here.
    for key in listed.into_iter().filter(|key| *key != "measured") {
        assert!(printed.contains(&key), "{key} is documented and not printed");
    }
    for list in ["materials", "textures", "lights", "cameras", "contents", "warnings"] {
        let row = page.lines().find(|line| line.starts_with(&format!("| `{list}`"))).expect("a row");
        let item = if list == "contents" { Some(&facts[list]) } else { facts[list].get(0) };
        for key in item.and_then(Value::as_object).into_iter().flat_map(|o| o.keys()) {
            assert!(row.contains(&format!("`{key}`")), "{list}.{key} is not documented");
        }
    }
    // In haste the same is told of the file, and nothing of what is made of it.
    let quick = kiln(dir.path(), &["inspect", "a.gltf", "--quick", "--json"]);
    let quick: Value = serde_json::from_slice(&quick.stdout).expect("JSON");
    for (key, value) in facts.as_object().expect("an object") {
        let made = ["degenerate_triangles", "emitters", "kdtree", "effects", "rewrites", "attribute_bytes"];
        assert_eq!(quick.get(key), Some(value).filter(|_| !made.contains(&key.as_str())), "{key}");
    }
    let text = String::from_utf8(kiln(dir.path(), &["inspect", "a.gltf", "--quick"]).stdout).expect("text");
    assert!(text.contains("by hand") && !text.contains("kd-tree"), "{text}");
    assert_eq!(code(&kiln(dir.path(), &["inspect", "a.gltf", "--quick", "--effects"])), 2);
    let text = String::from_utf8(kiln(dir.path(), &["inspect", "a.gltf"]).stdout).expect("text");
    for told in ["'walk', 1.00 s, 1 channel", "'beach'", "KHR_materials_unlit, on 1 material", "by hand"] {
        assert!(text.contains(told), "{told} in {text}");
    }
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

/// A file of rays: (origin, near end, direction, far end) each.
fn ray_file(rays: &[[f32; 8]]) -> Vec<u8> {
    let numbers = rays.as_flattened().iter().flat_map(|x| x.to_le_bytes());
    (rays.len() as u32).to_le_bytes().into_iter().chain(numbers).collect()
}

#[test]
fn rays_of_a_file_are_traced_in_the_assets_coordinates() {
    let dir = folder(&[("a.obj", "v 10 0 0\nv 14 0 0\nv 10 4 0\nf 1 2 3\n")]);
    let rays = [
        [11.0, 1.0, 5.0, 0.0, 0.0, 0.0, -1.0, f32::INFINITY],
        [11.0, 1.0, 5.0, 0.0, 0.0, 0.0, -2.0, 1e30],
        [11.0, 1.0, 5.0, 1.0, 0.0, 0.0, -1.0, 6.0],
        [11.0, 1.0, 5.0, 0.0, 0.0, 0.0, -1.0, 4.0],
        [11.0, 1.0, 5.0, 5.5, 0.0, 0.0, -1.0, 9.0],
        [0.0, 1.0, 5.0, 0.0, 0.0, 0.0, -1.0, 9.0],
    ];
    std::fs::write(dir.path().join("some.rays"), ray_file(&rays)).expect("a file");
    for extra in [&[][..], &["--stream"], &["--stream", "--threads", "3"], &["--threads", "2", "--simd", "scalar"]] {
        let told = |more: &[&str]| -> Value {
            let words = [&["inspect", "a.obj", "--rays", "some.rays", "--json"], extra, more].concat();
            let output = kiln(dir.path(), &words);
            assert_eq!(code(&output), 0, "{}", stderr(&output));
            serde_json::from_slice(&output.stdout).expect("JSON")
        };
        let nearest = told(&[]);
        assert_eq!((nearest["rays"].as_u64(), nearest["hits"].as_u64()), (Some(6), Some(3)), "{extra:?}");
        let mean = nearest["mean_t"].as_f64().expect("a number");
        assert!((mean - (5.0 + 2.5 + 5.0) / 3.0).abs() < 1e-5, "{mean}");
        for key in ["cpu_seconds", "mrays_per_cpu_second", "build_seconds"] {
            assert!(nearest[key].as_f64().expect(key) > 0.0, "{key}");
        }
        assert_eq!(told(&["--any-hit"])["hits"], 3, "{extra:?}");
    }
    let output = kiln(dir.path(), &["inspect", "a.obj", "--rays"]);
    let text = String::from_utf8(output.stdout).expect("text");
    for told in ["camera", "bounce", "shadow", "million rays per CPU second", "bytes a triangle"] {
        assert!(text.contains(told), "{told} in {text}");
    }
}

#[test]
fn a_file_that_holds_no_rays_is_an_error() {
    let dir = folder(&[("a.obj", OBJ), ("cut.rays", "\u{7}\u{0}\u{0}\u{0}and so on")]);
    for (name, why) in [("cut.rays", "228"), ("nowhere.rays", "")] {
        let output = kiln(dir.path(), &["inspect", "a.obj", "--rays", name]);
        assert_eq!(code(&output), 1, "{name}");
        let told = stderr(&output);
        assert!(told.starts_with(&format!("error: {name}: ")) && told.contains(why), "{told}");
    }
    assert_eq!(code(&kiln(dir.path(), &["inspect", "a.obj", "--stream"])), 2, "--stream says nothing without --rays");
}
