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
    "MSFT_texture_dds",
];

/// Extensions that change nothing in a picture: what objects are, sound like, weigh, or do when they are touched.
pub(crate) const WITHOUT_EFFECT: &[&str] = &[
    "AGI_articulations",
    "AGI_stk_metadata",
    "EXT_feature_metadata",
    "EXT_instance_features",
    "EXT_mesh_features",
    "EXT_mesh_manifold",
    "EXT_structural_metadata",
    "FB_geometry_metadata",
    "GODOT_single_root",
    "GRIFFEL_bim_data",
    "KHR_audio_emitter",
    "KHR_implicit_shapes",
    "KHR_interactivity",
    "KHR_node_hoverability",
    "KHR_node_selectability",
    "KHR_physics_rigid_bodies",
    "KHR_xmp",
    "KHR_xmp_json_ld",
    "MOZ_hubs_components",
    "MSFT_packing_normalRoughnessMetallic",
    "MSFT_packing_occlusionRoughnessMetallic",
    "OMI_physics_body",
    "OMI_physics_joint",
    "OMI_physics_shape",
    "OMI_seat",
    "OMI_spawn_point",
    "VRM",
    "VRMC_node_constraint",
    "VRMC_springBone",
    "VRMC_vrm",
];

/// Extensions that an asset can be shown without, though it looks otherwise then, and what is missing. Even where the file
/// requires them there is a picture, with this said.
pub(crate) const SHOWN_WITHOUT: &[(&str, &str)] = &[
    ("ADOBE_materials_thin_transparency", "its light goes through by other rules"),
    ("CESIUM_RTC", "the asset stays at its own origin"),
    ("CESIUM_primitive_outline", "outlines are not drawn"),
    ("EXT_lights_ies", "its lamps shine by their cones alone"),
    ("EXT_lights_image_based", "its environment does not light the asset (--env FILE does)"),
    ("EXT_texture_avif", "AVIF images are not decoded, and textures fall back on their other source"),
    ("KHR_environment_map", "its environment does not light the asset (--env FILE does)"),
    ("KHR_gaussian_splatting", "splats are points, which are not drawn"),
    ("KHR_materials_subsurface", "its light goes through by other rules"),
    ("KHR_materials_volume_scatter", "inside bodies light is absorbed, and not scattered"),
    ("KHR_techniques_webgl", "materials with shaders of their own show their other properties"),
    ("KHR_texture_procedurals", "textures that are formulas are left out"),
    ("MOZ_lightmap", "light is computed, not read from maps"),
    ("MSFT_lod", "the finest level is shown"),
    ("NV_materials_mdl", "materials show their glTF properties"),
    ("VRMC_materials_mtoon", "shaded as other surfaces are, not as a drawing"),
];

/// Checks the lists of used and required extensions.
///
/// # Errors
/// [`ErrorCode::Unsupported`] that names the first required extension that is not known, or without which nothing
/// right can be shown.
pub(super) fn check(json: &Value, report: &mut Report) -> Result<(), ImportError> {
    for (i, name) in names(json, "extensionsRequired").enumerate() {
        let known = [SUPPORTED, WITHOUT_EFFECT].iter().any(|list| list.contains(&name));
        if !known && without(name).is_none() {
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
            let message = match without(name) {
                Some(missing) => format!("{name} is ignored: {missing}"),
                None => format!("{name} is ignored"),
            };
            report.warn("unsupported-extension", format!("/extensionsUsed/{i}"), message);
        }
    }
    Ok(())
}

/// What a picture lacks without an extension that is known but not honoured.
fn without(extension: &str) -> Option<&'static str> {
    SHOWN_WITHOUT.iter().find(|(name, _)| *name == extension).map(|(_, missing)| *missing)
}

fn names<'a>(json: &'a Value, list: &str) -> impl Iterator<Item = &'a str> {
    // What is no string counts as a name, so that the positions are right.
    json.get(list).and_then(Value::as_array).into_iter().flatten().map(|name| name.as_str().unwrap_or("(no name)"))
}
