use super::Display;
use super::said::{Around, Said, in_pieces, said};
use crate::cpu_clock::Helpers;
use crate::film::Film;
use crate::integrate::Aim;
use crate::sampling::{hash_combine, unit_float};
use crate::settings::Adaptive;
use std::collections::BTreeMap;

/// Samples that every pixel gets before it is looked at who needs more.
const BEGIN: u32 = 8;
/// The fewest samples of a pixel at the end of an octave, as a share of its average: what has shown no noise so far may only have
/// been lucky.
const LEAST: f64 = 0.5;
/// The most, likewise: a firefly does not take all.
const MOST: f64 = 4.0;
/// By how much chance raises what a pixel needs, at most.
const ORDER: f64 = 0.1;
const SALT: u32 = 0x5a17_0b1e;
/// Halvings of the interval in which the number of samples per noise is sought.
const STEPS: u32 = 24;

/// Who gets how many samples: adaptive sampling.
///
/// Until [`BEGIN`] all pixels have the same. Then samples are shared out so that the error of the picture,
/// Σ σ²/n, becomes least for what they cost, Σ c n: n ∝ σ/√c (Neyman 1934), in powers of two, at which the points of a pixel are
/// spread best. σ² is that of the displayed picture and that of relMSE, each as a share of the whole picture's. It is looked at
/// whenever the average has doubled: mean deviations over the 7 × 7 pixels around a pixel **without itself**. How often a pixel is sampled then does not depend on what its own samples have brought, and its mean stays unbiased:
/// deciding by its own would end early where bright paths have been missed. c is what a sample costs there, by its rays.
///
/// The pixels which the asset covers, and those beside them, together cost what so many samples in each would; the others, which no error
/// counts, get the fewest.
/// A film at `spp` is the same however it got there.
#[derive(Clone, Debug)]
pub struct Allotment {
    adaptive: Adaptive,
    display: Display,
    octave: Option<Octave>,
    aims: Vec<u32>,
}

impl Allotment {
    /// For a film without samples, that is to look right on a display.
    pub fn new(adaptive: Adaptive, display: Display) -> Self {
        Self { adaptive, display, octave: None, aims: Vec::new() }
    }

    /// Up to where a film with `spp` samples can go without another look at its noise.
    pub fn reach(&self, spp: u32) -> u32 {
        match (self.adaptive, spp) {
            (Adaptive::Off, _) => u32::MAX,
            (Adaptive::Variance, 0..BEGIN) => BEGIN,
            (Adaptive::Variance, _) => octave_of(spp).saturating_mul(2),
        }
    }

    /// Samples of each pixel of a film that is to have `spp` on average; no more than [`Self::reach`]. On the current rayon pool;
    /// `helpers` takes the time.
    pub fn aim(&mut self, film: &Film, spp: u32, helpers: &Helpers) -> Aim<'_> {
        debug_assert!(spp <= self.reach(film.spp));
        if self.adaptive == Adaptive::Off || spp <= BEGIN {
            return Aim::All(spp);
        }
        let begin = octave_of(film.spp);
        let octave = match self.octave.take() {
            Some(octave) if octave.begin == begin => octave,
            _ => Octave::of(film, &self.display, helpers),
        };
        octave.aims(film, spp, &mut self.aims);
        self.octave = Some(octave);
        Aim::Each(&self.aims)
    }
}

/// The number of samples at which the octave began that a film with `spp` ≥ [`BEGIN`] is in.
fn octave_of(spp: u32) -> u32 {
    BEGIN << (spp / BEGIN).ilog2()
}

/// What is known at the beginning of an octave.
#[derive(Clone, Debug)]
struct Octave {
    begin: u32,
    pixels: Vec<Need>,
}

/// What a pixel needs.
#[derive(Clone, Copy, Debug)]
struct Need {
    covered: bool,
    /// Samples, but for a factor that all pixels share.
    samples: f64,
    /// Of a sample, in camera rays.
    cost: f64,
}

impl Octave {
    fn of(film: &Film, display: &Display, helpers: &Helpers) -> Self {
        let said = said(film, display, helpers);
        let around = Around::of(&said, film.width as usize, helpers);
        let whole = said.iter().fold(Said::default(), |mut all, said| {
            all += *said;
            all
        });
        let costs = film.cost_of_sample();
        let need = |pixel: usize| {
            // A thin edge that a pixel's own samples have missed so far is known by its neighbours: by itself it would be missed for good.
            let coverage = coverage_beside(film, pixel);
            let covered = said[pixel].covered > 0.0 || coverage > 0.0;
            let cost = costs(pixel, coverage);
            // Pixels that need the same do not all double their samples at once.
            let order = 1.0 + ORDER * f64::from(unit_float(hash_combine(SALT, pixel as u32)));
            let samples = around.without(pixel).relative_to(&whole) / cost.sqrt() * order;
            Need { covered, samples: rounded(samples), cost }
        };
        Self { begin: octave_of(film.spp), pixels: in_pieces(said.len(), helpers, |piece| piece.map(need).collect()) }
    }

