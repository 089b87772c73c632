use super::jackknife::LeaveOneOut;
use super::surroundings::{Sums, with_surroundings};
use super::{Display, Spread, displayed, relmse};
use crate::film::{Film, SQUARE};
use rayon::prelude::*;
use std::collections::BTreeMap;

/// Rows that are judged at a time: enough that the rows around them are few, and whole squares in which pixels use each other's paths.
const BAND: usize = 2 * SQUARE as usize;

/// The spreads of the displayed error and of relMSE over the pixels that the asset covers. Sums have a fixed order.
///
/// A pixel's own replicates do not tell of light that none of its samples has met: where rare paths light a surface, most
/// pixels are dark and state no error, though their true one, T(0) − T(μ), is large where the tone curve T is steep. The pixels
/// around it know. As far as they differ from each other by noise alone (a share f of their variance in linear light, by their
/// replicates), they are outcomes of what this pixel might have been, and a share f of the spread of T over them about T(mean) is
/// noise as it is displayed. On a straight curve that is what their own estimates say on average; the difference is what the curve
/// does, and is added with f³ (where texture differs more than noise, slopes at other levels say little). How far the sum can be
/// off is judged by the pixels' own estimates, which are independent.
///
/// Where pixels use each other's paths, those of a group ([`crate::film::group_in_square`]) are not: they count as one pixel that has the
/// errors of all, as if they were wholly alike, which they are in indirect light at most. They are no neighbours of each other.
pub(super) fn spreads(film: &Film, display: &Display) -> [Spread; 2] {
    let height = film.height as usize;
    let bands: Vec<[Spread; 2]> = (0..height.div_ceil(BAND))
        .into_par_iter()
        .map(|band| band_spreads(film, display, band * BAND..((band + 1) * BAND).min(height)))
        .collect();
    bands.into_iter().fold([Spread::default(); 2], |mut all, band| {
        all.iter_mut().zip(band).for_each(|(a, b)| *a += b);
        all
    })
}

fn band_spreads(film: &Film, display: &Display, rows: std::ops::Range<usize>) -> [Spread; 2] {
    let mut spreads = [Spread::default(); 2];
    let mut groups: BTreeMap<usize, [f64; 2]> = BTreeMap::new();
    let first = rows.start * film.width as usize;
    let pixels = with_surroundings(film, rows, |pixel| facts(film, display, pixel));
    for (number, (pixel, around)) in pixels.into_iter().enumerate() {
        if pixel.count == 0.0 {
            continue;
        }
        let noise = if around.count > 1.0 { around.share_of_noise() } else { 0.0 };
        let spread_around = || {
            let shown = display.levels(seen(around.center(), film.opaque));
            [around.displayed_spread(shown), around.relative_spread(relmse::EPSILON)]
        };
        let weight = noise.min(1.0) * noise.min(1.0) * noise.min(1.0);
        let seen_around = if noise > 0.0 { spread_around() } else { [0.0; 2] };
        for (k, spread) in spreads.iter_mut().enumerate() {
            let curve = noise * seen_around[k] - around.own[k] / around.count;
            spread.add(pixel.own[k] + weight * curve, pixel.own[k]);
        }
        if film.shares {
            let group = groups.entry(film.group_of(first + number)).or_default();
            (0..2).for_each(|k| group[k] += pixel.own[k]);
        }
    }
    if film.shares {
        for (k, spread) in spreads.iter_mut().enumerate() {
            spread.own_squares = groups.values().map(|own| own[k] * own[k]).sum();
        }
    }
    spreads
}

/// What is known of a pixel.
fn facts(film: &Film, display: &Display, pixel: usize) -> Sums {
    let pixel = &film.pixels[pixel];
    let parts = LeaveOneOut::of(pixel);
    let mean = parts.mean;
    if !(mean[3] > 0.0) {
        return Sums::default();
    }
    let levels = display.levels(seen(mean, film.opaque));
    Sums {
        count: 1.0,
        own: [displayed::square_error(&parts, display, film.opaque, levels), relmse::square_error(&parts)],
        mean,
        squares: [0, 1, 2].map(|c| mean[c] * mean[c]),
        noise: pixel.variance().iter().sum(),
        levels,
        level_squares: levels.iter().map(|l| l * l).sum(),
    }
}

