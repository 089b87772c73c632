//! What a channel points at, and writing to it.

use serde_json::{Map, Value};

/// The JSON pointer of the property that a channel moves; `None` for a channel without a known target.
pub(super) fn of_channel(channel: &Value) -> Option<String> {
    let target = channel.get("target")?;
    let path = target.get("path")?.as_str()?;
    if path == "pointer" {
        let pointer = target.pointer("/extensions/KHR_animation_pointer/pointer")?;
        return Some(pointer.as_str()?.to_owned());
    }
    let node = target.get("node")?.as_u64()?;
    matches!(path, "translation" | "rotation" | "scale" | "weights").then(|| format!("/nodes/{node}/{path}"))
}

/// Whether the property is a node's rotation, a quaternion.
pub(super) fn is_rotation(pointer: &str) -> bool {
    pointer.starts_with("/nodes/") && pointer.ends_with("/rotation") && pointer.matches('/').count() == 3
}

/// Whether a property may move: the glTF object model's, as far as pictures show them. Structure may not.
fn is_mutable(parts: &[String]) -> bool {
    match parts.iter().map(String::as_str).collect::<Vec<_>>().as_slice() {
        ["nodes", _, "translation" | "rotation" | "scale" | "weights"] => true,
        ["nodes", _, "weights", _] | ["meshes", _, "weights"] | ["meshes", _, "weights", _] => true,
        ["nodes", _, "extensions", "KHR_node_visibility", "visible"] => true,
        ["cameras", _, "perspective" | "orthographic", _] => true,
        ["extensions", "KHR_lights_punctual", "lights", _, "color" | "intensity" | "range"] => true,
        ["extensions", "KHR_lights_punctual", "lights", _, "spot", _] => true,
        ["materials", _, .., last] => !matches!(*last, "index" | "texCoord" | "name" | "extensions"),
        _ => false,
    }
}

/// Writes the components of a value where a JSON pointer says. Objects that hold defaults are made.
///
/// # Errors
/// Why it cannot be, as the end of a sentence.
pub(super) fn put(document: &mut Value, pointer: &str, components: &[f64]) -> Result<(), &'static str> {
    let parts: Vec<String> = pointer.split('/').skip(1).map(|p| p.replace("~1", "/").replace("~0", "~")).collect();
    if !pointer.starts_with('/') || !is_mutable(&parts) {
        return Err("is no property that can be animated");
    }
    let Some((last, path)) = parts.split_last() else { return Err("is no property") };
    // With a matrix the node's other properties mean nothing (glTF 2.0, 3.5.3).
    if let [kind, node] = path
        && kind == "nodes"
        && document.pointer(&format!("/nodes/{node}/matrix")).is_some()
        && last != "weights"
    {
        return Err("is a property of a node with a matrix, which cannot be animated");
    }
    let mut holder = document;
    let mut previous = "";
    for part in path {
        // Extensions and the metallic-roughness model have defaults; textures and nodes do not come from nowhere.
        let made = part == "extensions" || previous == "extensions" || part == "pbrMetallicRoughness";
        holder = match holder {
            Value::Object(members) if made || members.contains_key(part) => {
                members.entry(part).or_insert_with(|| Value::Object(Map::new()))
            }
            Value::Array(items) => item(items, part)?,
            _ => return Err("is not there"),
        };
        previous = part;
    }
    let old = match holder {
        Value::Object(members) => members.entry(last.as_str()).or_insert(Value::Null),
        Value::Array(items) => item(items, last)?,
        _ => return Err("is not there"),
    };
    *old = match (components, &*old) {
        ([x], _) if last == "visible" => Value::Bool(*x != 0.0),
        // Weights and vectors of one component are arrays still.
        ([x], Value::Array(_)) => Value::from(vec![*x]),
        ([x], _) if last != "weights" => Value::from(*x),
        (many, Value::Array(now)) if last != "weights" && now.len() != many.len() => {
            return Err("has another number of components than the animation");
        }
        (many, _) => Value::from(many.to_vec()),
    };
    Ok(())
}

fn item<'a>(items: &'a mut [Value], index: &str) -> Result<&'a mut Value, &'static str> {
    index.parse::<usize>().ok().and_then(|i| items.get_mut(i)).ok_or("is not there")
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    #[test]
    fn values_are_written_where_they_belong_and_nowhere_else() {
        let mut document = json!({
            "nodes": [{"children": [1]}, {"matrix": [1]}],
            "materials": [{"emissiveTexture": {"index": 0}}],
            "extensions": {"KHR_lights_punctual": {"lights": [{"type": "point"}]}}
        });
        let before = document.clone();
        for (pointer, value) in [
            ("/nodes/7/translation", [1.0, 2.0, 3.0].as_slice()),
            ("/nodes/1/translation", &[1.0, 2.0, 3.0]),
            ("/nodes/0/children", &[1.0]),
            ("/nodes/0/mesh", &[1.0]),
            ("/accessors/0/count", &[1e9]),
            ("/materials/0/emissiveTexture/index", &[1.0]),
            ("/materials/0/normalTexture/scale", &[1.0]),
            ("/cameras/0/perspective/yfov", &[1.0]),
            ("nodes/0/translation", &[1.0, 2.0, 3.0]),
            ("", &[1.0]),
        ] {
            assert!(put(&mut document, pointer, value).is_err(), "{pointer}");
        }
        assert_eq!(document, before);
        put(&mut document, "/nodes/0/weights", &[0.5]).unwrap();
        put(&mut document, "/nodes/0/extensions/KHR_node_visibility/visible", &[0.0]).unwrap();
        put(&mut document, "/materials/0/pbrMetallicRoughness/baseColorFactor", &[1.0, 0.5, 0.25, 1.0]).unwrap();
        let offset = "/materials/0/emissiveTexture/extensions/KHR_texture_transform/offset";
        put(&mut document, offset, &[0.5, 0.75]).unwrap();
        put(&mut document, "/extensions/KHR_lights_punctual/lights/0/intensity", &[4.0]).unwrap();
        assert_eq!(document["nodes"][0]["weights"], json!([0.5]));
        assert_eq!(document["nodes"][0]["extensions"]["KHR_node_visibility"]["visible"], json!(false));
        assert_eq!(document["materials"][0]["pbrMetallicRoughness"]["baseColorFactor"], json!([1.0, 0.5, 0.25, 1.0]));
        assert_eq!(document.pointer(offset), Some(&json!([0.5, 0.75])));
        assert_eq!(document["extensions"]["KHR_lights_punctual"]["lights"][0]["intensity"], json!(4.0));
        assert!(put(&mut document, offset, &[0.5, 0.75, 1.0]).is_err(), "three components for two");
    }
}
