//! ꟻLIP: the difference that a person sees when flipping between two pictures (Andersson, Nilsson, Akenine-Möller,
//! Oskarsson, Åström & Fairchild 2020, "ꟻLIP: A Difference Evaluator for Alternating Images", the variant for
//! displayed pictures). Constants and names are the paper's.

mod colour;
mod filters;

use super::{Plane, Shown};
use colour::{hunt_adjusted_lab, hyab, ycxcz};
use filters::{Features, Sensitivity};

/// Pixels per degree of visual angle where nothing else is known: a 0.7 m wide 4K screen seen from 0.7 m.
pub const PIXELS_PER_DEGREE: f64 = 67.0;

/// Differences of HyAB distance that are just noticeable (Mahy, Van Eycken & Oosterlinck 1994, for CIELAB).
const JUST_NOTICEABLE: f64 = 2.3;

/// q_c: colour distances are taken to this power.
const COLOUR_EXPONENT: f64 = 0.7;
/// p_c: distances below this share of the largest …
const LARGE_DISTANCE: f64 = 0.4;
/// p_t: … take up this share of the scale.
const LARGE_ERROR: f64 = 0.95;
/// q_f: differences of features are taken to this power.
const FEATURE_EXPONENT: f64 = 0.5;

/// The map of differences, 0 (none) to 1, at so many pixels per degree of visual angle.
pub fn flip(test: &Shown, reference: &Shown, pixels_per_degree: f64) -> Plane {
    let (reference, test) = (channels(reference), channels(test));
    let colour = colour_difference(&reference, &test, &Sensitivity::new(pixels_per_degree));
    let features = Features::new(pixels_per_degree);
    let (reference, test) = (features.of(&reference[0]), features.of(&test[0]));
    let normalise = |difference: f64| libm::pow(difference / std::f64::consts::SQRT_2, FEATURE_EXPONENT);
    let edges = reference.edges.zip(&test.edges, |a, b| (a - b).abs());
    let points = reference.points.zip(&test.points, |a, b| (a - b).abs());
    let difference = edges.zip(&points, |e, p| normalise(e.max(p)));
    colour.zip(&difference, |colour, feature| libm::pow(colour, 1.0 - feature))
}

/// The value of the map for a difference of colour alone that is just noticeable: 0.10.
pub fn just_noticeable() -> f64 {
    remap(libm::pow(JUST_NOTICEABLE, COLOUR_EXPONENT), largest_distance())
}

/// Y, Cx and Cz of the displayed picture.
fn channels(shown: &Shown) -> [Plane; 3] {
    let converted: Vec<[f64; 3]> = shown.displayed.iter().map(|p| ycxcz(p.map(f64::from))).collect();
    let plane = |c: usize| Plane { width: shown.width as usize, values: converted.iter().map(|p| p[c]).collect() };
    [plane(0), plane(1), plane(2)]
}

fn colour_difference(reference: &[Plane; 3], test: &[Plane; 3], sensitivity: &Sensitivity) -> Plane {
    let (reference, test) = (sensitivity.seen(reference), sensitivity.seen(test));
    let largest = largest_distance();
    let values = (0..reference[0].values.len())
        .map(|i| {
            let [a, b] =
                [&reference, &test].map(|p| hunt_adjusted_lab([p[0].values[i], p[1].values[i], p[2].values[i]]));
            remap(libm::pow(hyab(a, b), COLOUR_EXPONENT), largest)
        })
        .collect();
    Plane { width: reference[0].width, values }
}

/// The distance between green and blue, to the power of [`COLOUR_EXPONENT`].
fn largest_distance() -> f64 {
    let [green, blue] = [[0.0, 1.0, 0.0], [0.0, 0.0, 1.0]].map(|rgb| hunt_adjusted_lab(ycxcz(rgb)));
    libm::pow(hyab(green, blue), COLOUR_EXPONENT)
}

/// Spreads small distances over most of [0, 1].
fn remap(distance: f64, largest: f64) -> f64 {
    let knee = LARGE_DISTANCE * largest;
    if distance < knee {
        LARGE_ERROR * distance / knee
    } else {
        LARGE_ERROR + (distance - knee) / (largest - knee) * (1.0 - LARGE_ERROR)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Smooth colours with an edge, dots and noise; `other` changes some of each.
    fn pattern(width: u32, height: u32, other: bool) -> Vec<[u8; 3]> {
        let change = u32::from(other);
        let pixel = |x: u32, y: u32| {
            let noise = ((x * 7919 + y * 104_729 + change * 31) % 61) / (3 - change);
            let edge = if x + change * 2 > width / 2 { 90 } else { 0 };
            let dot = if (x % 17 == 3 + change) && y % 13 == 5 { 120 } else { 0 };
            [(x * 2 + noise + dot) % 256, (y * 3 + edge) % 256, (x + y + noise * change + edge) % 256].map(|c| c as u8)
        };
        (0..width * height).map(|i| pixel(i % width, i / width)).collect()
    }

    fn shown(width: u32, pixels: &[[u8; 3]]) -> Shown {
        let displayed: Vec<_> = pixels.iter().map(|p| p.map(|c| f32::from(c) / 255.0)).collect();
        let height = pixels.len() as u32 / width;
        Shown {
            width,
            height,
            linear: displayed.clone(),
            alpha: vec![1.0; pixels.len()],
            displayed,
            scene_referred: false,
        }
    }

    #[test]
    fn agrees_with_nvidias_implementation() {
        for (width, height, ppd) in [(97, 61, 67.0f32), (40, 80, 20.0), (7, 5, 67.0), (64, 64, 120.0)] {
            let [a, b] = [pattern(width, height, false), pattern(width, height, true)];
            let theirs = |p: &[[u8; 3]]| nv_flip::FlipImageRgb8::with_data(width, height, p.as_flattened());
            let expected = nv_flip::flip(theirs(&a), theirs(&b), ppd).to_vec();
            let got = flip(&shown(width, &b), &shown(width, &a), f64::from(ppd));
            let mean = |values: &mut dyn Iterator<Item = f64>| values.sum::<f64>() / f64::from(width * height);
            let difference = mean(&mut got.values.iter().zip(&expected).map(|(g, e)| (g - f64::from(*e)).abs()));
            let most = got.values.iter().zip(&expected).map(|(g, e)| (g - f64::from(*e)).abs()).fold(0.0, f64::max);
            assert!(mean(&mut expected.iter().map(|e| f64::from(*e))) > 0.02, "there is something to see");
            // Theirs computes in single precision; where a power is steep near 0 that shows.
            assert!(difference < 2e-6 && most < 2e-4, "{width}×{height} at {ppd}: mean {difference}, most {most}");
        }
    }

    #[test]
    fn equal_pictures_differ_nowhere_and_black_from_white_everywhere() {
        let a = pattern(20, 10, false);
        assert!(flip(&shown(20, &a), &shown(20, &a), 67.0).values.iter().all(|v| *v == 0.0));
        let [black, white] = [[0u8; 3], [255; 3]].map(|c| shown(20, &[c; 200]));
        let map = flip(&black, &white, 67.0);
        assert!(map.values.iter().all(|v| (0.9..=1.0).contains(v)), "{}", map.values[0]);
    }

    #[test]
    fn what_is_just_noticeable_is_a_tenth_of_the_scale() {
        assert!((just_noticeable() - 0.1).abs() < 0.005, "{}", just_noticeable());
    }
}
