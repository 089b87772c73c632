use super::plot::{Anchor, Canvas, Ink, Raster};
use super::run::{Subject, picture_path};
use super::verdict::{digits, time};
use super::{Analysis, Cell};
use crate::metrics::Shown;
use kiln_formats::images;
use kiln_formats::scene::Pixels;
use std::path::Path;

/// Pictures side by side, each with what it cost and how far it is from the reference.
#[derive(Clone, Debug)]
pub(super) struct Strip {
    pub frames: Vec<Frame>,
}

/// One of them.
#[derive(Clone, Debug)]
pub(super) struct Frame {
    /// Lines below it: what, price, error.
    pub caption: [String; 3],
    pub width: u32,
    /// 8-bit sRGB over white.
    pub pixels: Vec<[u8; 3]>,
}

impl Strip {
    /// What 1, 4, 16, … samples of the first way look like, and the reference.
    pub fn of_samples(subject: &Subject, analysis: &Analysis, folder: &Path) -> Self {
        let Some(curve) = analysis.curves.first() else { return Self { frames: Vec::new() } };
        let most = curve.points.last().map_or(0, |p| p.spp);
        let wanted = |spp: u32| spp == most || spp.is_power_of_two() && spp.trailing_zeros().is_multiple_of(2);
        let cells = first_seed(subject, &curve.way).filter(|c| wanted(c.spp));
        let plural = |spp: u32| if spp == 1 { "1 sample".into() } else { format!("{spp} samples") };
        let mut frames: Vec<Frame> = cells.filter_map(|c| frame(subject, c, folder, plural(c.spp))).collect();
        frames.extend(reference(subject));
        Self { frames }
    }

    /// What each way gives in the same time, and the reference.
    pub fn of_ways(subject: &Subject, analysis: &Analysis, folder: &Path) -> Self {
        let longest = |way: &str| first_seed(subject, way).map(|c| c.cpu_seconds.render).fold(0.0, f64::max);
        let ways = || analysis.curves.iter().filter(|c| !c.preset);
        let common = ways().map(|c| longest(&c.way)).fold(f64::INFINITY, f64::min);
        let distance = |c: &Cell| libm::log(c.cpu_seconds.render.max(1e-9) / common).abs();
        let nearest = |way: &str| first_seed(subject, way).min_by(|a, b| distance(a).total_cmp(&distance(b)));
        let frames = ways().filter_map(|curve| {
            let cell = nearest(&curve.way)?;
            frame(subject, cell, folder, format!("{}, {}", curve.way, cell.spp))
        });
        let mut frames: Vec<Frame> = frames.collect();
        frames.extend(reference(subject));
        Self { frames }
    }

    /// All in one picture with their captions, or nothing when there are none.
    pub fn to_pixels(&self) -> Option<Raster> {
        /// Columns and rows between pictures, and below them for the captions.
        const GAP: u32 = 12;
        const CAPTION: u32 = 62;
        /// The narrowest that captions fit below.
        const NARROWEST: u32 = 136;
        let first = self.frames.first()?;
        let (width, height) = (first.width, first.pixels.len() as u32 / first.width.max(1));
        let step = width.max(NARROWEST) + GAP;
        let mut raster = Raster::new(GAP + step * self.frames.len() as u32, GAP + height + CAPTION);
        for (number, frame) in self.frames.iter().enumerate() {
            let left = GAP + step * number as u32;
            raster.picture((left, GAP), frame.width, &frame.pixels);
            for (row, line) in frame.caption.iter().enumerate() {
                let at = (f64::from(left), f64::from(GAP + height) + 18.0 * (row as f64 + 1.0));
                raster.text(at, line, Anchor::Start, Ink::Text, false);
            }
        }
        Some(raster)
    }
}

fn first_seed<'a>(subject: &'a Subject, way: &str) -> impl Iterator<Item = &'a Cell> {
    let way = way.to_string();
    let first = subject.cells.iter().filter(|c| c.way == way).map(|c| c.seed).min();
    subject.cells.iter().filter(move |c| c.way == way && Some(c.seed) == first)
}

fn frame(subject: &Subject, cell: &Cell, folder: &Path, name: String) -> Option<Frame> {
    let bytes = std::fs::read(picture_path(folder, &subject.stem, &cell.way, cell.spp)).ok()?;
    let image = images::decode(&bytes, &name, 1 << 30).ok()?;
    let over_white = |[r, g, b, a]: [u8; 4]| {
        let alpha = u32::from(a);
        [r, g, b].map(|c| ((u32::from(c) * alpha + 255 * (255 - alpha) + 127) / 255) as u8)
    };
    let Pixels::Rgba8(values) = image.pixels else { return None };
    let pixels = values.chunks_exact(4).map(|p| over_white([p[0], p[1], p[2], p[3]])).collect();
    let caption = [name, time(cell.cpu_seconds.total), format!("{} levels", digits(cell.rmse))];
    Some(Frame { caption, width: image.width, pixels })
}

fn reference(subject: &Subject) -> Option<Frame> {
    let reference = subject.reference.as_ref()?;
    let Shown { width, displayed, alpha, .. } = &reference.shown;
    let byte = |v: f32| (v.max(0.0).min(1.0) * 255.0 + 0.5) as u8;
    // What is shown lies on black.
    let pixels = displayed.iter().zip(alpha).map(|(p, a)| p.map(|c| byte(c + 1.0 - a))).collect();
    let facts = &reference.facts;
    let caption = [
        format!("reference, {}", facts.spp),
        time(facts.cpu_seconds),
        format!("± {} levels", digits(facts.error)).replace('±', "+-"),
    ];
    Some(Frame { caption, width: *width, pixels })
}
