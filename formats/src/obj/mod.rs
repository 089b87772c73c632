//! The OBJ + MTL importer.
//!
//! Text goes through a checking reader (`scan`) that drops or mends what is unsound, with the line. Where it meets nothing but
//! plain statements, their numbers are known by then (`plain`), else `tobj` parses what is left; `mtl` and `material` make
//! glTF-like materials of the MTL statements. Choices where the formats are silent or their exporters disagree:
//! - one mesh per material (and per presence of normals and texture coordinates); faces without `vn` are smooth within
//!   their smoothing group (`s`), and flat without one. Attributes that only some corners of a face have are not used on that face;
//! - vertex colours are sRGB-encoded display values, 0 … 1 or, if any exceeds 2, 0 … 255; MTL colours are linear;
//! - a broken vertex costs its faces; a broken index to a texture coordinate or normal costs only that attribute;
//! - coordinates far from the origin move into the instances' transforms, in double precision.

mod faces;
mod geometry;
mod libraries;
mod log;
mod map;
mod material;
pub(crate) mod mtl;
mod number;
mod pieces;
mod plain;
pub(crate) mod scan;
mod smooth;
mod text;
mod textures;
mod vertices;

use crate::repair::tangents;
use crate::scene::{Instance, Material, MaterialId, Mesh, TextureRef, UpAxis};
use crate::{Control, ImportError, Resources, Scene, Warning};
use std::collections::BTreeMap;

/// Reads the bytes of an OBJ file and the MTL and image files that it refers to.
///
/// # Errors
/// [`crate::ErrorCode::Syntax`] for what is no text, [`crate::ErrorCode::Empty`] for a text without faces,
/// [`crate::ErrorCode::Invalid`] with the first line when no face is sound, [`crate::ErrorCode::TooLarge`],
/// [`crate::ErrorCode::Stopped`]. Everything else is mended, with a warning.
pub fn import(
    bytes: Vec<u8>,
    resources: &mut Resources,
    warnings: &mut Vec<Warning>,
    control: &Control,
) -> Result<Scene, ImportError> {
    let mut log = log::Log::new(warnings);
    let result = import_logged(bytes, resources, &mut log, control);
    log.finish();
    result
}

fn import_logged(
    bytes: Vec<u8>,
    resources: &mut Resources,
    log: &mut log::Log,
    control: &Control,
) -> Result<Scene, ImportError> {
    let text = text::decode(bytes)?;
    let mut scan = scan::scan(&text, resources.limits().max_triangles, log, control)?;
    let models = geometry::parse(&mut scan, control)?;
    let scan = scan.without_text();
    drop(text);
    let libraries = libraries::Libraries::load(&scan.libraries, resources, log, control)?;
    // Only materials that faces use.
    let used: BTreeMap<Option<u32>, MaterialId> = scan.parts.iter().map(|part| (part.material, 0)).collect();
    let name = |index: &Option<u32>| index.and_then(|i| scan.materials.get(i as usize));
    let maps = used.keys().filter_map(|index| libraries.get(&name(index)?.1)).flat_map(mtl::Mtl::maps);
    let mut textures = textures::Textures::load(maps, resources, log, control)?;
    let mut scene = Scene { up: UpAxis::Y, ..Scene::default() };
    let mut ids = used.clone();
    for (index, id) in &mut ids {
        *id = scene.materials.len() as MaterialId;
        let (line, name) = name(index).map_or((0, ""), |(line, name)| (*line, name.as_str()));
        scene.materials.push(match libraries.get(name) {
            Some(mtl) => material::lower(mtl, &mut textures, log),
            None if index.is_none() && scan.has_colors => material::default(name, [1.0; 3]),
            None => {
                if !name.is_empty() && libraries.complete && !scan.libraries.is_empty() {
                    log.warn("missing-material", line, || format!("no library has material '{name}'; shown in grey"));
                }
                material::default_grey(name)
            }
        });
    }
    (scene.images, scene.textures) = (textures.images, textures.textures);
    let geometry = geometry::build(models, &scan.parts, control)?;
    for (part, mesh) in scan.parts.iter().zip(geometry.meshes) {
        let material = ids.get(&part.material).copied().unwrap_or_default();
        let material_name = scene.materials.get(material as usize).map_or("", |m| m.name.as_str());
        let name = if part.name.is_empty() { material_name } else { &part.name }.to_owned();
        let id = scene.meshes.len() as u32;
        scene.instances.push(Instance { name: name.clone(), mesh: id, transform: geometry.transform });
        let mut mesh = Mesh { name, material, ..mesh };
        let lowered = scene.materials.get(material as usize);
        let grain = lowered.and_then(Material::layers).filter(|l| l.need_tangents()).map(|_| TextureRef::new(0));
        let source = lowered.and_then(|m| m.normal_map).map(|n| n.texture).or(grain);
        if let Some(source) = source.filter(|_| !resources.is_survey()) {
            let made = tangents::generate(&mut mesh, usize::from(source.uv_set), &source.transform);
            if let Err(why) = made {
                let message =
                    || format!("the normal map or anisotropy of material '{material_name}' is left out: {why}");
                log.warn("normal-map-ignored", "", message);
            }
        }
        scene.meshes.push(mesh);
    }
    Ok(scene)
}
