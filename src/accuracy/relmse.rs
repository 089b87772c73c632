use super::jackknife::{Each, LeaveOneOut};
use crate::lanes::LANES;

/// Keeps black pixels from weighing without bound.
pub(super) const EPSILON: f64 = 0.01;

/// The estimated relative square errors of sixteen pixels in linear light from two replicates alone, relative to the mean of all: cheaper
/// than [`square_error`].
#[inline(always)]
pub(super) fn square_difference(parts: &LeaveOneOut) -> Each {
    let [a, b] = &parts.without;
    let mut squares = [0.0; LANES];
    for c in 0..3 {
        for i in 0..LANES {
            let mean = parts.mean[c][i];
            squares[i] += (a[c][i] - b[c][i]) * (a[c][i] - b[c][i]) / (mean * mean + EPSILON) / 12.0;
        }
    }
    squares
}

/// The estimated relative square errors of sixteen pixels in linear light, mean of their channels.
///
/// Each replicate's deviation is measured by what the others show, not by a mean that it is part of: a firefly would
/// excuse itself.
#[inline(always)]
pub(super) fn square_error(parts: &LeaveOneOut) -> Each {
    let mut squares = [[0.0; LANES]; 2];
    for (square, without) in squares.iter_mut().zip(&parts.without) {
        for (channel, mean) in without[..3].iter().zip(&parts.mean) {
            for i in 0..LANES {
                let deviation = channel[i] - mean[i];
                square[i] += deviation * deviation / (channel[i] * channel[i] + EPSILON) / 3.0;
            }
        }
    }
    parts.sum(&squares)
}
