use super::Reference;
use crate::batch::StageSeconds;
use crate::film::{Estimate, Film, Picture};
use crate::math::LUMINANCE;
use crate::metrics::{Comparison, Show, Shown, compare};
use serde::{Deserialize, Serialize};

/// One picture of a study: what it cost, and how far it is from the reference.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Cell {
    /// Names the run that it belongs to: asset, settings, seed and reference.
    pub run: String,
    /// The asset.
    pub asset: String,
    /// The way's name.
    pub way: String,
    /// Selects the random numbers.
    pub seed: u64,
    /// Camera paths per pixel.
    pub spp: u32,
    /// Wall seconds.
    pub seconds: StageSeconds,
    /// CPU seconds of all threads.
    pub cpu_seconds: StageSeconds,
    /// Root mean square difference from the reference as displayed, levels 0–255. The reference's own noise is in it.
    pub rmse: f64,
    /// Relative mean square error in linear light; `None` when a pixel is not finite.
    pub relmse: Option<f64>,
    /// Mean ꟻLIP.
    pub flip: f64,
    /// The value that ꟻLIP stays below in 95 % of the covered pixels.
    pub flip_p95: f64,
    /// Structural similarity.
    pub ssim: f64,
    /// The error that the picture states of itself; `None` with one sample per pixel.
    pub stated_error: Option<f64>,
    /// Its upper 95 % bound.
    pub stated_bound: Option<f64>,
    /// Mean luminance.
    pub luminance: Estimate,
    /// Samples dropped because they were not finite.
    pub nonfinite: u64,
}

/// What is measured of a picture.
pub(super) struct Measured {
    pub comparison: Comparison,
    pub luminance: Estimate,
}

pub(super) fn measure(film: &Film, picture: &Picture, reference: &Reference, show: &Show) -> Result<Measured, String> {
    let (comparison, _) = compare(&Shown::of(picture, show), &reference.shown)?;
    // A picture that is not what the film holds (a denoiser was at it) is brighter or darker, with the same noise at the least.
    let (luminance, held) = (luminance_of(film), film.picture());
    let mean = luminance.mean + mean_luminance(picture) - mean_luminance(&held);
    Ok(Measured { comparison, luminance: Estimate { mean, ..luminance } })
}

fn mean_luminance(picture: &Picture) -> f64 {
    let of = |pixel: &[f32; 4]| (0..3).map(|c| LUMINANCE[c] * f64::from(pixel[c])).sum::<f64>();
    picture.pixels.iter().map(of).sum::<f64>() / picture.pixels.len().max(1) as f64
}

/// Mean luminance.
pub(super) fn luminance_of(film: &Film) -> Estimate {
    film.estimate(0..film.pixels.len(), LUMINANCE)
}
