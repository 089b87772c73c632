use super::point::{seconds_at, slope};
use super::run::Subject;
use super::{Bias, Cell, Point, Way};
use crate::film::Estimate;
use crate::math::statistics::sidak;
use serde::Serialize;

/// What the cells of an asset say together.
#[derive(Clone, Debug, Serialize)]
pub struct Analysis {
    /// The asset.
    pub asset: String,
    /// One for each way, in the study's order.
    pub curves: Vec<Curve>,
    /// Which (curve, point) are efficient: no other picture was better in less time. Growing times.
    pub frontier: Vec<(usize, usize)>,
}

/// Error against time of one way.
#[derive(Clone, Debug, Serialize)]
pub struct Curve {
    /// The way's name.
    pub way: String,
    /// The way in words.
    pub title: String,
    /// Whether it is one picture for a goal instead of growing samples.
    pub preset: bool,
    /// Growing samples.
    pub points: Vec<Point>,
    /// Bias at the most samples that all seeds have.
    pub bias: Option<Bias>,
    /// Whether the way leaves something out, and the bias is significant (all ways of all assets together at 1 %).
    pub biased: bool,
    /// Whether the bias is significant though the way leaves nothing out: it finds some of the light so rarely that its
    /// spread does not tell of it yet.
    pub unsettled: bool,
    /// d log error / d log CPU seconds of rendering: −0.5 for independent samples.
    pub slope: Option<f64>,
    /// How it compares with the first way; `None` for the first one, and where there is too little to compare.
    pub versus: Option<Versus>,
}

/// The time that a way takes against the first one.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Versus {
    /// The error at which they are compared, levels: the least that both reach.
    pub error: f64,
    /// CPU seconds in all of the way.
    pub seconds: f64,
    /// The same of the first way.
    pub first_seconds: f64,
    /// Whether the first way is already better with its fewest samples, so that it would take even less.
    pub at_least: bool,
}

impl Versus {
    /// How many times as long as the first way.
    pub fn ratio(&self) -> f64 {
        self.seconds / self.first_seconds
    }

    fn of(points: &[Point], first: &[Point]) -> Option<Self> {
        let least =
            |points: &[Point]| points.iter().filter(|p| !p.limited).map(|p| p.error).fold(f64::INFINITY, f64::min);
        let error = least(points).max(least(first));
        let at_least = first.first().is_some_and(|p| p.error < error);
        let (seconds, first_seconds) = (seconds_at(points, error)?, seconds_at(first, error)?);
        Some(Self { error, seconds, first_seconds, at_least })
    }
}

/// Significance at which ways count as biased, over a whole study.
const SIGNIFICANCE: f64 = 0.01;

/// Makes curves of an asset's cells. `tests` is the number of curves of the whole study.
pub fn analyse(subject: &Subject, ways: &[Way], tests: usize) -> Analysis {
    let own = subject.reference.as_ref().map_or(0.0, |r| r.facts.error);
    let mut curves: Vec<Curve> = ways
        .iter()
        .filter_map(|way| {
            let cells: Vec<&Cell> = subject.cells.iter().filter(|c| c.way == way.name).collect();
            (!cells.is_empty()).then(|| curve(way, &cells, subject, own, tests))
        })
        .collect();
    if let Some((first, others)) = curves.split_first_mut() {
        // A preset is the first way, stopped somewhere.
        others
            .iter_mut()
            .filter(|curve| !curve.preset)
            .for_each(|curve| curve.versus = Versus::of(&curve.points, &first.points));
    }
    Analysis { asset: subject.name.clone(), frontier: frontier(&curves), curves }
}

