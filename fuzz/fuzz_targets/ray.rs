//! Bytes behind the header of a `.ray` file, in every dialect.
#![no_main]

use kiln_formats::ray::{Dialect, RayOptions};
use kiln_formats::{Control, Limits, Resources};
use libfuzzer_sys::fuzz_target;

fuzz_target!(|bytes: &[u8]| {
    let limits = Limits { max_file_bytes: 1 << 20, max_triangles: 100_000, max_texels: 1 << 20, max_nesting: 100 };
    let folder = std::env::temp_dir();
    let text = [b"SBT-raytracer 1.0 ", bytes].concat();
    for dialect in [Dialect::Ut, Dialect::Hk] {
        let options = RayOptions { dialect, emit_ambient: true, ..RayOptions::default() };
        let mut resources = Resources::new(&folder.join("a.ray"), Some(&folder), limits).expect("a folder");
        let read =
            kiln_formats::ray::import(text.clone(), &mut resources, options, &mut Vec::new(), &Control::default());
        if let Ok(scene) = read {
            scene.validate().expect("a sound scene");
        }
    }
});
