use super::jackknife::{Each, LeaveOneOut};
use super::surroundings::{
    COUNT, FIELDS, Fields, LEVEL_SQUARES, LEVELS, MEAN, NOISE, OWN, RADIUS, SQUARES, Surroundings, center,
    displayed_spread, relative_spread, share_of_noise,
};
use super::{Display, Spread, displayed, relmse};
use crate::cpu_clock::Helpers;
use crate::film::{Film, PixelSums, SQUARE};
use crate::lanes::{AnyLanes, LANES, Lanes, Work};
use crate::math::simd::SimdTier;
use rayon::prelude::*;
use std::collections::BTreeMap;
use std::ops::Range;

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
pub(super) fn spreads(film: &Film, display: &Display, helpers: &Helpers) -> [Spread; 2] {
    spreads_in(AnyLanes::new(SimdTier::detect()), film, display, helpers)
}

fn spreads_in(lanes: AnyLanes, film: &Film, display: &Display, helpers: &Helpers) -> [Spread; 2] {
    let height = film.height as usize;
    let spreads_of = |band: usize| {
        let rows = band * BAND..((band + 1) * BAND).min(height);
        helpers.help(|| lanes.run(Band { film, display, rows }))
    };
    let bands: Vec<[Spread; 2]> = (0..height.div_ceil(BAND)).into_par_iter().with_max_len(1).map(spreads_of).collect();
    bands.into_iter().fold([Spread::default(); 2], |mut all, band| {
        all.iter_mut().zip(band).for_each(|(a, b)| *a += b);
        all
    })
}

/// Some rows.
struct Band<'a> {
    film: &'a Film,
    display: &'a Display,
    rows: Range<usize>,
}

impl Work for Band<'_> {
    type Output = [Spread; 2];

    #[inline(always)]
    fn run<L: Lanes>(self, lanes: L) -> [Spread; 2] {
        let Self { film, display, rows } = self;
        let width = film.width as usize;
        let mut judge = Judge::default();
        let mut around = Surroundings::new(width);
        for row in rows.start.saturating_sub(RADIUS)..rows.end + RADIUS {
            // Below the picture there is nothing.
            let pixels = film.pixels.get(row * width..(row + 1) * width).unwrap_or(&[]);
            for x in (0..width).step_by(LANES) {
                let sixteen = pixels.get(x..(x + LANES).min(width)).unwrap_or(&[]);
                around.tell(x, &facts(lanes, film, display, sixteen));
            }
            around.next();
            if row < rows.start + RADIUS {
                continue;
            }
            let first = (row - RADIUS) * width;
            for x in (0..width).step_by(LANES) {
                judge.add(lanes, (film, display), first + x, &around.own(x), &around.around(x));
            }
        }
        judge.finish()
    }
}

/// What has been said of the pixels so far.
#[derive(Default)]
struct Judge {
    spreads: [Spread; 2],
    groups: BTreeMap<usize, [f64; 2]>,
}

impl Judge {
    /// Adds sixteen pixels from number `first` on, by what is known of them and of the pixels around.
    #[inline(always)]
    fn add<L: Lanes>(
        &mut self,
        lanes: L,
        (film, display): (&Film, &Display),
        first: usize,
        own: &[Each; MEAN],
        around: &Fields,
    ) {
        let noise = share_of_noise(around);
        let center = center(around);
        let shown = display.levels_of(lanes, &center, film.opaque);
        let seen_around = [displayed_spread(around, &shown), relative_spread(around, &center, relmse::EPSILON)];
        let mut best = [[0.0; LANES]; 2];
        for k in 0..2 {
            for i in 0..LANES {
                let weight = noise[i].min(1.0) * noise[i].min(1.0) * noise[i].min(1.0);
                let seen = if noise[i] > 0.0 { noise[i] * seen_around[k][i] } else { 0.0 };
                let curve = seen - around[OWN + k][i] / around[COUNT][i];
                best[k][i] = own[OWN + k][i] + weight * curve;
            }
        }
        for i in 0..LANES {
            if own[COUNT][i] == 0.0 {
                continue;
            }
            for (k, spread) in self.spreads.iter_mut().enumerate() {
                spread.add(best[k][i], own[OWN + k][i]);
            }
            if film.shares {
                let group = self.groups.entry(film.group_of(first + i)).or_default();
                (0..2).for_each(|k| group[k] += own[OWN + k][i]);
            }
        }
    }

    fn finish(mut self) -> [Spread; 2] {
        if !self.groups.is_empty() {
            for (k, spread) in self.spreads.iter_mut().enumerate() {
                spread.own_squares = self.groups.values().map(|own| own[k] * own[k]).sum();
            }
        }
        self.spreads
    }
}

