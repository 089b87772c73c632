//! What is known about glTF extensions.

use super::report::Report;
use crate::{ErrorCode, ImportError, Place};
use serde_json::Value;

/// Extensions whose meaning is honoured.
pub(crate) const SUPPORTED: &[&str] = &[
    "EXT_materials_diffuse_roughness",
    "EXT_mesh_gpu_instancing",
    "EXT_meshopt_compression",
    "EXT_texture_webp",
    "KHR_animation_pointer",
    "KHR_draco_mesh_compression",
    "KHR_lights_punctual",
    "KHR_materials_anisotropy",
    "KHR_materials_clearcoat",
    "KHR_materials_diffuse_roughness",
    "KHR_materials_diffuse_transmission",
    "KHR_materials_dispersion",
    "KHR_materials_emissive_strength",
    "KHR_materials_ior",
    "KHR_materials_iridescence",
    "KHR_materials_pbrSpecularGlossiness",
    "KHR_materials_sheen",
    "KHR_materials_specular",
    "KHR_materials_transmission",
    "KHR_materials_unlit",
    "KHR_materials_variants",
    "KHR_materials_volume",
    "KHR_mesh_quantization",
    "KHR_meshopt_compression",
    "KHR_node_visibility",
    "KHR_texture_basisu",
    "KHR_texture_transform",
];

/// Extensions that change nothing in a picture.
pub(crate) const WITHOUT_EFFECT: &[&str] = &["KHR_xmp", "KHR_xmp_json_ld"];

/// Checks the lists of used and required extensions.
///
/// # Errors
/// [`ErrorCode::Unsupported`] that names the first required extension that is not known.
pub(super) fn check(json: &Value, report: &mut Report) -> Result<(), ImportError> {
    for (i, name) in names(json, "extensionsRequired").enumerate() {
        let known = [SUPPORTED, WITHOUT_EFFECT].iter().any(|list| list.contains(&name));
        if !known {
            let place = Place::Json(format!("/extensionsRequired/{i}"));
            return Err(ImportError::new(ErrorCode::Unsupported, format!("requires the extension {name}")).at(place));
        }
    }
    let mut warned: Vec<&str> = Vec::new();
    // The list is the file's; names beyond a thousand are nobody's.
    for (i, name) in names(json, "extensionsUsed").enumerate().take(1000) {
        let known = [SUPPORTED, WITHOUT_EFFECT].iter().any(|list| list.contains(&name));
        if !known && !warned.contains(&name) {
            warned.push(name);
            let message = format!("{name} is ignored{}", without(name));
            report.warn("unsupported-extension", format!("/extensionsUsed/{i}"), message);
        }
    }
    Ok(())
}

/// What a picture lacks without an extension that is known but not honoured.
fn without(extension: &str) -> &'static str {
    match extension {
        "KHR_materials_volume_scatter" => ": inside bodies light is absorbed, and not scattered",
        "KHR_materials_subsurface" | "ADOBE_materials_thin_transparency" => ": its light goes through by other rules",
        "EXT_texture_avif" => ": AVIF images are not decoded, and textures fall back on their other source",
        "MSFT_texture_dds" => ": DDS images are not decoded, and textures fall back on their other source",
        "EXT_lights_image_based" => ": its environment does not light the asset (--env FILE does)",
        "EXT_lights_ies" => ": its lamps shine by their cones alone",
        "MSFT_lod" => ": the finest level is shown",
        "KHR_gaussian_splatting" => ": splats are points, which are not drawn",
        _ => "",
    }
}

fn names<'a>(json: &'a Value, list: &str) -> impl Iterator<Item = &'a str> {
    // What is no string counts as a name, so that the positions are right.
    json.get(list).and_then(Value::as_array).into_iter().flatten().map(|name| name.as_str().unwrap_or("(no name)"))
}
