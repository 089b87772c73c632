//! How far a picture is from the converged one, as the picture's own samples tell it, and rendering until it is near enough.
//!
//! The **error** of a picture is the RMS difference of what is displayed (tone-mapped, sRGB, 0–255 levels, before rounding,
//! at a fixed exposure) from the converged picture, over red, green and blue of the pixels that the asset covers. Where the
//! background is transparent the picture counts as it looks on black, so that an edge pixel weighs as much as its alpha.
//!
//! It is estimated from the film's replicates, which are independent however well each is distributed in itself: the
//! tone curve is applied to the picture without one replicate after the other ([`displayed`]), which accounts for curve
//! and clipping at the noise that the picture really has. [`Spread`] says how far such an estimate can be off.

mod bound;
mod displayed;
mod jackknife;
mod progressive;
mod relmse;
mod schedule;

pub use bound::Spread;
pub use displayed::Display;
pub use progressive::{Ended, Finished, Progressive};
pub use schedule::Schedule;

use crate::film::Film;
use serde::{Deserialize, Serialize};

/// The confidence of stated bounds.
pub const CONFIDENCE: f64 = 0.95;

/// A picture's error, estimated from its own samples.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Accuracy {
    /// RMS error as displayed, 0–255 levels.
    pub error: f64,
    /// Upper bound of it, with the confidence that was asked for.
    pub error_bound: f64,
    /// Mean over covered pixels and channels of (x − μ)² / (μ² + 0.01) in linear light, premultiplied.
    pub relmse: f64,
    /// Upper bound of it.
    pub relmse_bound: f64,
}

impl Accuracy {
    /// Of the picture that a film holds, with bounds that hold with probability `confidence` (0 to 1).
    ///
    /// `None` when there are not two replicates to compare: with one sample per pixel nothing can be said. A film that shows
    /// nothing of the asset has no error.
    pub fn of(film: &Film, display: &Display, confidence: f64) -> Option<Self> {
        if film.spp < 2 {
            return None;
        }
        let [displayed, relative] = jackknife::spreads(film, display);
        let (variance, bound) = displayed.mean_and_bound(confidence);
        let (relmse, relmse_bound) = relative.mean_and_bound(confidence);
        Some(Self { error: variance.sqrt(), error_bound: bound.sqrt(), relmse, relmse_bound })
    }
}
