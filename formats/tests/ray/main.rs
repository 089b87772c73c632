//! The `.ray` importer, by the scenes that it makes and the complaints that it has.

#![allow(clippy::disallowed_methods, reason = "expected values may come from std's functions")]

mod camera;
mod corpus;
mod dialects;
mod hostile;
mod language;
mod lights;
mod materials;
mod meshes;
mod nesting;
mod samples;
mod shapes;
#[path = "../shared/mod.rs"]
mod shared;
mod textures;

use kiln_formats::ray::RayOptions;
use kiln_formats::scene::{Material, Phong, Surface};
use kiln_formats::{Control, ErrorCode, ImportError, Limits, Place, Resources, Scene, Warning, ray};
use std::path::Path;

/// Reads a scene whose files lie in `folder`. The scene has passed validation.
fn read_in(folder: &Path, text: &[u8], limits: Limits) -> Result<(Scene, Vec<Warning>), ImportError> {
    read_as(folder, text, limits, RayOptions::default())
}

fn read_as(
    folder: &Path,
    text: &[u8],
    limits: Limits,
    options: RayOptions,
) -> Result<(Scene, Vec<Warning>), ImportError> {
    let mut resources = Resources::new(&folder.join("scene.ray"), None, limits)?;
    let mut warnings = Vec::new();
    let scene = ray::import(text.to_vec(), &mut resources, options, &mut warnings, &Control::default())?;
    scene.validate().unwrap_or_else(|e| panic!("invalid scene: {e}"));
    Ok((scene, warnings))
}

/// Reads what stands behind the header of a scene without files.
fn read_body(body: &str) -> Result<(Scene, Vec<Warning>), ImportError> {
    read_in(&std::env::temp_dir(), format!("SBT-raytracer 1.0 {body}").as_bytes(), Limits::default())
}

fn scene(body: &str) -> Scene {
    read_body(body).unwrap_or_else(|e| panic!("{body}: {e}")).0
}

/// The codes of the warnings about a scene.
fn warnings(body: &str) -> Vec<String> {
    read_body(body).unwrap_or_else(|e| panic!("{body}: {e}")).1.into_iter().map(|w| w.code).collect()
}

/// Checks that the body, whose first line is the scene's second, fails at the place and with words of the message.
#[track_caller]
fn assert_fails(body: &str, code: ErrorCode, line: u32, column: u32, words: &str) {
    let text = format!("SBT-raytracer 1.0\n{body}");
    let error = read_in(&std::env::temp_dir(), text.as_bytes(), Limits::default()).expect_err(body);
    assert_eq!(error.code, code, "{error}");
    assert_eq!(error.place, Place::Text { line, column }, "{error}");
    assert!(error.message.contains(words), "{error}");
}

fn phong(material: &Material) -> &Phong {
    match &material.surface {
        Surface::Phong(phong) => phong,
        other => panic!("not a .ray material: {other:?}"),
    }
}

/// The diffuse colour of each instance's own material.
fn diffuse_of_instances(scene: &Scene) -> Vec<[f32; 3]> {
    let material = |mesh: u32| &scene.materials[scene.meshes[mesh as usize].material as usize];
    scene.instances.iter().map(|i| phong(material(i.mesh)).diffuse.factor).collect()
}
