use super::jackknife::{Each, LeaveOneOut};
use crate::lanes::{Floats, LANES, Lanes, V3};
use crate::settings::PictureSettings;
use crate::write::display::Developer;

/// How a picture is displayed: the exposure and the tone curve at which errors are measured.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Display {
    developer: Developer,
}

impl Display {
    /// At an exposure in EV.
    pub fn new(settings: &PictureSettings, exposure_ev: f64) -> Self {
        Self { developer: Developer::new(exposure_ev, settings.tonemap, settings.background) }
    }

    /// The displayed levels, 0–255 before rounding, of a linear premultiplied RGBA pixel; a transparent one on black.
    pub fn levels(&self, pixel: [f32; 4]) -> [f64; 3] {
        let [r, g, b, alpha] = self.developer.develop(pixel).map(f64::from);
        [r, g, b].map(|c| 255.0 * c * alpha)
    }

    /// The same of sixteen pixels; where `opaque`, their fourth channel does not count.
    #[inline(always)]
    pub(super) fn levels_of<L: Lanes>(&self, lanes: L, pixels: &[Each; 4], opaque: bool) -> [Each; 3] {
        let [r, g, b, a] = pixels;
        let color = V3::new(narrow(lanes, r), narrow(lanes, g), narrow(lanes, b));
        let alpha = if opaque { lanes.splat(1.0) } else { narrow(lanes, a) };
        let (shown, alpha) = self.developer.develop_lanes(lanes, (color, alpha));
        let alpha = alpha.array();
        [levels(shown.x.array(), &alpha), levels(shown.y.array(), &alpha), levels(shown.z.array(), &alpha)]
    }
}

#[inline(always)]
fn narrow<L: Lanes>(lanes: L, numbers: &Each) -> L::F {
    let mut narrow = [0.0; LANES];
    for i in 0..LANES {
        narrow[i] = numbers[i] as f32;
    }
    lanes.load(&narrow)
}

#[inline(always)]
fn levels(shown: [f32; LANES], alpha: &[f32; LANES]) -> Each {
    let mut levels = [0.0; LANES];
    for i in 0..LANES {
        levels[i] = 255.0 * f64::from(shown[i]) * f64::from(alpha[i]);
    }
    levels
}

/// The estimated squares of the displayed errors of sixteen pixels from two replicates alone, by what they would show: cheaper than
/// [`square_error`], and without the curve's bias.
#[inline(always)]
pub(super) fn square_difference<L: Lanes>(lanes: L, parts: &LeaveOneOut, display: &Display, opaque: bool) -> Each {
    let a = display.levels_of(lanes, &parts.without[0], opaque);
    let b = display.levels_of(lanes, &parts.without[1], opaque);
    let mut squares = mean_square(&a, &b);
    squares.iter_mut().for_each(|square| *square *= 0.25);
    squares
}

/// The estimated squares of the displayed errors of sixteen pixels, mean of their channels; `whole` is what the pixels look like.
#[inline(always)]
pub(super) fn square_error<L: Lanes>(
    lanes: L,
    parts: &LeaveOneOut,
    display: &Display,
    opaque: bool,
    whole: &[Each; 3],
) -> Each {
    let first = mean_square(&display.levels_of(lanes, &parts.without[0], opaque), whole);
    let second = mean_square(&display.levels_of(lanes, &parts.without[1], opaque), whole);
    parts.sum_beyond_fireflies(&[first, second])
}

/// The mean square over the channels of a difference.
#[inline(always)]
fn mean_square(a: &[Each; 3], b: &[Each; 3]) -> Each {
    let mut mean = [0.0; LANES];
    for c in 0..3 {
        for i in 0..LANES {
            mean[i] += (a[c][i] - b[c][i]) * (a[c][i] - b[c][i]) / 3.0;
        }
    }
    mean
}
