use super::before::Before;
use super::record::{Record, Seconds};
use super::views::{Views, rounded};
use serde::Serialize;
use std::collections::HashMap;

/// What the page holds of an asset; what is not there is not known.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub(super) struct Entry {
    pub input: String,
    /// The manifest's, or `gone`: only the earlier run has it.
    pub status: String,
    /// Code and message.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub error: Option<(String, String)>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub light: Option<String>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub views: Option<Views>,
    /// Code (a word's number), place, message (a word's number).
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub warnings: Vec<(usize, String, usize)>,
    /// Triangles, instances, emitters.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub scene: Option<[u64; 3]>,
    /// Words' numbers.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub effects: Vec<usize>,
    /// Import, prepare, kd-tree, render, write, in all.
    pub wall: [f64; 6],
    /// The same of CPU time.
    pub cpu: [f64; 6],
    /// Camera, bounce, shadow.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub rays: Option<[u64; 3]>,
    #[serde(skip_serializing_if = "is_zero")]
    pub nonfinite: u64,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub peak: Option<u64>,
    #[serde(skip_serializing_if = "is_zero")]
    pub seed: u64,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub content: Option<String>,
    /// The earlier run's.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub before: Option<Before>,
}

fn is_zero(value: &u64) -> bool {
    *value == 0
}

impl Entry {
    pub fn of(record: &Record, words: &mut Words) -> Self {
        let seconds = |s: &Seconds| [s.import, s.prepare, s.kdtree, s.render, s.write, s.total].map(rounded);
        let code = record.error_code.clone().unwrap_or_default();
        Self {
            input: record.input.clone(),
            status: record.status.clone(),
            error: record.error_message.clone().map(|message| (code, message)),
            light: record.light.clone(),
            views: Views::of(record),
            warnings: record
                .warnings
                .iter()
                .map(|w| (words.number(&w.code), w.place.clone(), words.number(&w.message)))
                .collect(),
            scene: record.scene.as_ref().map(|s| [s.triangles, s.instances, s.emitters]),
            effects: record.scene.iter().flat_map(|s| &s.effects).map(|e| words.number(e)).collect(),
            wall: seconds(&record.seconds),
            cpu: seconds(&record.cpu_seconds),
            rays: record.rays.map(|r| [r.camera, r.bounce, r.shadow]).filter(|r| r.iter().any(|n| *n > 0)),
            nonfinite: record.nonfinite,
            peak: record.peak_bytes,
            seed: record.seed,
            content: record.content.clone(),
            before: None,
        }
    }
}

/// Texts that come again and again, each once.
#[derive(Clone, Debug, Default)]
pub(super) struct Words {
    list: Vec<String>,
    numbers: HashMap<String, usize>,
}

impl Words {
    pub fn number(&mut self, word: &str) -> usize {
        if let Some(&number) = self.numbers.get(word) {
            return number;
        }
        self.numbers.insert(word.into(), self.list.len());
        self.list.push(word.into());
        self.list.len() - 1
    }
}

impl Serialize for Words {
    fn serialize<S: serde::Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        self.list.serialize(serializer)
    }
}
