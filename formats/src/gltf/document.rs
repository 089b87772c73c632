//! From loose JSON to the typed model of the `gltf` crate.
//!
//! The crate's own validation and accessor methods panic on bad input, so only its plain data types are used, element
//! by element: what cannot be read names its JSON pointer, and what is not needed for the geometry may be missing.

use super::prune;
use super::report::Report;
use crate::{ErrorCode, ImportError, Place};
use gltf::json;
use gltf::json::validation::Checked;
use serde::de::DeserializeOwned;
use serde_json::Value;

/// An error at a JSON pointer.
pub(super) fn invalid(pointer: impl Into<String>, message: impl Into<String>) -> ImportError {
    ImportError::new(ErrorCode::Invalid, message).at(Place::Json(pointer.into()))
}

/// Refuses other versions than 2.
///
/// # Errors
/// [`ErrorCode::Unsupported`] for another major version or a `minVersion` over 2.0, [`ErrorCode::Invalid`] when there
/// is no version.
pub(super) fn check_version(document: &Value) -> Result<(), ImportError> {
    let unsupported = |pointer: &str, message: String| {
        Err(ImportError::new(ErrorCode::Unsupported, message).at(Place::Json(pointer.into())))
    };
    if !document.is_object() {
        return Err(invalid("", "is JSON, but no glTF object"));
    }
    let Some(version) = document.pointer("/asset/version") else {
        // glTF 1.0 named its objects, 2.0 numbers them.
        if document.get("meshes").is_some_and(Value::is_object) {
            return unsupported("/asset", "is glTF 1.0; only version 2 can be read".into());
        }
        return Err(invalid("/asset", "gives no version"));
    };
    let number = |value: &Value| {
        // `"2"` and `2.0` are what some write by hand.
        let text = value.as_f64().map(|x| x.to_string());
        let text = text.as_deref().or(value.as_str())?;
        let (major, minor) = text.split_once('.').unwrap_or((text, "0"));
        Some((major.parse::<u32>().ok()?, minor.parse::<u32>().ok()?))
    };
    match number(version) {
        Some((2, _)) => {}
        Some((major, minor)) => {
            return unsupported("/asset/version", format!("is glTF {major}.{minor}; only version 2 can be read"));
        }
        None => return Err(invalid("/asset/version", "is no version number")),
    }
    match document.pointer("/asset/minVersion").map(number) {
        None | Some(Some((2, 0))) => Ok(()),
        Some(Some((major, minor))) => {
            unsupported("/asset/minVersion", format!("needs a reader of glTF {major}.{minor}; this one reads 2.0"))
        }
        Some(None) => Err(invalid("/asset/minVersion", "is no version number")),
    }
}

/// Takes the part of the typed model out of a document that says where data are: accessors, buffers and their views.
///
/// # Errors
/// [`ErrorCode::Invalid`] with the JSON pointer of the first of them that has a wrong form.
pub(super) fn storage(document: &mut Value) -> Result<json::Root, ImportError> {
    Ok(json::Root {
        accessors: strict(document, "accessors")?,
        buffers: strict(document, "buffers")?,
        buffer_views: strict(document, "bufferViews")?,
        ..json::Root::default()
    })
}

/// Reads the rest of the typed model, all but animations.
///
/// # Errors
/// [`ErrorCode::Invalid`] with the JSON pointer of the first element of the geometry that has a wrong form.
pub(super) fn read(document: &mut Value, storage: json::Root, report: &mut Report) -> Result<json::Root, ImportError> {
    for scene in document.get_mut("scenes").and_then(Value::as_array_mut).into_iter().flatten() {
        if let Some(scene) = scene.as_object_mut() {
            scene.entry("nodes").or_insert_with(|| Value::Array(Vec::new()));
        }
    }
    for (i, node) in document.get_mut("nodes").and_then(Value::as_array_mut).into_iter().flatten().enumerate() {
        let extensions = node.get_mut("extensions").and_then(Value::as_object_mut);
        let light = |e: &Value| e.get("light").is_none_or(|l| !l.is_u64());
        if let Some(extensions) = extensions.filter(|e| e.get("KHR_lights_punctual").is_some_and(light)) {
            extensions.remove("KHR_lights_punctual");
            let place = format!("/nodes/{i}/extensions/KHR_lights_punctual");
            report.warn("invalid-light", place, "names no light and is ignored");
        }
    }
    let scene = match document.get("scene") {
        None => None,
        Some(value) => match value.as_u64().and_then(|i| u32::try_from(i).ok()) {
            Some(index) => Some(json::Index::new(index)),
            None => return Err(invalid("/scene", "is no index")),
        },
    };
    let broken_camera = || json::Camera {
        name: None,
        orthographic: None,
        perspective: None,
        type_: Checked::Invalid,
        extensions: None,
        extras: None,
    };
    let no_image =
        || json::Image { buffer_view: None, mime_type: None, name: None, uri: None, extensions: None, extras: None };
    let no_texture = || json::Texture {
        name: None,
        sampler: None,
        source: json::Index::new(u32::MAX),
        extensions: None,
        extras: None,
    };
    let no_skin = || json::Skin {
        extensions: None,
        extras: None,
        inverse_bind_matrices: None,
        joints: Vec::new(),
        name: None,
        skeleton: None,
    };
    Ok(json::Root {
        scene,
        extensions: lights(document, report),
        meshes: strict(document, "meshes")?,
        nodes: strict(document, "nodes")?,
        scenes: strict(document, "scenes")?,
        cameras: lenient(document, "cameras", broken_camera, report)?,
        images: lenient(document, "images", no_image, report)?,
        materials: lenient(document, "materials", json::Material::default, report)?,
        samplers: lenient(document, "samplers", json::texture::Sampler::default, report)?,
        skins: lenient(document, "skins", no_skin, report)?,
        textures: lenient(document, "textures", no_texture, report)?,
        ..storage
    })
}

