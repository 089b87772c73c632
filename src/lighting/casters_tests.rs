use super::*;
use crate::lanes::{AnyLanes, Floats, LANES, Lanes, Mask, V3, Work};
use crate::math::simd::SimdTier;
use crate::math::warp::cosine_hemisphere;
use crate::sampling::{hash_combine, unit_float};

/// A large body, a small one far away, one half below the horizon, one that the origin is within.
fn casters() -> Casters {
    let caster = |x, y, z, radius, boost| Caster { centre: Vec3::new(x, y, z), radius, boost };
    Casters::new(vec![
        caster(0.5, 0.2, 1.0, 0.6, 3.0),
        caster(-3.0, 1.0, 2.0, 0.2, 8.0),
        caster(1.5, -1.5, 0.1, 0.5, 5.0),
        caster(0.1, 0.0, 0.2, 0.4, 4.0),
    ])
}

fn numbers(i: u32) -> [f32; 3] {
    [0, 1, 2].map(|k| unit_float(hash_combine(i, k)))
}

/// Density of the surface's own directions in its shading frame, which is the world's here: by the cosine.
fn cosine(wi: Vec3) -> f32 {
    wi.z.max(0.0) * FRAC_1_PI
}

#[test]
fn the_mixture_has_the_density_that_weights_say() {
    // ∫ g = E[g(ω) ratio(ω) / p_bsdf(ω)] for any g on the hemisphere, most of all for those that live in one cone. Where a cone is below
    // the horizon there is nothing.
    let cones = casters().seen(Vec3::ZERO, Vec3::Z, 0.8).expect("something to aim at");
    let share = |wi: Vec3| 0.8 * cosine(wi) + 0.2 * 0.5 * FRAC_1_PI * f32::from(wi.z > 0.0);
    let n = 400_000;
    let axes = casters().all().iter().map(|c| c.centre.normalize()).collect::<Vec<_>>();
    let mut sums = vec![[0.0f64; 2]; axes.len() + 1];
    for i in 0..n {
        let [choice, u, v] = numbers(i);
        let wi = cones.sample([u, v]).unwrap_or_else(|[u, v]| {
            // Eight of ten of the surface's own by the cosine, the others uniform.
            if choice < 0.8 {
                return cosine_hemisphere([u, v]);
            }
            let (sin, cos) = libm::sincosf(TAU * u);
            Vec3::new((1.0 - v * v).sqrt() * cos, (1.0 - v * v).sqrt() * sin, v)
        });
        let pdf = share(wi);
        let weight = if pdf > 0.0 { f64::from(cones.ratio(wi, pdf) / pdf) } else { 0.0 };
        for (k, sum) in sums.iter_mut().enumerate() {
            // The whole hemisphere, and a lobe about each body.
            let g = axes.get(k).map_or(1.0, |axis| libm::pow(f64::from(wi.dot(*axis).max(0.0)), 20.0));
            sum[0] += g * weight;
            sum[1] += (g * weight) * (g * weight);
        }
    }
    for (k, [sum, squares]) in sums.into_iter().enumerate() {
        let mean = sum / f64::from(n);
        let error = ((squares / f64::from(n) - mean * mean) / f64::from(n)).sqrt();
        // The hemisphere, and ∫ cos²⁰ over the part of each lobe that is above the horizon, on a grid.
        let truth = axes.get(k).map_or(2.0 * std::f64::consts::PI, |axis| lobe(*axis));
        assert!((mean - truth).abs() < 4.0 * error && error < 0.01 * truth, "{k}: {mean} ± {error}, {truth}");
    }
}

/// ∫ max(0, ω·axis)²⁰ over the upper hemisphere, by a grid that is uniform in solid angle.
fn lobe(axis: Vec3) -> f64 {
    let (heights, turns) = (1000, 2000);
    let mut sum = 0.0;
    for i in 0..heights {
        let z = (f64::from(i) + 0.5) / f64::from(heights);
        for j in 0..turns {
            let phi = (f64::from(j) + 0.5) / f64::from(turns) * std::f64::consts::TAU;
            let (radius, (sin, cos)) = ((1.0 - z * z).sqrt(), libm::sincos(phi));
            let wi = glam::DVec3::new(radius * cos, radius * sin, z);
            sum += libm::pow(wi.dot(axis.as_dvec3()).max(0.0), 20.0);
        }
    }
    sum * std::f64::consts::TAU / f64::from(heights * turns)
}

