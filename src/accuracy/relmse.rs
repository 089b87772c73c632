use super::jackknife::LeaveOneOut;

/// Keeps black pixels from weighing without bound.
pub(super) const EPSILON: f64 = 0.01;

/// The same from two replicates alone, relative to the mean of all: cheaper.
pub(super) fn square_difference(parts: &LeaveOneOut) -> f64 {
    let [a, b] = parts.first_two();
    let channel = |c: usize| (a[c] - b[c]) * (a[c] - b[c]) / (parts.mean[c] * parts.mean[c] + EPSILON);
    (0..3).map(channel).sum::<f64>() / 12.0
}

/// The estimated relative square error of a pixel in linear light, mean of its channels.
///
/// Each replicate's deviation is measured by what the others show, not by a mean that it is part of: a firefly would
/// excuse itself.
pub(super) fn square_error(parts: &LeaveOneOut) -> f64 {
    parts.sum(|without| {
        let channel = |c: usize| {
            let deviation = without[c] - parts.mean[c];
            deviation * deviation / (without[c] * without[c] + EPSILON)
        };
        (0..3).map(channel).sum::<f64>() / 3.0
    })
}
