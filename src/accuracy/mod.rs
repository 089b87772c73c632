//! How far a picture is from the converged one, as the picture's own samples tell it, and rendering until it is near enough.
//!
//! The **error** of a picture is the RMS difference of what is displayed (tone-mapped, sRGB, 0–255 levels, before rounding,
//! at a fixed exposure) from the converged picture, over red, green and blue of the pixels that the asset covers. Where the
//! background is transparent the picture counts as it looks on black, so that an edge pixel weighs as much as its alpha.
//!
//! It is estimated from the film's replicates, which are independent however well each is distributed in itself: the
//! tone curve is applied to the picture without one replicate after the other ([`displayed`]), which accounts for curve
//! and clipping at the noise that the picture really has. [`Spread`] says how far such an estimate can be off.

mod allotment;
mod bound;
mod displayed;
mod jackknife;
mod pixels;
mod progressive;
mod relmse;
mod said;
mod schedule;
mod specks;
mod surroundings;

pub use allotment::Allotment;
pub use bound::Spread;
pub use displayed::Display;
pub use progressive::{Ended, Finished, Progressive};
pub use schedule::Schedule;
use specks::comes_as_specks;

use crate::cpu_clock::{CpuClock, Helpers};
use crate::film::Film;
use crate::prepare::PreparedScene;
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
        Some(Spreads::of(film, display, &CpuClock::begin().helpers)?.accuracy(confidence))
    }

    /// The same of a picture of a scene, of which more may be known than the samples say: where light comes in specks
    /// ([`PreparedScene::rare_light`]), most pictures have met too few of them to know how many there are, and the bounds are further
    /// away.
    #[must_use]
    pub fn of_scene(self, scene: &PreparedScene) -> Self {
        let factor = specks::factor(scene);
        let (error_bound, relmse_bound) = (factor * self.error_bound, factor * factor * self.relmse_bound);
        Self { error_bound, relmse_bound, ..self }
    }
}

/// What an [`Accuracy`] is made of.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Spreads {
    /// Of the squared displayed error.
    pub displayed: Spread,
    /// Of the relative squared error.
    pub relative: Spread,
}

impl Spreads {
    /// Of the pixels of a film that the asset covers, on the current rayon pool; `None` when there are not two replicates. `helpers`
    /// take the time.
    pub fn of(film: &Film, display: &Display, helpers: &Helpers) -> Option<Self> {
        (film.spp >= 2).then(|| {
            let [displayed, relative] = pixels::spreads(film, display, helpers);
            Self { displayed, relative }
        })
    }

    /// The error, with bounds that hold with probability `confidence`.
    pub fn accuracy(&self, confidence: f64) -> Accuracy {
        let (variance, bound) = self.displayed.mean_and_bound(confidence);
        let (relmse, relmse_bound) = self.relative.mean_and_bound(confidence);
        Accuracy { error: variance.sqrt(), error_bound: bound.sqrt(), relmse, relmse_bound }
    }

    /// The error as seen by who looks for the `looks`-th time whether it is small enough.
    ///
    /// Who looks until a bound is low enough picks the lucky looks, so the 5 % by which bounds may fail are shared out. A
    /// bound E can only fail at a look where the true error is above E, and it is likely to only where that is within the
    /// bound's own distance from the estimate. Passes lower the error by 9 % or more each, so there are not more such looks
    /// than passes that it takes to come that far, and not more than there have been.
    pub fn accuracy_at_look(&self, looks: u32) -> Accuracy {
        let plain = self.accuracy(CONFIDENCE);
        let distance = if plain.error > 0.0 { plain.error_bound / plain.error } else { 1.0 };
        let in_danger = (1.0 + libm::log(distance) / libm::log(SMALLEST_STEP)).min(f64::from(looks.max(1)));
        self.accuracy(1.0 - (1.0 - CONFIDENCE) / in_danger)
    }
}

/// The factor by which a pass of a quarter of an octave lowers the error of independent samples: 2^(1/8).
const SMALLEST_STEP: f64 = 1.09;
