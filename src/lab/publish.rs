use super::plot::{LogLog, Series};
use super::run::{Studied, Study, Subject};
use super::strip::Strip;
use super::verdict::{digits, time};
use super::{Analysis, Curve, Point, Verdict, analyse, machine, report};
use crate::metrics::flip::just_noticeable;
use crate::write::{atomic, png};
use serde_json::json;
use std::fmt::Write;
use std::path::Path;

/// All that is published of an asset.
pub(super) struct Chapter<'a> {
    pub subject: &'a Subject,
    pub analysis: Analysis,
    pub verdict: Option<Verdict>,
    pub samples: Strip,
    pub ways: Strip,
    /// Name and plot.
    pub plots: [(&'static str, LogLog); 3],
}

/// Writes `report.html`, `study.json`, `cells.csv`, and the plots and strips of each asset into a folder. Gives the
/// verdicts, asset by asset.
///
/// # Errors
/// A sentence, when something cannot be written.
pub fn publish(study: &Study, studied: &Studied, folder: &Path) -> Result<Vec<(String, String)>, String> {
    let tests = study.ways.len() * studied.subjects.len();
    let chapters: Vec<Chapter> = studied.subjects.iter().map(|s| chapter(s, study, tests, folder)).collect();
    let put = |name: &str, bytes: &[u8]| {
        let path = folder.join(name);
        atomic::write(&path, bytes).map_err(|e| format!("{}: cannot be written: {e}", path.display()))
    };
    for chapter in &chapters {
        let stem = &chapter.subject.stem;
        for (name, plot) in &chapter.plots {
            put(&format!("plots/{stem}.{name}.svg"), plot.to_svg().as_bytes())?;
            let raster = plot.to_pixels();
            put(&format!("plots/{stem}.{name}.png"), &encoded(raster.width(), raster.pixels())?)?;
        }
        for (name, strip) in [("samples", &chapter.samples), ("ways", &chapter.ways)] {
            if let Some(raster) = strip.to_pixels() {
                put(&format!("strips/{stem}.{name}.png"), &encoded(raster.width(), raster.pixels())?)?;
            }
        }
    }
    put("cells.csv", csv(studied).as_bytes())?;
    let json = json!({
        "kiln": env!("CARGO_PKG_VERSION"),
        "machine": machine(),
        "interrupted": studied.interrupted,
        "ways": study.ways,
        "seeds": study.seeds,
        "budget": study.budget,
        "just_noticeable_flip": just_noticeable(),
        "assets": chapters.iter().map(asset_json).collect::<Vec<_>>(),
    });
    put("study.json", json.to_string().as_bytes())?;
    put("report.html", report::html(study, studied, &chapters)?.as_bytes())?;
    let text = |c: &Chapter| match (&c.verdict, &c.subject.outcome.error_message) {
        (Some(verdict), _) => verdict.text.clone(),
        (None, Some(message)) => format!("cannot be rendered: {message}"),
        (None, None) => "nothing was measured".into(),
    };
    Ok(chapters.iter().map(|c| (c.subject.name.clone(), text(c))).collect())
}

fn chapter<'a>(subject: &'a Subject, study: &Study, tests: usize, folder: &Path) -> Chapter<'a> {
    let analysis = analyse(subject, study.ways, tests);
    Chapter {
        subject,
        verdict: Verdict::of(&analysis),
        samples: Strip::of_samples(subject, &analysis, folder),
        ways: Strip::of_ways(subject, &analysis, folder),
        plots: plots(subject, &analysis),
        analysis,
    }
}

fn asset_json(chapter: &Chapter) -> serde_json::Value {
    let outcome = &chapter.subject.outcome;
    json!({
        "asset": chapter.subject.name,
        "content": outcome.content,
        "light": outcome.light,
        "scene": outcome.scene,
        "exposure": chapter.subject.exposure,
        "error_message": outcome.error_message,
        "reference": chapter.subject.reference.as_ref().map(|r| &r.facts),
        "analysis": chapter.analysis,
        "verdict": chapter.verdict,
        "cells": chapter.subject.cells,
    })
}

/// A picture as PNG.
pub(super) fn encoded(width: u32, pixels: &[[u8; 3]]) -> Result<Vec<u8>, String> {
    png::encode_rgb8(width, pixels).map_err(|e| format!("a picture cannot be encoded: {e}"))
}

fn plots(subject: &Subject, analysis: &Analysis) -> [(&'static str, LogLog); 3] {
    let plot = |what: &str, y: &str, of: &dyn Fn(&Point) -> f64, level: Option<(f64, String)>| LogLog {
        title: format!("{}: {what} against time", subject.name),
        x: "CPU seconds in all, from reading to writing".into(),
        y: y.into(),
        series: analysis.curves.iter().map(|c| series(c, of)).collect(),
        level,
    };
    let own = subject.reference.as_ref().map(|r| r.facts.error).filter(|e| *e > 0.0);
    [
        (
            "rmse",
            plot(
                "error",
                "RMS error as displayed, levels 0-255",
                &|p| p.error,
                own.map(|e| (e, "the reference's own error".into())),
            ),
        ),
        ("relmse", plot("relMSE", "relative mean square error, linear light", &|p| p.relmse, None)),
        (
            "flip",
            plot("FLIP", "FLIP, 95th percentile", &|p| p.flip_p95, Some((just_noticeable(), "just noticeable".into()))),
        ),
    ]
}

fn series(curve: &Curve, of: &dyn Fn(&Point) -> f64) -> Series {
    let title = |p: &Point| {
        let spp = if p.spp == 1 { "1 sample".into() } else { format!("{} samples", p.spp) };
        format!("{}, {spp}: {} in {}", curve.way, digits(of(p)), time(p.cpu_seconds.total))
    };
    Series {
        name: curve.way.clone(),
        points: curve.points.iter().map(|p| (p.cpu_seconds.total, of(p))).collect(),
        titles: curve.points.iter().map(title).collect(),
    }
}

/// One line a cell.
fn csv(studied: &Studied) -> String {
    let mut text = String::from(
        "asset,way,seed,spp,rmse,stated_error,stated_bound,relmse,flip,flip_p95,ssim,cpu_import,cpu_prepare,cpu_kdtree,cpu_render,cpu_total,\
         wall_import,wall_prepare,wall_kdtree,wall_render,wall_total,nonfinite\n",
    );
    for cell in studied.subjects.iter().flat_map(|s| &s.cells) {
        let (c, w) = (&cell.cpu_seconds, &cell.seconds);
        let number = |v: Option<f64>| v.map_or(String::new(), |v| v.to_string());
        let relmse = number(cell.relmse);
        // Writing to a string does not fail.
        let _ = writeln!(
            text,
            "{},{},{},{},{},{},{},{relmse},{},{},{},{},{},{},{},{},{},{},{},{},{},{}",
            quoted(&cell.asset),
            quoted(&cell.way),
            cell.seed,
            cell.spp,
            cell.rmse,
            number(cell.stated_error),
            number(cell.stated_bound),
            cell.flip,
            cell.flip_p95,
            cell.ssim,
            c.import,
            c.prepare,
            c.kdtree,
            c.render,
            c.total,
            w.import,
            w.prepare,
            w.kdtree,
            w.render,
            w.total,
            cell.nonfinite
        );
    }
    text
}

/// RFC 4180.
fn quoted(text: &str) -> String {
    if text.contains([',', '"', '\n', '\r']) { format!("\"{}\"", text.replace('"', "\"\"")) } else { text.into() }
}
