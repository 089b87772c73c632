//! KHR_materials_variants: the document as it is in one of them.

use super::animation::listed;
use super::contents;
use super::document::invalid;
use crate::ImportError;
use crate::show::Show;
use serde_json::Value;

/// Gives the primitives the materials of a variant.
///
/// # Errors
/// [`crate::ErrorCode::Invalid`] when the document has variants, but not this one.
pub(super) fn apply(document: &mut Value, variant: &str) -> Result<(), ImportError> {
    let names = contents::names(document, contents::VARIANTS);
    if names.is_empty() {
        return Ok(());
    }
    let Some(index) = Show::find(&names, variant) else {
        let message = format!("there is no variant '{variant}', but {}", listed(&names));
        return Err(invalid(contents::VARIANTS, message));
    };
    let meshes = document.get_mut("meshes").and_then(Value::as_array_mut).into_iter().flatten();
    for primitive in meshes.filter_map(|m| m.get_mut("primitives")?.as_array_mut()).flatten() {
        let mappings = primitive.pointer("/extensions/KHR_materials_variants/mappings").and_then(Value::as_array);
        let is_meant = |mapping: &&Value| {
            let variants = mapping.get("variants").and_then(Value::as_array).into_iter().flatten();
            variants.filter_map(Value::as_u64).any(|v| v == index as u64)
        };
        let material = mappings.into_iter().flatten().find(is_meant).and_then(|m| m.get("material")).cloned();
        if let (Some(material), Some(members)) = (material, primitive.as_object_mut()) {
            members.insert("material".into(), material);
        }
    }
    Ok(())
}
