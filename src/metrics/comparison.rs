use super::flip::{PIXELS_PER_DEGREE, flip};
use super::{Plane, Shown, alpha_rmse, relmse, rmse, ssim};
use serde::Serialize;

/// How much a picture differs from a reference.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Comparison {
    /// Width of both in pixels.
    pub width: u32,
    /// Height of both in pixels.
    pub height: u32,
    /// Pixels that either covers: those that `rmse` and `relmse` are about.
    pub covered: u64,
    /// Root mean square difference as displayed, levels 0–255.
    pub rmse: f64,
    /// Largest difference of a displayed channel, levels 0–255.
    pub max: f64,
    /// Root mean square difference of the coverage, levels 0–255.
    pub alpha: f64,
    /// Relative mean square error in linear light; `None` when a pixel is not finite.
    pub relmse: Option<f64>,
    /// Whether `relmse` is about radiance; else about the light of a display.
    pub scene_referred: bool,
    /// Mean structural similarity of the displayed luma: 1 for equal pictures.
    pub ssim: f64,
    /// Mean of ꟻLIP at 67 pixels per degree: 0 for equal pictures, at most 1.
    pub flip: f64,
    /// The value that ꟻLIP stays below in 95 % of the covered pixels; 0.10 is just noticeable.
    pub flip_p95: f64,
}

/// Compares a picture with a reference. Gives the map of ꟻLIP too.
///
/// # Errors
/// A sentence, when their sizes differ or they have no pixels.
pub fn compare(test: &Shown, reference: &Shown) -> Result<(Comparison, Plane), String> {
    let size = |s: &Shown| (s.width, s.height);
    if size(test) != size(reference) {
        let [(w, h), (v, g)] = [size(test), size(reference)];
        return Err(format!("sizes differ: {w}×{h} and {v}×{g}"));
    }
    if test.displayed.is_empty() {
        return Err("pictures without pixels".into());
    }
    // A radiance against a display's light would mean nothing.
    let scene_referred = test.scene_referred && reference.scene_referred;
    let relmse = if test.scene_referred == reference.scene_referred {
        relmse(test, reference)
    } else {
        relmse(&as_displayed(test), &as_displayed(reference))
    };
    let channels = test.displayed.iter().flatten().zip(reference.displayed.iter().flatten());
    let most = channels.map(|(a, b)| f64::from((a - b).abs())).fold(0.0, f64::max);
    let map = flip(test, reference, PIXELS_PER_DEGREE);
    let covered = (0..map.values.len()).filter(|&i| test.alpha[i] > 0.0 || reference.alpha[i] > 0.0);
    let seen = Plane { width: 1, values: covered.map(|i| map.values[i]).collect() };
    let comparison = Comparison {
        width: test.width,
        height: test.height,
        covered: seen.values.len() as u64,
        rmse: rmse(test, reference),
        max: 255.0 * most,
        alpha: alpha_rmse(test, reference),
        relmse,
        scene_referred,
        ssim: ssim::ssim(test, reference),
        flip: map.mean(),
        flip_p95: if seen.values.is_empty() { 0.0 } else { seen.quantile(0.95) },
    };
    Ok((comparison, map))
}

/// With the display's light in place of radiance.
fn as_displayed(shown: &Shown) -> Shown {
    let linear = shown.displayed.iter().map(|p| p.map(crate::write::srgb::decode)).collect();
    Shown { linear, scene_referred: false, ..shown.clone() }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::film::Picture;
    use crate::metrics::Show;

    fn grey(width: u32, level: f32) -> Shown {
        let pixels = vec![[level, level, level, 1.0]; 4 * width as usize];
        Shown::of(&Picture { width, height: 4, pixels }, &Show::default())
    }

    #[test]
    fn equal_pictures_are_equal_in_every_way() {
        let (c, map) = compare(&grey(5, 0.3), &grey(5, 0.3)).expect("one size");
        assert_eq!((c.rmse, c.max, c.relmse, c.flip, c.flip_p95, c.covered), (0.0, 0.0, Some(0.0), 0.0, 0.0, 20));
        assert!((c.ssim - 1.0).abs() < 1e-12 && c.scene_referred && map.values.len() == 20);
        assert!(compare(&grey(5, 0.3), &grey(4, 0.3)).expect_err("sizes").contains("5×4 and 4×4"));
    }

    #[test]
    fn linear_and_encoded_pictures_are_compared_as_displayed() {
        let linear = grey(5, 0.3);
        let (c, _) = compare(&as_displayed(&linear), &linear).expect("one size");
        assert_eq!((c.rmse, c.relmse, c.scene_referred), (0.0, Some(0.0), false));
    }
}
