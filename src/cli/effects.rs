//! The effects of an asset, for people, and what it saves to know them.

use super::exit::Fatal;
use kiln::Control;
use kiln::batch::{Job, Output, Ready, make_ready};
use kiln::effects::AttributeBytes;
use kiln::formats::Limits;
use kiln::integrate::render;
use kiln::prepare::{Asked, PreparedScene, Unmet};
use kiln::settings::{EffectSet, EffectSettings, PrepareSettings, RenderSettings, Settings, ViewSettings};
use serde::Serialize;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// Side of the pictures that are measured, pixels.
const SIDE: u32 = 128;
/// Samples a pixel of them.
const SPP: u32 = 8;
/// How often each way renders, in turn.
const ROUNDS: usize = 5;

/// What rendering takes when the effects are known, and when every effect has to be reckoned with at every hit.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Measured {
    /// CPU seconds of a picture, knowing the effects; the least of several.
    pub pruned_cpu_seconds: f64,
    /// CPU seconds with all effects.
    pub full_cpu_seconds: f64,
    /// Whether both gave the same film, bit for bit.
    pub same_bits: bool,
}

/// Renders an asset both ways, in turn.
///
/// # Errors
/// When the asset cannot be rendered.
pub fn measure(asset: &Path, root: Option<&PathBuf>, prepare: &PrepareSettings) -> Result<Measured, Fatal> {
    let control = Control::default();
    let ready = |forced| -> Result<Ready, Fatal> {
        let mut settings = Settings::default();
        settings.views = ViewSettings { width: SIDE, height: SIDE, ..settings.views };
        settings.prepare = PrepareSettings { effects: EffectSettings { forced, ..prepare.effects }, ..*prepare };
        let job = Job {
            input: asset.to_path_buf(),
            name: asset.display().to_string(),
            root: root.cloned(),
            limits: Limits::default(),
            output: Output { folder: PathBuf::new(), stem: PathBuf::new(), ending: None },
            settings,
        };
        make_ready(&job, &control, None).map_err(|outcome| Fatal::failed(outcome.error_message.unwrap_or_default()))
    };
    let both = [ready(EffectSet::default())?, ready(EffectSet::all())?];
    let settings = RenderSettings { spp: SPP, ..RenderSettings::default() };
    let (mut seconds, mut films) = ([f64::INFINITY; 2], [None, None]);
    for _ in 0..ROUNDS {
        for (k, ready) in both.iter().enumerate() {
            let view = ready.views.first().ok_or_else(|| Fatal::failed("the asset has no view"))?;
            let rendered = render(&ready.scene, view, &settings, &control).map_err(|_| Fatal::failed("stopped"))?;
            seconds[k] = seconds[k].min(rendered.cpu_seconds);
            films[k] = Some(rendered.film);
        }
    }
    let same_bits = films[0] == films[1];
    Ok(Measured { pruned_cpu_seconds: seconds[0], full_cpu_seconds: seconds[1], same_bits })
}

/// What was measured, in a line.
pub fn measured(m: &Measured) -> String {
    format!(
        "saves      {:.2}× the CPU of rendering: {:.3} s, and {:.3} s with every effect at every hit ({SIDE}×{SIDE}, {SPP} samples; {})",
        m.full_cpu_seconds / m.pruned_cpu_seconds,
        m.pruned_cpu_seconds,
        m.full_cpu_seconds,
        if m.same_bits { "the same bits" } else { "NOT the same bits" }
    )
}

/// What the scene calls for and why, what is left away, and what its vertices hold.
pub fn lines(prepared: &PreparedScene) -> Vec<String> {
    let called = prepared.effects();
    let heads = std::iter::once("effects    ").chain(std::iter::repeat("           "));
    let mut lines: Vec<_> =
        heads.zip(&called).map(|(head, c)| format!("{head}{:<21}{}", c.effect.name(), c.reason)).collect();
    if called.is_empty() {
        lines.push("effects    none: a black picture".into());
    }
    let mut counts: BTreeMap<&str, Vec<&str>> = BTreeMap::new();
    prepared.rewrites.iter().for_each(|r| counts.entry(r.what).or_default().push(&r.place));
    let heads = std::iter::once("left away  ").chain(std::iter::repeat("           "));
    lines.extend(heads.zip(counts).map(|(head, (what, places))| {
        let rest = if places.len() > 1 { format!(" and {} more", places.len() - 1) } else { String::new() };
        format!("{head}{what} ({}{rest})", places[0])
    }));
    lines.extend(regions(&prepared.asked()));
    let tree = prepared.kdtree_statistics();
    lines.extend(never_met(&prepared.unmet(), tree.bytes as f64 / tree.triangles.max(1) as f64));
    let AttributeBytes { held, full, images, .. } = prepared.attribute_bytes();
    let triangles = prepared.triangles.max(1) as f64;
    lines.push(format!(
        "attributes {:.1} bytes a triangle of {:.1} if every vertex had all of them; images {:.1} MB",
        held as f64 / triangles,
        full as f64 / triangles,
        images as f64 / 1e6
    ));
    lines
}

/// Which part of the triangles lets rays pass, and when that is asked.
fn regions(asked: &Asked) -> Option<String> {
    let share = |count: u64| format!("{count} of {} triangles", asked.triangles);
    let of = [(asked.coverage, "rays pass by coverage"), (asked.culling, "camera rays pass from behind")];
    let of: Vec<_> =
        of.iter().filter(|(n, _)| *n > 0).map(|(n, what)| format!("{} may let {what}", share(*n))).collect();
    let when = match asked.on_the_way {
        true => "asked at every hit on the way",
        false => "asked at nearest hits alone, elsewhere where many pass",
    };
    (!of.is_empty()).then(|| format!("questions  {}; {when}", of.join(", ")))
}

/// Triangles that no ray stops at, and what a tree with so many bytes a triangle is spared.
fn never_met(unmet: &Unmet, tree_bytes: f64) -> Option<String> {
    let Unmet { without_area, open, behind_twin, behind_turned_twin } = *unmet;
    let spared = |count: u64| format!("spare the kd-tree about {:.1} kB", count as f64 * tree_bytes / 1e3);
    let of = [
        (without_area, format!("without area are left out and {}", spared(without_area))),
        (open, format!("open all over {}", spared(open))),
        (behind_twin, "are behind others with the same corners".into()),
        (behind_turned_twin, "are behind others with the same corners in another order".into()),
    ];
    let of: Vec<_> = of.iter().filter(|(n, _)| *n > 0).map(|(n, what)| format!("{n} {what}")).collect();
    (!of.is_empty()).then(|| format!("never met  triangles: {}", of.join(", ")))
}