    /// The samples of each pixel when the average is `spp`.
    fn aims(&self, film: &Film, spp: u32, aims: &mut Vec<u32>) {
        let end = 2.0 * f64::from(self.begin);
        let wanted = |samples: f64, has: u32, factor: f64| {
            power_of_two((factor * samples).clamp(LEAST * end, MOST * end)).max(has)
        };
        // Few classes, since needs are rounded: what pixels of a need and a number of samples cost together.
        let mut classes: BTreeMap<(u64, u32), f64> = BTreeMap::new();
        for (need, pixel) in self.pixels.iter().zip(&film.pixels).filter(|(need, _)| need.covered) {
            *classes.entry((need.samples.to_bits(), pixel.samples())).or_default() += need.cost;
        }
        let budget = classes.values().sum::<f64>() * f64::from(spp);
        let cost = |factor: f64| -> f64 {
            let class = |((samples, has), cost): (&(u64, u32), &f64)| {
                cost * f64::from(wanted(f64::from_bits(*samples), *has, factor))
            };
            classes.iter().map(class).sum()
        };
        // Positive numbers are in the order of their bits.
        let need_of = |class: Option<(&(u64, u32), _)>| class.map_or(1.0, |((samples, _), _)| f64::from_bits(*samples));
        let (least, greatest) = (need_of(classes.first_key_value()), need_of(classes.last_key_value()));
        // Between them all pixels go from the fewest samples to the most.
        let (mut low, mut high) = (LEAST * end / greatest, 2.0 * MOST * end / least);
        for _ in 0..STEPS {
            let middle = (low * high).sqrt();
            if cost(middle) <= budget { low = middle } else { high = middle }
        }
        let aim = |need: &Need, has: u32| {
            if need.covered { wanted(need.samples, has, low) } else { power_of_two(LEAST * end).max(has) }
        };
        aims.clear();
        aims.extend(self.pixels.iter().zip(&film.pixels).map(|(need, pixel)| aim(need, pixel.samples())));
    }
}

/// A positive number with six bits behind the first one: 1.6 % at most below.
fn rounded(x: f64) -> f64 {
    f64::from_bits(x.to_bits() & !((1 << 46) - 1))
}

/// The power of two that is nearest by its ratio to a number ≥ 1.
fn power_of_two(x: f64) -> u32 {
    1 << ((x * std::f64::consts::SQRT_2) as u32).ilog2()
}