#[test]
fn no_weight_grows_beyond_what_is_aimed() {
    for i in 0..2000 {
        let point = Vec3::from(numbers(i).map(|x| 4.0 * x - 2.0));
        let Some(cones) = casters().seen(point, Vec3::Z, 1.0) else { continue };
        assert!(cones.whole() <= 1.0 + MOST_AIMED + 1e-6);
        let ratio = cones.ratio(Vec3::from(numbers(i + 5000)).normalize(), 0.1);
        assert!(ratio > 0.0 && ratio <= cones.whole() * (1.0 + 1e-6), "{ratio}");
    }
}

#[test]
fn nothing_is_aimed_from_within_a_body_or_away_from_it() {
    let one = Casters::new(vec![Caster { centre: Vec3::ZERO, radius: 1.0, boost: 5.0 }]);
    assert!(one.seen(Vec3::new(0.5, 0.5, 0.5), Vec3::Z, 1.0).is_none());
    assert!(one.seen(Vec3::new(0.0, 0.0, 3.0), Vec3::Z, 1.0).is_none());
    assert!(one.seen(Vec3::ZERO, Vec3::Z, 1.0).is_none());
    assert!(one.seen(Vec3::new(0.0, 0.0, -3.0), Vec3::Z, 0.0).is_none());
    assert!(one.seen(Vec3::new(0.0, 0.0, -3.0), Vec3::Z, 1.0).is_some());
}

/// What sixteen points say, and what each says alone.
struct Both(u32);

impl Work for Both {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(self, l: L) {
        let casters = casters();
        let points: [Vec3; LANES] =
            std::array::from_fn(|i| Vec3::from(numbers(self.0 * 99 + i as u32).map(|x| 3.0 * x - 1.5)));
        let of = |f: &dyn Fn(usize) -> f32| l.load(&std::array::from_fn(f));
        let column = |c: usize| of(&|i| points[i][c]);
        let u = |k: usize| of(&|i| numbers(self.0 * 77 + i as u32 + 31)[k]);
        let normal = V3::new(l.splat(0.0), l.splat(0.6), l.splat(0.8));
        let cones = casters.seen_lanes(l, V3::new(column(0), column(1), column(2)), normal, l.splat(0.7));
        let (chosen, wi, rest) = cones.sample(l, [u(0), u(1)]);
        let rest = rest[0].array();
        let ratio = cones.ratio(l, wi, l.splat(0.2)).array();
        let (there, whole) = (cones.there(l).bits(), cones.whole().array());
        for (i, point) in points.into_iter().enumerate() {
            let alone = casters.seen(point, Vec3::new(0.0, 0.6, 0.8), 0.7);
            assert_eq!(alone.is_some(), there >> i & 1 != 0);
            let Some(alone) = alone else { continue };
            let [v, w, _] = numbers(self.0 * 77 + i as u32 + 31);
            let own = alone.sample([v, w]);
            assert_eq!(own.is_ok(), chosen.bits() >> i & 1 != 0);
            assert!((alone.whole() - whole[i]).abs() < 1e-5);
            match own {
                Ok(own) => {
                    let lane = Vec3::from(wi.lane(i));
                    assert!(own.distance(lane) < 1e-4 && (lane.length() - 1.0).abs() < 1e-5, "{own} {lane}");
                    assert!((alone.ratio(lane, 0.2) - ratio[i]).abs() < 1e-4);
                }
                Err([first, second]) => {
                    assert!((0.0..1.0).contains(&first) && (first - rest[i]).abs() < 1e-5 && second == w);
                }
            }
        }
    }
}

#[test]
fn lanes_say_the_same() {
    for tier in SimdTier::ALL {
        (0..60).for_each(|k| AnyLanes::new(tier).run(Both(k)));
    }
}
