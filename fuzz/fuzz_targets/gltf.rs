//! Bytes of a `.gltf` or `.glb` file: an error, or a scene that passes validation, in the rest pose and in another look.
#![no_main]

use kiln_formats::{Contents, Control, Limits, Resources, Show};
use libfuzzer_sys::fuzz_target;

fuzz_target!(|bytes: &[u8]| {
    let limits = Limits { max_file_bytes: 1 << 20, max_triangles: 100_000, max_texels: 1 << 20, max_nesting: 100 };
    let folder = std::env::temp_dir();
    let moving = Show { animation: Some("all".into()), time: Some(0.5), variant: Some("0".into()) };
    for show in [Show::default(), moving] {
        let mut resources = Resources::new(&folder.join("a.gltf"), Some(&folder), limits).expect("a folder");
        let (mut contents, mut warnings) = (Contents::default(), Vec::new());
        let read = kiln_formats::gltf::import(
            bytes.to_vec(),
            &mut resources,
            &show,
            &mut contents,
            &mut warnings,
            &Control::default(),
        );
        if let Ok(scene) = read {
            scene.validate().expect("a sound scene");
        }
    }
});
