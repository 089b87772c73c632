//! Seconds and peak memory of importing files, one line each: `cargo run --release -p kiln-formats --example import_speed
//! -- FILE…`. With `--tobj` OBJ files are loaded by `tobj` alone, for comparison; with `--packed` images of glTF files stay encoded, as
//! Blender's import leaves them, and no tangents are made. One file a process tells its peak.

use kiln_formats::{Control, ImportOptions, Touched, import, open};
use std::path::Path;
use std::time::Instant;

fn main() {
    let mut arguments: Vec<String> = std::env::args().skip(1).collect();
    let mut flag = |name| arguments.first().is_some_and(|a| a == name).then(|| arguments.remove(0)).is_some();
    let (tobj_alone, packed) = (flag("--tobj"), flag("--packed"));
    for file in &arguments {
        let start = Instant::now();
        let told = if tobj_alone {
            let options = tobj::LoadOptions { single_index: true, ..tobj::LoadOptions::default() };
            match tobj::load_obj(file, &options) {
                Ok((models, _)) => format!("{} models", models.len()),
                Err(error) => error.to_string(),
            }
        } else {
            let (file, options, control) = (Path::new(file), ImportOptions::default(), Control::default());
            let told = match packed {
                true => open(file, &options, &control, &mut Touched::default()).map(|_| "opened".to_owned()),
                false => import(file, &options, &control)
                    .map(|imported| format!("{} triangles", imported.scene.triangle_count())),
            };
            told.unwrap_or_else(|error| error.to_string())
        };
        let seconds = start.elapsed().as_secs_f64();
        println!("{seconds:8.3} s  {:8.1} MB  {file}: {told}", peak_megabytes().unwrap_or(f64::NAN));
    }
}

/// The most memory that the process has held, where the system tells.
fn peak_megabytes() -> Option<f64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find(|l| l.starts_with("VmHWM:"))?;
    line.split_whitespace().nth(1)?.parse::<f64>().ok().map(|kilobytes| kilobytes / 1e3)
}
