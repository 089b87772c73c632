//! Layers of EXR files for compositing.

use crate::support::{code, folder, kiln, stderr};
use exr::prelude::*;
use std::collections::BTreeMap;
use std::fs;
use std::path::Path;

/// Two squares one above the other, of two materials, both facing +Z.
const TWO: &str = "\
mtllib two.mtl\n\
v -1 0 0\nv 1 0 0\nv 1 1 0\nv -1 1 0\n\
v -1 2 -1\nv 1 2 -1\nv 1 3 -1\nv -1 3 -1\n\
o lower\nusemtl red\nf 1 2 3 4\no upper é\nusemtl green\nf 5 6 7 8\n";
const MTL: &str = "newmtl red\nKd 0.8 0.1 0.1\nnewmtl green\nKd 0.1 0.6 0.1\n";
/// Looks along -Z from ten units before the squares.
const VIEW: &str = r#"{"camera_to_world": [[1,0,0,0],[0,1,0,1.5],[0,0,1,10],[0,0,0,1]], "vfov_deg": 30}"#;
const ALL: &str = "albedo,normal,depth,object,material";

/// Values by channel, and the attributes that are texts.
fn read(path: &Path) -> (BTreeMap<String, Vec<f32>>, BTreeMap<String, String>) {
    let image = read_first_flat_layer_from_file(path).expect("an EXR file");
    let layer = image.layer_data;
    let texts = layer.attributes.other.iter().filter_map(|(name, value)| match value {
        AttributeValue::Text(text) => {
            let bytes: Vec<u8> = text.bytes().to_vec();
            Some((name.to_string(), String::from_utf8(bytes).expect("UTF-8")))
        }
        _ => None,
    });
    let channels = layer.channel_data.list.iter().filter_map(|c| match &c.sample_data {
        FlatSamples::F32(values) => Some((c.name.to_string(), values.clone())),
        _ => None,
    });
    (channels.collect(), texts.collect())
}

fn render(dir: &Path, name: &str, more: &[&str]) -> (BTreeMap<String, Vec<f32>>, BTreeMap<String, String>) {
    let base = ["render", "two.obj", "--view", "view.json", "--width", "32", "--spp", "16", "--quiet", "-o", name];
    let output = kiln(dir, &[&base[..], more].concat());
    assert_eq!(code(&output), 0, "{}", stderr(&output));
    read(&dir.join(name))
}

#[test]
fn layers_say_what_is_there() {
    let dir = folder(&[("two.obj", TWO), ("two.mtl", MTL), ("view.json", VIEW)]);
    let (channels, texts) = render(dir.path(), "a.exr", &["--layers", ALL]);
    // In the middle of the lower square (row 20 of 32 looks at y ≈ 0.75).
    let at = |name: &str| channels.get(name).unwrap_or_else(|| panic!("{name} in {:?}", channels.keys()))[20 * 32 + 16];
    assert_eq!((at("A"), at("CryptoObject00.G"), at("CryptoMaterial00.G")), (1.0, 1.0, 1.0));
    assert!((at("depth.Z") - 10.0).abs() < 1e-3, "{}", at("depth.Z"));
    assert_eq!(["X", "Y", "Z"].map(|c| at(&format!("normal.{c}"))), [0.0, 0.0, 1.0]);
    let albedo = ["R", "G", "B"].map(|c| at(&format!("albedo.{c}")));
    assert!(albedo.iter().zip([0.8, 0.1, 0.1]).all(|(a, b)| (a - b).abs() < 1e-5), "{albedo:?}");
    assert_eq!(channels["depth.Z"][0], f32::INFINITY, "nothing is there");
    // Every matte together is the coverage, to the sample.
    for set in ["CryptoObject", "CryptoMaterial"] {
        for (pixel, alpha) in channels["A"].iter().enumerate() {
            let ranks = (0..3).flat_map(|k| [format!("{set}{k:02}.G"), format!("{set}{k:02}.A")]);
            let sum: f32 = ranks.map(|name| channels[&name][pixel]).sum();
            assert_eq!(sum, *alpha, "{set} at {pixel}");
        }
    }
    let manifest = |set: &str| {
        let key = texts.iter().find(|(_, value)| *value == set).expect(set).0.trim_end_matches("name");
        serde_json::from_str::<BTreeMap<String, String>>(&texts[&format!("{key}manifest")]).expect("JSON")
    };
    let red = u32::from_str_radix(&manifest("CryptoMaterial")["red"], 16).expect("hexadecimal");
    assert_eq!(at("CryptoMaterial00.R").to_bits(), red);
    let objects = manifest("CryptoObject");
    assert!(
        objects.len() == 2 && objects.values().any(|id| *id == format!("{:08x}", at("CryptoObject00.R").to_bits())),
        "{objects:?}"
    );
}

#[test]
fn layers_leave_the_picture_alone_and_repeat() {
    let dir = folder(&[("two.obj", TWO), ("two.mtl", MTL), ("view.json", VIEW)]);
    let (plain, texts) = render(dir.path(), "plain.exr", &[]);
    assert!(texts.keys().all(|name| !name.starts_with("cryptomatte")) && !plain.contains_key("depth.Z"));
    let (layered, _) = render(dir.path(), "a.exr", &["--layers", "material,depth,material", "--threads", "1"]);
    assert!(["R", "G", "B", "A"].iter().all(|c| plain[*c] == layered[*c]), "the same light");
    assert!(layered.contains_key("depth.Z") && !layered.contains_key("albedo.R"));
    for name in ["b.exr", "c.exr", "d.exr"] {
        render(dir.path(), name, &["--layers", "depth,material", "--threads", "3"]);
        // Attributes come in one order, whatever the crate's map says.
        let [a, b] = ["a.exr", name].map(|name| fs::read(dir.path().join(name)).expect("read"));
        assert!(a == b, "{name}");
    }
}
