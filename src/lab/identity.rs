//! What makes a run the same run when a study is asked for again.

use crate::batch::Ready;
use crate::settings::{RenderSettings, Settings};
use crate::write::Metadata;

/// The hash of the asset's files.
pub(super) fn content(ready: &Ready) -> String {
    ready.outcome.content.clone().unwrap_or_default()
}

/// Settings as text; how many samples there are is no part of a run's identity, nor what changes no pixel.
pub(super) fn text_of(settings: &Settings) -> Result<String, String> {
    let mut settings = settings.clone();
    settings.render.spp = 0;
    settings.prepare.simd = Default::default();
    serde_json::to_string(&settings).map_err(|e| e.to_string())
}

/// A short hash of these parts and the version of Kiln.
pub(super) fn key(parts: &[&str]) -> String {
    let mut hasher = blake3::Hasher::new();
    hasher.update(env!("CARGO_PKG_VERSION").as_bytes());
    for part in parts {
        hasher.update(&[0]);
        hasher.update(part.as_bytes());
    }
    hasher.finalize().to_hex()[..24].to_string()
}

/// What pictures of a study say about themselves.
pub(super) fn metadata(name: &str, settings: &RenderSettings, spp: u32) -> Metadata {
    Metadata {
        software: Metadata::software(),
        source: name.into(),
        content: String::new(),
        settings: String::new(),
        seed: settings.seed,
        spp,
        view: 0,
        stated: None,
        denoised: None,
    }
}
