//! Adaptive sampling changes where samples go, and nothing else.

use crate::passes::room;
use kiln::Control;
use kiln::accuracy::{Display, Progressive};
use kiln::film::Film;
use kiln::integrate::View;
use kiln::prepare::PreparedScene;
use kiln::settings::{Adaptive, Goal, PictureSettings, RenderSettings};

fn rendered(scene: &PreparedScene, view: &View, settings: &RenderSettings, goal: &Goal) -> Film {
    let display = Display::new(&PictureSettings::default(), 0.0);
    let mut progressive = Progressive::new(scene, view, settings, goal, display);
    progressive.run(&Control::default()).expect("not stopped");
    progressive.finish().film
}

#[test]
fn the_goal_does_not_matter_for_who_gets_samples() {
    let (scene, view) = room();
    let settings = RenderSettings { spp: 56, ..RenderSettings::default() };
    // Neither is ever reached: one looks at the error after each pass, the other begins with passes of one sample.
    let goals = [(None, None), (Some(1e-9), None), (None, Some(1e9))].map(|(error, time)| Goal { error, time });
    let [plain, accurate, timed] = goals.map(|goal| rendered(&scene, &view, &settings, &goal));
    assert!(plain == accurate && plain == timed);
    let counts: Vec<u32> = plain.pixels.iter().map(|p| p.samples()).collect();
    assert!(counts.iter().all(|n| n.is_power_of_two()) && counts.iter().any(|n| *n != counts[0]), "{counts:?}");
}

/// z of the difference between the mean pictures of many seeds, adaptive and even, summed over blocks of pixels.
#[test]
fn the_mean_of_many_adaptive_pictures_is_that_of_even_ones() {
    const SEEDS: u64 = 24;
    /// Two-sided significance of 0.001 shared by 25 blocks (Šidák).
    const LIMIT: f64 = 4.1;
    let (scene, view) = room();
    let blocks = |film: &Film| -> Vec<f64> {
        let (side, across) = (8, film.width as usize / 8 + 1);
        let mut sums = vec![0.0; across * across];
        for (k, pixel) in film.pixels.iter().enumerate() {
            let (x, y) = (k % film.width as usize, k / film.width as usize);
            sums[y / side * across + x / side] += pixel.mean()[..3].iter().sum::<f64>();
        }
        sums
    };
    let pictures = |adaptive: Adaptive, seeds: std::ops::Range<u64>| -> Vec<Vec<f64>> {
        let settings = |seed| RenderSettings { spp: 32, seed, adaptive, ..RenderSettings::default() };
        seeds.map(|seed| blocks(&rendered(&scene, &view, &settings(seed), &Goal::default()))).collect()
    };
    let (adaptive, even) = (pictures(Adaptive::Variance, 0..SEEDS), pictures(Adaptive::Off, SEEDS..2 * SEEDS));
    let statistics = |all: &[Vec<f64>], block: usize| {
        let n = all.len() as f64;
        let mean = all.iter().map(|p| p[block]).sum::<f64>() / n;
        let variance = all.iter().map(|p| (p[block] - mean).powi(2)).sum::<f64>() / (n - 1.0) / n;
        (mean, variance)
    };
    for block in 0..adaptive[0].len() {
        let ((a, va), (b, vb)) = (statistics(&adaptive, block), statistics(&even, block));
        assert!((a - b).abs() <= LIMIT * (va + vb).sqrt() + 1e-12, "block {block}: {a} and {b} ± {}", (va + vb).sqrt());
    }
}
