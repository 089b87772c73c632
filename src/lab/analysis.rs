use super::run::Subject;
use super::{Bias, Cell, Way};
use crate::batch::StageSeconds;
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

/// The mean of the pictures of one way with one number of samples.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Point {
    /// Camera paths per pixel.
    pub spp: u32,
    /// Pictures.
    pub pictures: u32,
    /// Mean CPU seconds by stage.
    pub cpu_seconds: StageSeconds,
    /// Mean wall seconds by stage.
    pub seconds: StageSeconds,
    /// RMS error as displayed, levels, the reference's own error taken off.
    pub error: f64,
    /// The smallest and the largest of the pictures, as measured.
    pub range: [f64; 2],
    /// Whether the reference's own error is more than half of what was measured.
    pub limited: bool,
    /// Mean relMSE as measured, of those that are finite.
    pub relmse: f64,
    /// Mean ꟻLIP.
    pub flip: f64,
    /// Mean of the 95th percentiles of ꟻLIP.
    pub flip_p95: f64,
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
        others.iter_mut().for_each(|curve| curve.versus = Versus::of(&curve.points, &first.points));
    }
    Analysis { asset: subject.name.clone(), frontier: frontier(&curves), curves }
}

fn curve(way: &Way, cells: &[&Cell], subject: &Subject, own: f64, tests: usize) -> Curve {
    let mut spps: Vec<u32> = cells.iter().map(|c| c.spp).collect();
    spps.sort_unstable();
    spps.dedup();
    let of = |spp: u32| cells.iter().copied().filter(move |c| c.spp == spp);
    let points: Vec<Point> = spps.iter().map(|spp| point(&of(*spp).collect::<Vec<_>>(), own)).collect();
    // The most samples that all seeds have been rendered with.
    let count = points.iter().map(|p| p.pictures).max();
    let most = points.iter().rfind(|p| Some(p.pictures) == count).map_or(0, |p| p.spp);
    let pictures: Vec<f64> = of(most).flat_map(|c| c.luminance.iter().copied()).collect();
    let reference = subject.reference.as_ref().map_or(&[][..], |r| &r.facts.luminance);
    let bias = Bias::of(&pictures, reference);
    let significant = bias.is_some_and(|b| b.is_significant(sidak(SIGNIFICANCE, tests)));
    Curve {
        way: way.name.clone(),
        title: way.title.clone(),
        slope: slope(&points),
        biased: significant && way.max_depth.is_some(),
        unsettled: significant && way.max_depth.is_none(),
        bias,
        points,
        versus: None,
    }
}

fn point(cells: &[&Cell], own: f64) -> Point {
    let n = cells.len().max(1) as f64;
    let mean = |of: &dyn Fn(&Cell) -> f64| cells.iter().map(|c| of(c)).sum::<f64>() / n;
    let stages = |of: &dyn Fn(&Cell) -> StageSeconds| StageSeconds {
        import: mean(&|c| of(c).import),
        prepare: mean(&|c| of(c).prepare),
        kdtree: mean(&|c| of(c).kdtree),
        render: mean(&|c| of(c).render),
        write: mean(&|c| of(c).write),
        total: mean(&|c| of(c).total),
    };
    let square = mean(&|c| c.rmse * c.rmse);
    let finite: Vec<f64> = cells.iter().filter_map(|c| c.relmse).collect();
    let rmse = || cells.iter().map(|c| c.rmse);
    Point {
        spp: cells.first().map_or(0, |c| c.spp),
        pictures: cells.len() as u32,
        cpu_seconds: stages(&|c| c.cpu_seconds),
        seconds: stages(&|c| c.seconds),
        error: (square - own * own).max(0.0).sqrt(),
        range: [rmse().fold(f64::INFINITY, f64::min), rmse().fold(0.0, f64::max)],
        limited: 2.0 * own * own > square,
        relmse: finite.iter().sum::<f64>() / finite.len().max(1) as f64,
        flip: mean(&|c| c.flip),
        flip_p95: mean(&|c| c.flip_p95),
    }
}

/// Slope of log error against log CPU seconds of rendering by least squares, from 4 samples per pixel on.
fn slope(points: &[Point]) -> Option<f64> {
    let logs: Vec<(f64, f64)> = points
        .iter()
        .filter(|p| p.spp >= 4 && !p.limited && p.error > 0.0 && p.cpu_seconds.render > 0.0)
        .map(|p| (libm::log(p.cpu_seconds.render), libm::log(p.error)))
        .collect();
    if logs.len() < 3 {
        return None;
    }
    let n = logs.len() as f64;
    let mean = |of: fn(&(f64, f64)) -> f64| logs.iter().map(of).sum::<f64>() / n;
    let (x, y) = (mean(|l| l.0), mean(|l| l.1));
    let cross: f64 = logs.iter().map(|l| (l.0 - x) * (l.1 - y)).sum();
    let square: f64 = logs.iter().map(|l| (l.0 - x) * (l.0 - x)).sum();
    (square > 0.0).then(|| cross / square)
}

/// CPU seconds in all at which a curve comes down to an error, between its points on a log-log line.
fn seconds_at(points: &[Point], error: f64) -> Option<f64> {
    interpolate(points, error, |p| p.error, |p| p.cpu_seconds.total)
}

/// Where `falling` first comes down to `level`, the value of `wanted` there.
pub(super) fn interpolate(
    points: &[Point],
    level: f64,
    falling: impl Fn(&Point) -> f64,
    wanted: impl Fn(&Point) -> f64,
) -> Option<f64> {
    let at = points.iter().position(|p| falling(p) <= level)?;
    let (high, low) = (points.get(at.wrapping_sub(1)), &points[at]);
    let Some(high) = high else { return Some(wanted(low)) };
    let (h, l) = (falling(high), falling(low));
    // From the upper point to the lower one, in logarithms.
    let share = if l > 0.0 && h > l { libm::log(h / level) / libm::log(h / l) } else { 1.0 };
    Some(wanted(high) * libm::pow(wanted(low) / wanted(high), share))
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
mod tests {
    use super::*;

    fn cell(way: &str, spp: u32, seconds: f64, rmse: f64) -> Cell {
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
            luminance: vec![],
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

    #[test]
    fn the_references_own_error_is_taken_off() {
        let cells = [cell("w", 4, 1.0, 5.0)];
        let p = point(&cells.iter().collect::<Vec<_>>(), 3.0);
        assert!((p.error - 4.0).abs() < 1e-12 && !p.limited);
        assert!(point(&cells.iter().collect::<Vec<_>>(), 4.0).limited);
    }
}