/// Removes what the typed model would stumble over or misread: application data (`extras`), names that are no text, extensions that are no objects, integers written as
/// `3.0`, and integers beyond 32 bits, which it would cut off (they become floats, which it refuses as indices).
pub(super) fn normalize(document: &mut Value) {
    normalize_member(document, "");
}

fn normalize_member(value: &mut Value, key: &str) {
    match value {
        Value::Object(members) => {
            members.remove("extras");
            if members.get("name").is_some_and(|name| !name.is_string()) {
                members.remove("name");
            }
            match members.get_mut("extensions") {
                Some(Value::Object(extensions)) => extensions.retain(|_, extension| extension.is_object()),
                Some(_) => drop(members.remove("extensions")),
                None => {}
            }
            members.iter_mut().for_each(|(key, member)| normalize_member(member, key));
        }
        Value::Array(items) => items.iter_mut().for_each(|item| normalize_member(item, key)),
        Value::Number(number) => {
            let long = matches!(key, "byteOffset" | "byteLength" | "count");
            if let Some(integer) = number.as_u64() {
                if integer > u64::from(u32::MAX) && !long {
                    *value = Value::from(integer as f64);
                }
            } else if let Some(float) = number.as_f64()
                && (0.0..=f64::from(u32::MAX)).contains(&float)
                && float.fract() == 0.0
                && float.is_sign_positive()
            {
                *value = Value::from(float as u64);
            }
        }
        _ => {}
    }
}

fn section(document: &mut Value, name: &str) -> Result<Vec<Value>, ImportError> {
    match document.get_mut(name).map(Value::take) {
        None => Ok(Vec::new()),
        Some(Value::Array(items)) => Ok(items),
        Some(_) => Err(invalid(format!("/{name}"), "is no array")),
    }
}

fn strict<T: DeserializeOwned>(document: &mut Value, name: &str) -> Result<Vec<T>, ImportError> {
    let parse = |(i, item)| serde_json::from_value(item).map_err(|e| invalid(format!("/{name}/{i}"), e.to_string()));
    section(document, name)?.into_iter().enumerate().map(parse).collect()
}

fn lenient<T: DeserializeOwned>(
    document: &mut Value,
    name: &str,
    instead: impl Fn() -> T,
    report: &mut Report,
) -> Result<Vec<T>, ImportError> {
    let mut parse = |(i, item)| {
        let mut lost = |pointer: String, why: String| {
            report.warn("invalid-object", format!("/{name}/{i}{pointer}"), format!("{why}; it is left out"));
        };
        prune::read(item, &mut lost).unwrap_or_else(|e| {
            lost(String::new(), e.to_string());
            instead()
        })
    };
    Ok(section(document, name)?.into_iter().enumerate().map(&mut parse).collect())
}

/// The lights of KHR_lights_punctual; one that cannot be read keeps its place as a light without a type.
fn lights(document: &mut Value, report: &mut Report) -> Option<json::extensions::root::Root> {
    use json::extensions::root::KhrLightsPunctual;
    use json::extensions::scene::khr_lights_punctual::Light;
    const POINTER: &str = "/extensions/KHR_lights_punctual/lights";
    let items = document.pointer_mut(POINTER)?.as_array_mut()?;
    let mut lights = Vec::new();
    for (i, item) in items.iter_mut().enumerate() {
        lights.push(serde_json::from_value(item.take()).unwrap_or_else(|e| {
            report.warn("invalid-object", format!("{POINTER}/{i}"), format!("{e}; it is left out"));
            Light {
                color: [0.0; 3],
                extensions: None,
                extras: None,
                intensity: 0.0,
                name: None,
                range: None,
                spot: None,
                type_: Checked::Invalid,
            }
        }));
    }
    Some(json::extensions::root::Root { khr_lights_punctual: Some(KhrLightsPunctual { lights }), ..Default::default() })
}
