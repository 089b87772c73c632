//! What a document says about itself, for people who ask.

use crate::contents::{Clip, Contents, SourceMaterial};
use serde_json::Value;

/// Items listed at most: beyond it a list is nobody's.
const LISTED: usize = 10_000;

fn list<'a>(document: &'a Value, pointer: &str) -> impl Iterator<Item = &'a Value> {
    document.pointer(pointer).and_then(Value::as_array).into_iter().flatten().take(LISTED)
}

fn text(value: Option<&Value>) -> String {
    value.and_then(Value::as_str).unwrap_or_default().to_owned()
}

/// Names of the items of an array, empty where they have none.
pub(super) fn names(document: &Value, pointer: &str) -> Vec<String> {
    list(document, pointer).map(|item| text(item.get("name"))).collect()
}

/// Where the list of variants is.
pub(super) const VARIANTS: &str = "/extensions/KHR_materials_variants/variants";

/// Reads it off.
pub(super) fn of(document: &Value) -> Contents {
    let strings = |pointer: &str| list(document, pointer).map(|name| text(Some(name))).collect();
    let material = |m: &Value| SourceMaterial {
        name: text(m.get("name")),
        extensions: m.get("extensions").and_then(Value::as_object).map_or(Vec::new(), |e| e.keys().cloned().collect()),
    };
    Contents {
        generator: text(document.pointer("/asset/generator")),
        extensions_used: strings("/extensionsUsed"),
        extensions_required: strings("/extensionsRequired"),
        animations: list(document, "/animations").map(|a| clip(document, a)).collect(),
        variants: names(document, VARIANTS),
        materials: list(document, "/materials").map(material).collect(),
    }
}

fn clip(document: &Value, animation: &Value) -> Clip {
    let end = |sampler: &Value| {
        let input = sampler.get("input")?.as_u64()?;
        document.pointer(&format!("/accessors/{input}/max/0"))?.as_f64()
    };
    Clip {
        name: text(animation.get("name")),
        seconds: list(animation, "/samplers")
            .filter_map(end)
            .fold(None, |most, end| Some(end.max(most.unwrap_or(end)))),
        channels: animation.get("channels").and_then(Value::as_array).map_or(0, |c| c.len() as u64),
    }
}
