//! Which sets of texture coordinates a material reads. The scene has room for two a mesh, and files number them as they like.

use serde_json::Value;

/// The two sets that a mesh gets, as numbers of `TEXCOORD_n`.
pub(super) type UvSets = [u32; 2];

/// Without a material, and for those that read no others.
pub(super) const FIRST_TWO: UvSets = [0, 1];

/// The sets of each material of a document: the first two that its textures name, where any is beyond the first two of all.
pub(super) fn of_materials(document: &Value) -> Vec<UvSets> {
    let materials = document.get("materials").and_then(Value::as_array);
    materials.into_iter().flatten().map(of_material).collect()
}

fn of_material(material: &Value) -> UvSets {
    let mut named = Vec::new();
    collect(material, &mut named);
    match (named.iter().all(|set| *set < 2), named.as_slice()) {
        (true, _) | (_, []) => FIRST_TWO,
        (_, [one]) => [*one, if *one == 0 { 1 } else { 0 }],
        (_, [one, two, ..]) => [*one, *two],
    }
}

/// The numbers of sets by whatever looks like a reference to a texture, in the file's order and each once. Occlusion is not
/// read. The nesting is bounded by that of the JSON reader.
fn collect(value: &Value, named: &mut Vec<u32>) {
    match value {
        Value::Object(fields) => {
            if fields.get("index").is_some_and(Value::is_u64) {
                let own = |v: &Value| v.get("texCoord")?.as_u64();
                let moved = value.pointer("/extensions/KHR_texture_transform").and_then(own);
                let set = u32::try_from(moved.or(own(value)).unwrap_or(0)).unwrap_or(u32::MAX);
                if !named.contains(&set) && named.len() < 3 {
                    named.push(set);
                }
            }
            fields.iter().filter(|(key, _)| *key != "occlusionTexture").for_each(|(_, v)| collect(v, named));
        }
        Value::Array(items) => items.iter().for_each(|v| collect(v, named)),
        _ => {}
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    #[test]
    fn sets_beyond_the_first_two_take_their_places() {
        let texture = |set: u32| json!({"index": 0, "texCoord": set});
        let pbr = |base: u32, rough: u32| json!({"baseColorTexture": texture(base), "metallicRoughnessTexture": texture(rough)});
        let materials = json!({"materials": [
            {"pbrMetallicRoughness": pbr(0, 1), "normalTexture": {"index": 1}},
            {"pbrMetallicRoughness": {"baseColorTexture": texture(2)}},
            {"pbrMetallicRoughness": pbr(3, 1), "occlusionTexture": texture(2)},
            {"normalTexture": {"index": 0, "extensions": {"KHR_texture_transform": {"texCoord": 4}}}, "emissiveTexture": {"index": 0}},
            {"extensions": {"KHR_materials_sheen": {"sheenColorTexture": texture(5)}}},
            {}
        ]});
        let mut got = of_materials(&materials);
        got[2].sort_unstable();
        got[3].sort_unstable();
        assert_eq!(got, [[0, 1], [2, 0], [1, 3], [0, 4], [5, 0], [0, 1]]);
    }
}
