//! Leaves out of an object what its type cannot read, so that one bad member costs itself and not the object.

use serde::de::DeserializeOwned;
use serde_json::{Map, Value};

/// Reads an object; where it cannot be read as it is, without those of its members that cannot be read by themselves. `dropped` is
/// told of each of these with the pointer below the object and what is wrong.
///
/// # Errors
/// When the object cannot be read without them either.
pub(super) fn read<T: DeserializeOwned>(item: Value, mut dropped: impl FnMut(String, String)) -> serde_json::Result<T> {
    match T::deserialize(&item) {
        Ok(read) => return Ok(read),
        Err(error) if !item.is_object() => return Err(error),
        Err(_) => {}
    }
    let mut lost = Vec::new();
    let sound = without_unreadable(item, &|alone| T::deserialize(&alone).err().map(|e| e.to_string()), "", &mut lost);
    let read = serde_json::from_value(sound)?;
    lost.into_iter().for_each(|(pointer, why)| dropped(pointer, why));
    Ok(read)
}

/// `flaw` says what is wrong with the whole that has nothing but this value in its place.
fn without_unreadable(
    value: Value,
    flaw: &dyn Fn(Value) -> Option<String>,
    pointer: &str,
    lost: &mut Vec<(String, String)>,
) -> Value {
    let Value::Object(members) = value else { return value };
    let mut sound = Map::new();
    // Some members can only be read beside others: those that can by themselves go first.
    let (first, others): (Vec<_>, Vec<_>) =
        members.into_iter().partition(|(key, member)| flaw(one(key, member.clone())).is_none());
    sound.extend(first);
    for (key, member) in others {
        let beside = |value: Value| {
            let mut all = sound.clone();
            all.insert(key.clone(), value);
            flaw(Value::Object(all))
        };
        let Some(why) = beside(member.clone()) else {
            sound.insert(key, member);
            continue;
        };
        let place = format!("{pointer}/{}", key.replace('~', "~0").replace('/', "~1"));
        let mut below = Vec::new();
        let is_object = member.is_object();
        let rest = without_unreadable(member, &beside, &place, &mut below);
        if is_object && !below.is_empty() && beside(rest.clone()).is_none() {
            lost.append(&mut below);
            sound.insert(key, rest);
        } else {
            lost.push((place, why));
        }
    }
    Value::Object(sound)
}

fn one(key: &str, value: Value) -> Value {
    Value::Object(Map::from_iter([(key.to_owned(), value)]))
}

#[cfg(test)]
mod tests {
    use super::*;
    use gltf::json::Material;
    use serde_json::json;

    #[test]
    fn what_cannot_be_read_costs_itself() {
        let material = json!({
            "name": "a", "alphaCutoff": "half", "normalTexture": {"index": "one", "scale": 2},
            "pbrMetallicRoughness": {"roughnessFactor": "0.5", "metallicFactor": 0.25, "baseColorTexture": {"index": 3}},
        });
        let mut lost = Vec::new();
        let read: Material = read(material, |pointer, _| lost.push(pointer)).unwrap();
        lost.sort();
        assert_eq!(lost, ["/alphaCutoff", "/normalTexture", "/pbrMetallicRoughness/roughnessFactor"]);
        assert_eq!(read.name.as_deref(), Some("a"));
        let pbr = read.pbr_metallic_roughness;
        assert_eq!((pbr.metallic_factor.0, pbr.roughness_factor.0), (0.25, 1.0));
        assert_eq!(pbr.base_color_texture.map(|t| t.index.value()), Some(3));
        assert!(read.normal_texture.is_none());
        // What needs an index beside it is not lost with a bad neighbour.
        let material = json!({"normalTexture": {"index": 0, "texCoord": 1, "scale": "x"}});
        let mut lost = Vec::new();
        let read: Material = super::read(material, |pointer, _| lost.push(pointer)).unwrap();
        assert_eq!(lost, ["/normalTexture/scale"]);
        assert_eq!(read.normal_texture.map(|t| (t.index.value(), t.tex_coord)), Some((0, 1)));
        assert!(super::read::<Material>(json!(3), |_, _| {}).is_err());
    }
}
