//! Indices that lead nowhere, for a file in which nothing is found to draw: they may be why.

use super::document::invalid;
use crate::ImportError;
use serde_json::Value;

/// Where a document names other objects of its own by number (`*`: every element or key), and what.
const REFERENCES: [(&str, &str); 22] = [
    ("scenes/*/nodes/*", "/nodes"),
    ("nodes/*/children/*", "/nodes"),
    ("nodes/*/mesh", "/meshes"),
    ("nodes/*/skin", "/skins"),
    ("nodes/*/camera", "/cameras"),
    ("nodes/*/extensions/KHR_lights_punctual/light", "/extensions/KHR_lights_punctual/lights"),
    ("meshes/*/primitives/*/indices", "/accessors"),
    ("meshes/*/primitives/*/attributes/*", "/accessors"),
    ("meshes/*/primitives/*/targets/*/*", "/accessors"),
    ("meshes/*/primitives/*/material", "/materials"),
    ("accessors/*/bufferView", "/bufferViews"),
    ("accessors/*/sparse/indices/bufferView", "/bufferViews"),
    ("accessors/*/sparse/values/bufferView", "/bufferViews"),
    ("bufferViews/*/buffer", "/buffers"),
    ("images/*/bufferView", "/bufferViews"),
    ("textures/*/source", "/images"),
    ("textures/*/sampler", "/samplers"),
    ("skins/*/joints/*", "/nodes"),
    ("skins/*/skeleton", "/nodes"),
    ("skins/*/inverseBindMatrices", "/accessors"),
    ("animations/*/samplers/*/input", "/accessors"),
    ("animations/*/samplers/*/output", "/accessors"),
];

/// The first reference of a document that leads nowhere, as an error at its JSON pointer.
pub(super) fn first_unresolved(document: &Value) -> Option<ImportError> {
    REFERENCES.iter().find_map(|(path, target)| {
        let there_are = document.pointer(target).and_then(Value::as_array).map_or(0, Vec::len);
        let steps: Vec<&str> = path.split('/').collect();
        let (pointer, index) = unresolved(document, &steps, there_are as u64)?;
        let what = target.rsplit('/').next().unwrap_or_default();
        Some(invalid(pointer, format!("{index} of {there_are} {what}, and nothing is drawn")))
    })
}

/// Pointer and value of the first index along a path that is not below `there_are`.
fn unresolved(value: &Value, steps: &[&str], there_are: u64) -> Option<(String, u64)> {
    let Some((step, rest)) = steps.split_first() else {
        return value.as_u64().filter(|index| *index >= there_are).map(|index| (String::new(), index));
    };
    let below = |key: &str, value: &Value| {
        let (pointer, index) = unresolved(value, rest, there_are)?;
        Some((format!("/{}{pointer}", key.replace('~', "~0").replace('/', "~1")), index))
    };
    match (*step, value) {
        ("*", Value::Array(items)) => items.iter().enumerate().find_map(|(i, v)| below(&i.to_string(), v)),
        ("*", Value::Object(fields)) => fields.iter().find_map(|(key, v)| below(key, v)),
        (key, _) => below(key, value.get(key)?),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Place;
    use serde_json::json;

    #[test]
    fn the_first_index_that_leads_nowhere_is_named() {
        let place = |document: Value| first_unresolved(&document).map(|e| e.place);
        let at = |pointer: &str| Some(Place::Json(pointer.into()));
        assert_eq!(place(json!({"nodes": [{"mesh": 0}], "meshes": [{"primitives": []}]})), None);
        assert_eq!(place(json!({"nodes": [{}, {"camera": 0}]})), at("/nodes/1/camera"));
        let primitive = json!({"attributes": {"A/B": 3}, "targets": [{"POSITION": 1}]});
        let document = json!({"meshes": [{"primitives": [primitive]}], "accessors": [{}]});
        assert_eq!(place(document), at("/meshes/0/primitives/0/attributes/A~1B"));
        let light = json!({"extensions": {"KHR_lights_punctual": {"light": 0}}});
        let there = "/nodes/0/extensions/KHR_lights_punctual/light";
        assert_eq!(place(json!({"nodes": [light]})), at(there));
    }
}