/// What is known of up to sixteen pixels.
#[inline(always)]
fn facts<L: Lanes>(lanes: L, film: &Film, display: &Display, pixels: &[PixelSums]) -> Fields {
    let parts = LeaveOneOut::of(pixels);
    let levels = display.levels_of(lanes, &parts.mean, film.opaque);
    let mut fields = [[0.0; LANES]; FIELDS];
    fields[OWN] = displayed::square_error(lanes, &parts, display, film.opaque, &levels);
    fields[OWN + 1] = relmse::square_error(&parts);
    fields[MEAN..MEAN + 4].copy_from_slice(&parts.mean);
    fields[NOISE] = parts.noise;
    fields[LEVELS..LEVELS + 3].copy_from_slice(&levels);
    for c in 0..3 {
        for i in 0..LANES {
            fields[SQUARES + c][i] = parts.mean[c][i] * parts.mean[c][i];
            fields[LEVEL_SQUARES][i] += levels[c][i] * levels[c][i];
        }
    }
    for field in &mut fields {
        only(field, &parts.covered);
    }
    fields[COUNT] = parts.covered;
    fields
}

/// Zeros where the other number is 0.
#[inline(always)]
fn only(numbers: &mut Each, covered: &Each) {
    for i in 0..LANES {
        numbers[i] = if covered[i] > 0.0 { numbers[i] } else { 0.0 };
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cpu_clock::CpuClock;
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
            let [r, g, b, a] = film.pixels[pixel as usize].mean().map(|x| x as f32);
            let shown = display.levels([r, g, b, a])[0];
            let [r, _, _] = display.levels([truth(pixel), truth(pixel), truth(pixel), 1.0]);
            (shown - r) * (shown - r)
        };
        let real: f64 = (0..SIDE * SIDE).map(error).sum();
        let [stated, _] = spreads(film, &display, &CpuClock::begin().helpers);
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
        let bounds =
            |film: &Film| spreads(film, &display, &CpuClock::begin().helpers).map(|spread| spread.mean_and_bound(0.95));
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

    /// The sums around each pixel of some rows.
    struct Around<'a>(&'a Film, Range<usize>);

    impl Work for Around<'_> {
        type Output = Vec<Fields>;

        #[inline(always)]
        fn run<L: Lanes>(self, lanes: L) -> Vec<Fields> {
            let display = Display::new(&PictureSettings::default(), 0.0);
            let (mut around, mut sums) = (Surroundings::new(SIDE as usize), Vec::new());
            for row in self.1.start.saturating_sub(RADIUS)..self.1.end + RADIUS {
                for x in (0..SIDE as usize).step_by(LANES) {
                    let pixels = self.0.pixels.get(row * SIDE as usize + x..).unwrap_or(&[]);
                    around.tell(x, &facts(lanes, self.0, &display, &pixels[..pixels.len().min(LANES)]));
                }
                around.next();
                if row >= self.1.start + RADIUS {
                    sums.extend((0..SIDE as usize).step_by(LANES).map(|x| around.around(x)));
                }
            }
            sums
        }
    }

    #[test]
    fn how_a_film_is_cut_into_bands_does_not_matter() {
        let film = film(|pixel, u| u * (pixel % 7) as f32);
        let around = |tier, rows| AnyLanes::new(tier).run(Around(&film, rows));
        let bits =
            |all: &[Fields]| -> Vec<u64> { all.iter().flat_map(|s| s.iter().flatten().map(|x| x.to_bits())).collect() };
        let whole = around(SimdTier::Scalar, 0..SIDE as usize);
        for tier in SimdTier::ALL {
            let parts: [Range<usize>; 3] = [0..3, 3..90, 90..SIDE as usize];
            let cut: Vec<Fields> = parts.into_iter().flat_map(|rows| around(tier, rows)).collect();
            assert!(bits(&whole) == bits(&cut), "{tier}");
        }
        let sixteens = SIDE as usize / LANES;
        let count = |row: usize, x: usize| whole[row * sixteens + x / LANES][COUNT][x % LANES];
        // The first of every seven pixels is black, but covered.
        assert_eq!((count(0, 0), count(1, 1), count(5, 5), count(5, 127)), (9.0, 16.0, 25.0, 15.0));
    }

    #[test]
    fn all_tiers_say_the_same() {
        let film = film(|pixel, u| if u < 0.1 { 3.0 } else { u * (pixel % 5) as f32 });
        let display = Display::new(&PictureSettings::default(), 0.0);
        let said = |tier| spreads_in(AnyLanes::new(tier), &film, &display, &CpuClock::begin().helpers);
        let plain = said(SimdTier::Scalar);
        assert!(plain[0].sum > 0.0 && SimdTier::ALL.into_iter().all(|tier| said(tier) == plain));
    }

    #[test]
    fn pictures_that_are_no_multiple_of_sixteen_wide_lose_no_pixel() {
        let mut film = Film::new(21, 5, false);
        for (k, pixel) in film.pixels.iter_mut().enumerate() {
            (0..4).for_each(|s| pixel.add(s, [(k + s as usize) as f32 * 0.01, 0.2, 0.3, 1.0]));
        }
        film.spp = 4;
        let [shown, relative] =
            spreads(&film, &Display::new(&PictureSettings::default(), 0.0), &CpuClock::begin().helpers);
        assert_eq!((shown.count, relative.count), (105.0, 105.0));
        assert!(shown.sum.is_finite() && shown.own_squares.is_finite() && relative.sum > 0.0);
    }
}
