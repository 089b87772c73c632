use super::Cell;
use crate::batch::StageSeconds;
use serde::Serialize;

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

impl Point {
    /// Of the cells of one way with one number of samples; `own`: the reference's own error, levels.
    pub(super) fn of(cells: &[&Cell], own: f64) -> Self {
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
        Self {
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
}

/// Slope of log error against log CPU seconds of rendering by least squares, from 4 samples per pixel on.
pub(super) fn slope(points: &[Point]) -> Option<f64> {
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
pub(super) fn seconds_at(points: &[Point], error: f64) -> Option<f64> {
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lab::analysis::tests::cell;

    #[test]
    fn the_references_own_error_is_taken_off() {
        let cells = [cell("w", 4, 1.0, 5.0)];
        let p = Point::of(&cells.iter().collect::<Vec<_>>(), 3.0);
        assert!((p.error - 4.0).abs() < 1e-12 && !p.limited);
        assert!(Point::of(&cells.iter().collect::<Vec<_>>(), 4.0).limited);
    }
}
