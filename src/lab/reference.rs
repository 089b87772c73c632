use super::cell::luminance_of;
use super::store::with_ending;
use crate::accuracy::{Accuracy, CONFIDENCE, Display};
use crate::film::{Estimate, Film, Picture};
use crate::integrate::{View, render_pass};
use crate::metrics::{Show, Shown};
use crate::prepare::PreparedScene;
use crate::sampling::REPLICATES;
use crate::settings::RenderSettings;
use crate::write::{Metadata, atomic, exr};
use kiln_formats::{Control, Stopped};
use serde::{Deserialize, Serialize};
use std::path::Path;
use std::time::Instant;

/// The converged picture that a study measures against, with its own error.
#[derive(Clone, Debug)]
pub struct Reference {
    /// What is known of it.
    pub facts: ReferenceFacts,
    /// Linear.
    pub picture: Picture,
    /// As it is shown.
    pub shown: Shown,
}

/// A reference's facts.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ReferenceFacts {
    /// Names asset and settings.
    pub key: String,
    /// Camera paths per pixel.
    pub spp: u32,
    /// Estimated RMS error as displayed, levels 0–255.
    pub error: f64,
    /// Estimated relMSE.
    pub relmse: f64,
    /// Mean luminance.
    pub luminance: Estimate,
    /// Wall seconds that it took.
    pub seconds: f64,
    /// CPU seconds that it took.
    pub cpu_seconds: f64,
}

/// Samples per pixel of the first pass; later ones double.
const FIRST_PASS: u32 = 32;
/// No reference takes more samples per pixel.
const MOST: u32 = 1 << 20;

/// How much work goes into a reference.
#[derive(Clone, Copy, Debug)]
pub(super) enum Effort {
    /// So many samples per pixel.
    Samples(u32),
    /// About so many CPU seconds.
    CpuSeconds(f64),
}

impl Reference {
    /// Renders one: passes that double until the effort is spent.
    pub(super) fn make(
        (scene, view): (&PreparedScene, &View),
        settings: &RenderSettings,
        (key, display, show): (&str, &Display, &Show),
        effort: Effort,
        control: &Control,
    ) -> Result<Self, Stopped> {
        let clock = Instant::now();
        let mut film = Film::new(view.width, view.height, view.show_environment);
        let (mut cpu_seconds, mut next) = (0.0, FIRST_PASS);
        if let Effort::Samples(spp) = effort {
            next = spp.max(4);
        }
        loop {
            let begin = film.spp;
            cpu_seconds += render_pass(scene, view, settings, &mut film, begin..next, control)?.cpu_seconds;
            // Doubling the samples takes as long again as everything so far.
            match effort {
                Effort::CpuSeconds(limit) if 2.0 * cpu_seconds <= limit && next < MOST => next *= 2,
                // What is left of the time, in whole replicates.
                Effort::CpuSeconds(limit) if cpu_seconds < 0.8 * limit && next < MOST => {
                    next += (f64::from(next) * (limit - cpu_seconds) / cpu_seconds) as u32 / REPLICATES * REPLICATES
                        + REPLICATES;
                }
                _ => break,
            }
        }
        let picture = film.picture();
        let shown = Shown::of(&picture, show);
        let own = Accuracy::of(&film, display, CONFIDENCE);
        let (error, relmse) = own.map_or((0.0, 0.0), |own| (own.error, own.relmse));
        let seconds = clock.elapsed().as_secs_f64();
        let luminance = luminance_of(&film);
        let facts = ReferenceFacts { key: key.into(), spp: film.spp, error, relmse, luminance, seconds, cpu_seconds };
        Ok(Self { facts, picture, shown })
    }

    /// Reads one that was written with the same key; `None` when there is none.
    pub(super) fn read(stem: &Path, key: &str, show: &Show, max_texels: u64) -> Option<Self> {
        let facts = std::fs::read(with_ending(stem, ".json")).ok()?;
        let facts: ReferenceFacts = serde_json::from_slice(&facts).ok().filter(|f: &ReferenceFacts| f.key == key)?;
        let bytes = std::fs::read(with_ending(stem, ".exr")).ok()?;
        let picture = exr::decode(&bytes, max_texels).ok()?;
        let shown = Shown::of(&picture, show);
        Some(Self { facts, picture, shown })
    }

    /// Writes `STEM.exr` and `STEM.json`.
    ///
    /// # Errors
    /// A sentence.
    pub(super) fn write(&self, stem: &Path, metadata: &Metadata) -> Result<(), String> {
        let unwritable = |e: String| format!("{}.exr: cannot be written: {e}", stem.display());
        let bytes = exr::encode(&self.picture, metadata).map_err(|e| unwritable(e.to_string()))?;
        atomic::write(&with_ending(stem, ".exr"), &bytes).map_err(|e| unwritable(e.to_string()))?;
        let facts = serde_json::to_vec_pretty(&self.facts).map_err(|e| unwritable(e.to_string()))?;
        atomic::write(&with_ending(stem, ".json"), &facts).map_err(|e| unwritable(e.to_string()))
    }
}