/// A pixel as the picture has it.
pub(super) fn seen([r, g, b, a]: [f64; 4], opaque: bool) -> [f32; 4] {
    [r as f32, g as f32, b as f32, if opaque { 1.0 } else { a as f32 }]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sampling::{hash_combine, unit_float};
    use crate::settings::{PictureSettings, ToneMap};

    const SIDE: u32 = 128;
    const SPP: u32 = 32;

    /// A film whose pixels have samples `of(pixel, number in [0, 1))`, all different numbers.
    fn film(of: impl Fn(u32, f32) -> f32) -> Film {
        let mut film = Film::new(SIDE, SIDE, false);
        for pixel in 0..SIDE * SIDE {
            for s in 0..SPP {
                let light = of(pixel, unit_float(hash_combine(hash_combine(5, pixel), s)));
                film.pixels[pixel as usize].add(s, [light, light, light, 1.0]);
            }
        }
        film.spp = SPP;
        film
    }

    /// The squared displayed error that a film has if its pixels ought to be `truth`, over what it states, and over what its pixels
    /// state each for itself.
    fn ratios(film: &Film, truth: impl Fn(u32) -> f32) -> (f64, f64) {
        let settings = PictureSettings { tonemap: ToneMap::None, ..PictureSettings::default() };
        let display = Display::new(&settings, 0.0);
        let error = |pixel: u32| {
            let shown = display.levels(seen(film.pixels[pixel as usize].mean(), false))[0];
            let [r, _, _] = display.levels([truth(pixel), truth(pixel), truth(pixel), 1.0]);
            (shown - r) * (shown - r)
        };
        let real: f64 = (0..SIDE * SIDE).map(error).sum();
        let [stated, _] = spreads(film, &display);
        (stated.sum / real, stated.own / real)
    }

    #[test]
    fn pixels_that_have_not_met_their_light_learn_of_it_from_others() {
        // Every fiftieth path finds the light: half of the pixels are black.
        let (stated, own) = ratios(&film(|_, u| if u < 0.02 { 5.0 } else { 0.0 }), |_| 0.1);
        assert!((0.95..1.15).contains(&stated) && (0.95..1.1).contains(&own), "{stated} {own}");
    }

    #[test]
    fn fireflies_that_are_white_on_a_screen_count_in_full() {
        // One path in ten thousand is so bright that its pixel is white, and white it would be at half of that: the replicates' distances from
        // the whole would say half of the square. (The pixels around are reckoned to miss it, too: more than is true where it is that rare.)
        let (stated, own) = ratios(&film(|_, u| if u < 1e-4 { 100.0 } else { 0.2 }), |_| 0.21);
        assert!((0.8..1.1).contains(&own) && (0.8..2.0).contains(&stated), "{stated} {own}");
    }

    #[test]
    fn pixels_near_white_are_no_fireflies() {
        // Even noise about the level at which the screen is white: half of it cannot be seen.
        let (stated, own) = ratios(&film(|_, u| 1.0 + 0.3 * (u - 0.5)), |_| 1.0);
        assert!((0.85..1.1).contains(&stated) && (0.85..1.1).contains(&own), "{stated} {own}");
    }

    #[test]
    fn texture_is_no_noise() {
        // A checkerboard of 0.1 and 0.5 with half as much noise, and with next to none.
        let tile = |pixel: u32| if (pixel % SIDE + pixel / SIDE).is_multiple_of(2) { 0.1 } else { 0.5 };
        for noise in [1.0, 0.3] {
            let (stated, own) = ratios(&film(|p, u| tile(p) * (1.0 + noise * (2.0 * u - 1.0))), tile);
            assert!((0.95..1.05).contains(&stated) && (0.95..1.05).contains(&own), "{noise}: {stated} {own}");
        }
    }

    #[test]
    fn pixels_that_use_each_others_paths_say_less() {
        let mut film = film(|_, u| u);
        let display = Display::new(&PictureSettings::default(), 0.0);
        let bounds = |film: &Film| spreads(film, &display).map(|spread| spread.mean_and_bound(0.95));
        let alone = bounds(&film);
        film.shares = true;
        for ((error, bound), (same, nearer)) in bounds(&film).into_iter().zip(alone) {
            // As far as with a sixteenth of the pixels, were they all the same; here they only might be: σ⁴ of 16 pixels is taken
            // as (16 σ²)² + 16 · 2 σ⁴, a third of it.
            assert_eq!(error, same);
            let further = libm::log(bound / error) / libm::log(nearer / same);
            assert!((2.2..3.0).contains(&further), "{further}");
        }
    }

    #[test]
    fn how_a_film_is_cut_into_bands_does_not_matter() {
        let film = film(|pixel, u| u * (pixel % 7) as f32);
        let display = Display::new(&PictureSettings::default(), 0.0);
        let around = |rows| -> Vec<Sums> {
            let pixels = with_surroundings(&film, rows, |pixel| facts(&film, &display, pixel));
            pixels.into_iter().map(|(_, around)| around).collect()
        };
        let whole = around(0..SIDE as usize);
        let cut: Vec<Sums> = [0..3, 3..90, 90..SIDE as usize].into_iter().flat_map(around).collect();
        let bits = |all: &[Sums]| -> Vec<u64> {
            all.iter().flat_map(|s| [s.noise, s.mean[0], s.levels[2]].map(f64::to_bits)).collect()
        };
        assert!(bits(&whole) == bits(&cut));
        assert_eq!(
            (whole[0].count, whole[SIDE as usize + 1].count, whole[5 * SIDE as usize + 5].count),
            (9.0, 16.0, 25.0)
        );
    }
}
