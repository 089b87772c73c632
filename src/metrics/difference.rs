use super::Shown;

/// Keeps relMSE finite where the reference is dark, in squared units of radiance.
pub const RELMSE_EPSILON: f64 = 0.01;

/// The pixels that count: those that either picture covers.
fn counted(a: &Shown, b: &Shown) -> impl Iterator<Item = usize> {
    (0..a.alpha.len()).filter(|&i| a.alpha[i] > 0.0 || b.alpha[i] > 0.0)
}

/// Root mean square difference of the displayed channels in levels 0–255, before rounding, over the pixels that either
/// picture covers; 0 when there are none.
pub fn rmse(a: &Shown, b: &Shown) -> f64 {
    let (mut sum, mut count) = (0.0, 0u64);
    for i in counted(a, b) {
        for (x, y) in a.displayed[i].iter().zip(b.displayed[i]) {
            let difference = 255.0 * (f64::from(*x) - f64::from(y));
            sum += difference * difference;
            count += 1;
        }
    }
    if count == 0 { 0.0 } else { (sum / count as f64).sqrt() }
}

/// Relative mean square error in linear light, over the pixels that either picture covers: the mean of
/// (a − b)² / (b² + [`RELMSE_EPSILON`]) over channels. `None` when a pixel is not finite in one of them.
pub fn relmse(a: &Shown, b: &Shown) -> Option<f64> {
    let (mut sum, mut count) = (0.0, 0u64);
    for i in counted(a, b) {
        for (x, y) in a.linear[i].iter().zip(b.linear[i]) {
            let (x, y) = (f64::from(*x), f64::from(y));
            sum += (x - y) * (x - y) / (y * y + RELMSE_EPSILON);
            count += 1;
        }
    }
    let mean = if count == 0 { 0.0 } else { sum / count as f64 };
    mean.is_finite().then_some(mean)
}

/// Root mean square difference of the coverage in levels 0–255, over the pixels that either picture covers: black things
/// that are missing on a black background show here.
pub fn alpha_rmse(a: &Shown, b: &Shown) -> f64 {
    let (mut sum, mut count) = (0.0, 0u64);
    for i in counted(a, b) {
        let difference = 255.0 * (f64::from(a.alpha[i]) - f64::from(b.alpha[i]));
        sum += difference * difference;
        count += 1;
    }
    if count == 0 { 0.0 } else { (sum / count as f64).sqrt() }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::film::Picture;
    use crate::metrics::Show;
    use crate::settings::ToneMap;

    fn shown(pixels: Vec<[f32; 4]>) -> Shown {
        let show = Show { tonemap: ToneMap::None, ..Show::default() };
        Shown::of(&Picture { width: pixels.len() as u32, height: 1, pixels }, &show)
    }

    #[test]
    fn what_neither_covers_does_not_count() {
        let grey = [0.5, 0.5, 0.5, 1.0];
        let (a, b) = (shown(vec![grey, [0.0; 4], [1.0; 4]]), shown(vec![grey, [0.0; 4], [0.0, 0.0, 0.0, 1.0]]));
        // One of two pixels is off by all of 255.
        assert!((rmse(&a, &b) - 255.0 * 0.5f64.sqrt()).abs() < 1e-3, "{}", rmse(&a, &b));
        assert_eq!(relmse(&a, &b), Some(0.5 / RELMSE_EPSILON));
        assert_eq!((rmse(&a, &a), relmse(&a, &a)), (0.0, Some(0.0)));
        let nothing = shown(vec![[0.0; 4]]);
        assert_eq!((rmse(&nothing, &nothing), relmse(&nothing, &nothing)), (0.0, Some(0.0)));
        assert_eq!(relmse(&shown(vec![[f32::NAN, 0.0, 0.0, 1.0]]), &shown(vec![grey])), None);
    }

    #[test]
    fn a_black_thing_that_is_missing_shows_in_the_coverage() {
        let (thing, nothing) = (shown(vec![[0.0, 0.0, 0.0, 1.0]]), shown(vec![[0.0; 4]]));
        assert_eq!((rmse(&thing, &nothing), alpha_rmse(&thing, &nothing)), (0.0, 255.0));
    }

    #[test]
    fn an_edge_weighs_as_much_as_its_alpha() {
        // White on black at half coverage: half of 255 levels, as a browser blends.
        let (edge, nothing) = (shown(vec![[0.5; 4]]), shown(vec![[0.0; 4]]));
        assert!((rmse(&edge, &nothing) - 127.5).abs() < 1e-3, "{}", rmse(&edge, &nothing));
    }
}
