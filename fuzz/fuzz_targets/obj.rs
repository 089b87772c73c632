//! An OBJ file and, behind the first byte 255, the MTL file `a.mtl` that it may name.
#![no_main]

use kiln_formats::{Control, Limits, Resources};
use libfuzzer_sys::fuzz_target;

fuzz_target!(|bytes: &[u8]| {
    let limits = Limits { max_file_bytes: 1 << 20, max_triangles: 100_000, max_texels: 1 << 20, max_nesting: 100 };
    let folder = std::env::temp_dir().join(format!("kiln-fuzz-{}", std::process::id()));
    std::fs::create_dir_all(&folder).expect("a folder");
    let mut parts = bytes.splitn(2, |b| *b == 255);
    let obj = parts.next().unwrap_or_default().to_vec();
    if let Some(mtl) = parts.next() {
        std::fs::write(folder.join("a.mtl"), mtl).expect("a file");
    }
    let mut resources = Resources::new(&folder.join("a.obj"), Some(&folder), limits).expect("a folder");
    if let Ok(scene) = kiln_formats::obj::import(obj, &mut resources, &mut Vec::new(), &Control::default()) {
        scene.validate().expect("a sound scene");
    }
});
