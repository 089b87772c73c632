use super::jackknife::LeaveOneOut;
use super::pixels::seen;
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
}

/// The same from two replicates alone, by what they would show: cheaper, and without the curve's bias.
pub(super) fn square_difference(parts: &LeaveOneOut, display: &Display, opaque: bool) -> f64 {
    let [a, b] = parts.first_two().map(|pixel| display.levels(seen(pixel, opaque)));
    (0..3).map(|c| (a[c] - b[c]) * (a[c] - b[c])).sum::<f64>() / 12.0
}

/// The estimated square of a pixel's displayed error, mean of its channels; `whole` is what the pixel looks like.
pub(super) fn square_error(parts: &LeaveOneOut, display: &Display, opaque: bool, whole: [f64; 3]) -> f64 {
    parts.sum_beyond_fireflies(|without| {
        let shown = display.levels(seen(*without, opaque));
        (0..3).map(|c| (shown[c] - whole[c]) * (shown[c] - whole[c])).sum::<f64>() / 3.0
    })
}
