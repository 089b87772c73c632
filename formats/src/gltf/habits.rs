//! Mistakes that exporters make often enough to be known for what they mean, mended in the document before it is read.

use super::report::Report;
use serde_json::Value;

const COMPONENTS: std::ops::RangeInclusive<u64> = 5120..=5123;

/// Mends a document: members that are `null` count as missing, colours of three components get their fourth, integers for
/// colours are normalised, and signed ones for joints are taken as unsigned.
pub(super) fn mend(document: &mut Value, report: &mut Report) {
    drop_nulls(document);
    for material in objects(document, "materials") {
        for pointer in
            ["/pbrMetallicRoughness/baseColorFactor", "/extensions/KHR_materials_pbrSpecularGlossiness/diffuseFactor"]
        {
            if let Some(Value::Array(factor)) = material.pointer_mut(pointer)
                && factor.len() == 3
            {
                factor.push(Value::from(1.0));
            }
        }
    }
    let (mut colors, mut joints) = (Vec::new(), Vec::new());
    for mesh in objects(document, "meshes") {
        for primitive in objects(mesh, "primitives") {
            let attributes = primitive.get("attributes").and_then(Value::as_object);
            for (name, accessor) in attributes.into_iter().flatten() {
                let index = accessor.as_u64().and_then(|i| usize::try_from(i).ok());
                match index {
                    Some(i) if name.starts_with("COLOR_") => colors.push(i),
                    Some(i) if name.starts_with("JOINTS_") => joints.push(i),
                    _ => {}
                }
            }
        }
    }
    let Some(accessors) = document.get_mut("accessors").and_then(Value::as_array_mut) else { return };
    let component = |accessor: &Value| accessor.get("componentType").and_then(Value::as_u64);
    for i in colors {
        let Some(accessor) = accessors.get_mut(i) else { continue };
        let integer = component(accessor).is_some_and(|c| COMPONENTS.contains(&c));
        if integer && accessor.get("normalized") != Some(&Value::Bool(true)) {
            accessor["normalized"] = Value::Bool(true);
            let message = "integers for colours are to be normalised, and are taken so";
            report.warn("invalid-object", format!("/accessors/{i}/normalized"), message);
        }
    }
    for i in joints {
        let Some(accessor) = accessors.get_mut(i) else { continue };
        if let Some(signed @ (5120 | 5122)) = component(accessor) {
            accessor["componentType"] = Value::from(signed + 1);
            let message = "joints are to be unsigned, and are taken so";
            report.warn("invalid-object", format!("/accessors/{i}/componentType"), message);
        }
    }
}

/// The objects in a list of an object.
fn objects<'a>(parent: &'a mut Value, list: &str) -> impl Iterator<Item = &'a mut Value> {
    parent.get_mut(list).and_then(Value::as_array_mut).into_iter().flatten().filter(|item| item.is_object())
}

/// The nesting is bounded by that of the JSON reader.
fn drop_nulls(value: &mut Value) {
    match value {
        Value::Object(members) => {
            members.retain(|_, member| !member.is_null());
            members.values_mut().for_each(drop_nulls);
        }
        Value::Array(items) => items.iter_mut().for_each(drop_nulls),
        _ => {}
    }
}
