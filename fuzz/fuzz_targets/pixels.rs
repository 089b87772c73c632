//! From a file to pixels: the first byte chooses the format, the rest is the file.
#![no_main]

use kiln::batch::plan_views;
use kiln::formats::{Control, ImportOptions, Limits, import};
use kiln::integrate::render;
use kiln::prepare::{EnvironmentSource, prepare};
use kiln::settings::{PrepareSettings, RenderSettings, ViewSettings};
use libfuzzer_sys::fuzz_target;

fuzz_target!(|bytes: &[u8]| {
    let Some((choice, file)) = bytes.split_first() else { return };
    let folder = std::env::temp_dir().join(format!("kiln-fuzz-{}", std::process::id()));
    std::fs::create_dir_all(&folder).expect("a folder");
    let path = folder.join(["a.gltf", "a.obj", "a.ray"][usize::from(*choice) % 3]);
    std::fs::write(&path, file).expect("a file");
    let limits = Limits { max_file_bytes: 1 << 20, max_triangles: 20_000, max_texels: 1 << 20, max_nesting: 100 };
    let control = Control::default();
    let Ok(imported) = import(&path, &ImportOptions { limits, ..ImportOptions::default() }, &control) else { return };
    let settings = ViewSettings { width: 8, height: 8, ..ViewSettings::default() };
    let Ok(views) = plan_views(&imported.scene, &settings, false) else { return };
    let prepared = prepare(imported.scene, &EnvironmentSource::Studio, &PrepareSettings::default(), &control)
        .expect("not stopped");
    for view in &views {
        let settings = RenderSettings { spp: 1, ..RenderSettings::default() };
        let rendered = render(&prepared, view, &settings, &control).expect("not stopped");
        assert!(rendered.picture.pixels.as_flattened().iter().all(|x| x.is_finite()));
    }
});