/// Mean coverage of the eight pixels beside a pixel.
fn coverage_beside(film: &Film, pixel: usize) -> f64 {
    let (width, height) = (film.width as usize, film.height as usize);
    let (x, y) = (pixel % width, pixel / width);
    let near = |at: usize, size: usize| at.saturating_sub(1)..(at + 2).min(size);
    let (mut sum, mut count) = (0.0, 0.0);
    for other in near(y, height).flat_map(|v| near(x, width).map(move |u| v * width + u)).filter(|o| *o != pixel) {
        (sum, count) = (sum + film.pixels[other].mean()[3], count + 1.0);
    }
    if count > 0.0 { sum / count } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cpu_clock::CpuClock;
    use crate::settings::{PictureSettings, ToneMap};

    const SIDE: u32 = 32;

    fn display() -> Display {
        Display::new(&PictureSettings { tonemap: ToneMap::None, ..PictureSettings::default() }, 0.0)
    }

    /// Fills a film up to `spp` by an allotment, in passes of so many; samples of a pixel are `of(pixel, number in [0, 1))`.
    fn fill(allotment: &mut Allotment, seed: u32, passes: &[u32], of: impl Fn(u32, f32) -> [f32; 4]) -> Film {
        let mut film = Film::new(SIDE, SIDE, false);
        for spp in passes {
            match allotment.aim(&film, *spp, &CpuClock::begin().helpers) {
                Aim::All(n) => (0..SIDE * SIDE).for_each(|p| grow(&mut film, seed, p, n, &of)),
                Aim::Each(aims) => (0..SIDE * SIDE).for_each(|p| grow(&mut film, seed, p, aims[p as usize], &of)),
            }
            film.spp = *spp;
        }
        film
    }

    fn grow(film: &mut Film, seed: u32, pixel: u32, aim: u32, of: &impl Fn(u32, f32) -> [f32; 4]) {
        let sums = &mut film.pixels[pixel as usize];
        for s in sums.samples()..aim {
            sums.add(s, of(pixel, unit_float(hash_combine(hash_combine(seed, pixel), s))));
        }
    }

    /// The left half is noisy, the right half hardly, the upper quarter shows nothing.
    fn halves(pixel: u32, u: f32) -> [f32; 4] {
        let noise = if pixel % SIDE < SIDE / 2 { 0.2 } else { 0.02 };
        if pixel < SIDE * SIDE / 4 { [0.0; 4] } else { [0.3 + noise * (u - 0.5), 0.3, 0.3, 1.0] }
    }

    #[test]
    fn samples_go_where_the_noise_is_and_the_average_stays() {
        let film = fill(&mut Allotment::new(Adaptive::Variance, display()), 1, &[8, 16, 32, 64, 128], halves);
        let samples = |x: u32, y: u32| film.pixels[(y * SIDE + x) as usize].samples();
        let (noisy, quiet, empty) = (samples(6, 20), samples(26, 20), samples(6, 2));
        assert!(noisy >= 128 && (quiet, empty) == (64, 64), "{noisy} {quiet} {empty}");
        let covered = film.pixels.iter().filter(|p| p.mean()[3] > 0.0).map(|p| f64::from(p.samples()));
        let average = covered.sum::<f64>() / f64::from(SIDE * SIDE * 3 / 4);
        assert!((0.9..=1.0).contains(&(average / 128.0)), "{average}");
        assert!(film.pixels.iter().all(|p| p.samples().is_power_of_two()));
    }

    #[test]
    fn pixels_alone_and_pictures_of_nothing_are_no_trouble() {
        let mut allotment = Allotment::new(Adaptive::Variance, display());
        let film = fill(&mut allotment, 1, &[8, 16, 32, 64], |p, u| if p == 40 { [u, u, u, 1.0] } else { [0.0; 4] });
        // It and the eight beside it, which see its noise where it sees none, share what nine pixels have; the others get the fewest.
        let side = SIDE as usize;
        let near = |pixel: usize| (pixel % side).abs_diff(40 % side) <= 1 && (pixel / side).abs_diff(40 / side) <= 1;
        let samples = |pixel: usize| film.pixels[pixel].samples();
        assert!((0..side * side).filter(|p| !near(*p)).all(|p| samples(p) == 32));
        let average = f64::from((0..side * side).filter(|p| near(*p)).map(samples).sum::<u32>()) / 9.0;
        assert!(samples(40) >= 32 && (0.85..=1.0).contains(&(average / 64.0)), "{} {average}", samples(40));
        let mut allotment = Allotment::new(Adaptive::Variance, display());
        let film = fill(&mut allotment, 1, &[8, 16, 32], |_, _| [0.0; 4]);
        assert!(film.pixels.iter().all(|p| p.samples() == 16));
    }

    #[test]
    fn a_film_does_not_depend_on_its_passes() {
        let filled = |passes: &[u32]| fill(&mut Allotment::new(Adaptive::Variance, display()), 1, passes, halves);
        let whole = filled(&[8, 16, 32, 56]);
        assert!(whole == filled(&[1, 2, 4, 8, 12, 16, 20, 24, 28, 32, 40, 48, 56]));
    }

    #[test]
    fn thin_edges_keep_their_coverage() {
        // A column of which each sample meets a twentieth, beside a surface: most of its pixels have met nothing in the first eight samples.
        let edge = |pixel: u32, u: f32| match (pixel % SIDE).cmp(&(SIDE / 2)) {
            std::cmp::Ordering::Less => [0.2 + 0.1 * u, 0.2, 0.2, 1.0],
            std::cmp::Ordering::Equal if u < 0.05 => [0.2, 0.2, 0.2, 1.0],
            _ => [0.0; 4],
        };
        let mut alphas = Vec::new();
        for seed in 0..40 {
            let film = fill(&mut Allotment::new(Adaptive::Variance, display()), seed, &[8, 16, 32], edge);
            alphas.extend(film.pixels.iter().skip(SIDE as usize / 2).step_by(SIDE as usize).map(|p| p.mean()[3]));
        }
        let n = alphas.len() as f64;
        let mean = alphas.iter().sum::<f64>() / n;
        let deviation = (alphas.iter().map(|a| (a - mean) * (a - mean)).sum::<f64>() / n / n).sqrt();
        assert!((mean - 0.05).abs() < 3.5 * deviation && deviation < 2e-3, "{mean} ± {deviation}");
    }

    #[test]
    fn what_shows_no_noise_is_sampled_evenly() {
        let film =
            fill(&mut Allotment::new(Adaptive::Variance, display()), 1, &[8, 16, 32, 64], |_, _| [0.5, 0.5, 0.5, 1.0]);
        assert!(film.pixels.iter().all(|p| p.samples() == 64));
    }

    #[test]
    fn means_are_not_biased_where_rare_samples_carry_the_light() {
        // A path in fifty brings all the light: deciding by a pixel's own samples would lose some per cent of it.
        let rare = |_: u32, u: f32| if u < 0.02 { [2.5, 2.5, 2.5, 1.0] } else { [0.0, 0.0, 0.0, 1.0] };
        let mut means = Vec::new();
        for seed in 0..40 {
            let film = fill(&mut Allotment::new(Adaptive::Variance, display()), seed, &[8, 16, 32, 64], rare);
            means.extend(film.pixels.iter().map(|p| p.mean()[0]));
            assert!(film.pixels.iter().any(|p| p.samples() != 64));
        }
        let n = means.len() as f64;
        let mean = means.iter().sum::<f64>() / n;
        let deviation = (means.iter().map(|m| (m - mean) * (m - mean)).sum::<f64>() / n / n).sqrt();
        assert!((mean - 0.05).abs() < 3.5 * deviation && deviation < 4e-4, "{mean} ± {deviation}");
    }
}