fn curve(way: &Way, cells: &[&Cell], subject: &Subject, own: f64, tests: usize) -> Curve {
    let mut cells = cells.to_vec();
    cells.sort_by_key(|c| c.spp);
    // Seeds that stop at different numbers of samples are pictures of the same preset.
    let groups: Vec<&[&Cell]> = cells.chunk_by(|a, b| way.preset.is_some() || a.spp == b.spp).collect();
    let points = groups.iter().map(|group| Point::of(group, own)).collect::<Vec<_>>();
    // The most samples that all seeds have been rendered with.
    let count = groups.iter().map(|g| g.len()).max();
    let most = groups.iter().rfind(|g| Some(g.len()) == count).copied().unwrap_or_default();
    let pictures: Vec<Estimate> = most.iter().filter(|c| c.spp > 1).map(|c| c.luminance).collect();
    let bias = subject.reference.as_ref().and_then(|r| Bias::of(&pictures, &r.facts.luminance));
    let significant = bias.is_some_and(|b| b.is_significant(sidak(SIGNIFICANCE, tests)));
    Curve {
        way: way.name.clone(),
        title: way.title.clone(),
        preset: way.preset.is_some(),
        slope: slope(&points),
        biased: significant && (way.max_depth.is_some() || way.denoise.is_some()),
        unsettled: significant && way.max_depth.is_none(),
        bias,
        points,
        versus: None,
    }
}

fn frontier(curves: &[Curve]) -> Vec<(usize, usize)> {
    let mut all: Vec<(usize, usize)> =
        curves.iter().enumerate().flat_map(|(c, curve)| (0..curve.points.len()).map(move |p| (c, p))).collect();
    let point = |(c, p): (usize, usize)| &curves[c].points[p];
    all.sort_by(|a, b| point(*a).cpu_seconds.total.total_cmp(&point(*b).cpu_seconds.total));
    let mut best = f64::INFINITY;
    all.retain(|at| {
        let better = point(*at).error < best;
        best = best.min(point(*at).error);
        better
    });
    all
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use crate::batch::StageSeconds;

    pub(in crate::lab) fn cell(way: &str, spp: u32, seconds: f64, rmse: f64) -> Cell {
        let stages = StageSeconds { render: seconds, total: seconds + 0.5, ..StageSeconds::default() };
        Cell {
            run: String::new(),
            asset: "a".into(),
            way: way.into(),
            seed: 0,
            spp,
            seconds: stages,
            cpu_seconds: stages,
            rmse,
            relmse: Some(rmse * rmse),
            flip: 0.01 * rmse,
            flip_p95: 0.02 * rmse,
            ssim: 1.0,
            stated_error: None,
            stated_bound: None,
            luminance: Estimate { mean: 1.0, variance: 0.0, degrees: 1.0 },
            nonfinite: 0,
        }
    }

    #[test]
    fn curves_have_slopes_a_frontier_and_times_at_one_error() {
        // Errors of `good` fall with the root of the time, those of `bad` are twice as large at twice the time.
        let good = [1u32, 4, 16, 64].map(|n| cell("good", n, f64::from(n), 32.0 / f64::from(n).sqrt()));
        let bad = [1u32, 4, 16, 64].map(|n| cell("bad", n, 2.0 * f64::from(n), 64.0 / f64::from(n).sqrt()));
        let subject = Subject {
            name: "a".into(),
            stem: "a".into(),
            outcome: crate::batch::Outcome::skipped("a", 0),
            exposure: 0.0,
            reference: None,
            cells: good.into_iter().chain(bad).collect(),
        };
        let way = |name: &str| Way { name: name.into(), ..Way::default() };
        let analysis = analyse(&subject, &[way("good"), way("bad"), way("not rendered")], 2);
        assert_eq!(analysis.curves.len(), 2);
        for curve in &analysis.curves {
            assert!((curve.slope.expect("enough points") + 0.5).abs() < 1e-9);
        }
        assert_eq!(analysis.curves[0].versus, None);
        let versus = analysis.curves[1].versus.expect("something to compare");
        assert!(versus.error == 8.0 && !versus.at_least, "{versus:?}");
        assert!((versus.ratio() - 128.5 / 16.5).abs() < 1e-9, "{versus:?}");
        // Nothing that the worse way gives was not to be had sooner.
        assert_eq!(analysis.frontier, [(0, 0), (0, 1), (0, 2), (0, 3)]);
    }
}
