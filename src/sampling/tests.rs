use super::*;

const KINDS: [SamplerKind; 4] = [SamplerKind::Sobol, SamplerKind::Pcg, SamplerKind::Lcg, SamplerKind::Xorshift32];

/// Pearson correlation of neighbouring pixels' numbers: a badly mixed address shows as streaks in the picture that no
/// error metric sees.
#[test]
fn neighbouring_pixels_are_uncorrelated() {
    let n = 128u32;
    for kind in KINDS {
        for purpose in [Purpose::Pixel, Purpose::LightPoint, Purpose::Lobe, Purpose::Coverage(3)] {
            let value = |x: u32, y: u32| PathSampler::new(kind, 1, [x, y], 0).get_1d(2, purpose) - 0.5;
            for (dx, dy) in [(1, 0), (0, 1), (1, 1), (2, 0), (16, 0), (0, 16)] {
                let mut sum = 0.0;
                for y in 0..n {
                    for x in 0..n {
                        sum += f64::from(value(x, y)) * f64::from(value(x + dx, y + dy));
                    }
                }
                let count = f64::from(n * n);
                let z = sum / count * 12.0 * count.sqrt();
                assert!(z.abs() < 4.5, "{kind:?} {purpose:?} ({dx},{dy}): z = {z}");
            }
        }
    }
}

#[test]
fn numbers_are_uniform_over_pixels_samples_vertices_and_purposes() {
    for kind in KINDS {
        let mut counts = [0u32; 64];
        let mut total = 0;
        for pixel in 0..64 {
            for sample in 0..64 {
                let mut sampler = PathSampler::new(kind, 9, [pixel % 8, pixel / 8], sample);
                for vertex in 0..4 {
                    let [a, b] = sampler.get_2d(vertex, Purpose::Direction);
                    assert!((0.0..1.0).contains(&a) && (0.0..1.0).contains(&b));
                    counts[(a * 8.0) as usize * 8 + (b * 8.0) as usize] += 1;
                    total += 1;
                }
            }
        }
        let expected = f64::from(total) / 64.0;
        let chi2: f64 = counts.iter().map(|c| (f64::from(*c) - expected) * (f64::from(*c) - expected) / expected).sum();
        // 63 degrees of freedom: 0.9999 quantile is 113; low-discrepancy points lie far below.
        assert!(chi2 < 113.0, "{kind:?}: chi² {chi2}");
    }
}

#[test]
fn addressed_samplers_do_not_depend_on_the_order_of_questions() {
    for kind in [SamplerKind::Sobol, SamplerKind::Pcg] {
        let mut a = PathSampler::new(kind, 5, [3, 4], 17);
        let mut b = a;
        let forward: Vec<_> = (0..5).map(|v| a.get_2d(v, Purpose::LightPoint)).collect();
        let mut backward: Vec<_> = (0..5).rev().map(|v| b.get_2d(v, Purpose::LightPoint)).collect();
        backward.reverse();
        assert_eq!(forward, backward);
    }
}

/// Replicates must be independent: the variance of their mean over many pixels is a quarter of one's.
#[test]
fn replicates_are_independent() {
    let (mut covariance, n) = (0.0, 20_000u32);
    for pixel in 0..n {
        let at = |sample| {
            f64::from(PathSampler::new(SamplerKind::Sobol, 2, [pixel, 0], sample).get_1d(0, Purpose::Lobe)) - 0.5
        };
        covariance += at(0) * at(1);
    }
    let z = covariance / f64::from(n) * 12.0 * f64::from(n).sqrt();
    assert!(z.abs() < 4.0, "z = {z}");
}

/// Two samples a vertex lie in both halves of the unit interval, and those of four paths in all its eighths.
#[test]
fn split_samples_of_all_paths_are_well_distributed_together() {
    for pixel in 0..50 {
        let mut eighths = 0u32;
        for sample in [0, 2, 4, 6] {
            let path = PathSampler::new(SamplerKind::Sobol, 4, [pixel, 7], sample);
            let [a, b] = [0, 1].map(|k| path.split(k, 2).get_1d(0, Purpose::LightChoice));
            assert!((a < 0.5) != (b < 0.5), "{a} and {b}");
            eighths |= 1 << (a * 8.0) as u32 | 1 << (b * 8.0) as u32;
        }
        assert_eq!(eighths, 0xFF, "pixel {pixel}");
    }
}

/// One of one is the path's own.
#[test]
fn samplers_in_sequence_go_on_behind_what_was_split() {
    for kind in KINDS {
        let mut whole = PathSampler::new(kind, 4, [3, 7], 5);
        let mut parts = whole;
        let expected = [0, 1].map(|vertex| whole.get_1d(vertex, Purpose::LightChoice));
        let got = [0, 1].map(|vertex| {
            let mut split = parts.split(0, 1);
            let number = split.get_1d(vertex, Purpose::LightChoice);
            parts.follow(&split);
            number
        });
        assert_eq!(expected, got, "{kind:?}");
    }
}
