use super::*;
use crate::lanes::{AnyLanes, Floats, LANES, Lanes, V3, Words, Work};
use crate::lighting::clusters_lanes::{LightRoom, ReceiverLanes};
use crate::math::simd::SimdTier;
use crate::sampling::{hash_combine, unit_float};

fn number(i: u32, k: u32) -> f32 {
    unit_float(hash_combine(i, k)) * 2.0 - 1.0
}

fn vector(i: u32, k: u32) -> Vec3 {
    Vec3::new(number(i, k), number(i, k + 1), number(i, k + 2))
}

fn emitters(n: u32) -> Vec<EmitterBounds> {
    let place = |i| vector(i, 0);
    let triangle = |i| {
        let p = place(i);
        let edge = |k| vector(i, k) * 0.05;
        let corners = [p, p + edge(3), p + edge(6)];
        let axis = edge(3).cross(edge(6)).normalize();
        let power = libm::expf(4.0 * number(i, 9));
        EmitterBounds { power, ..EmitterBounds::triangle(corners, axis, i % 5 == 0) }
    };
    let other = |i: u32| match i % 3 {
        0 => EmitterBounds::cone(place(i), vector(i, 20).normalize(), 0.6),
        _ => EmitterBounds::point(place(i)),
    };
    (0..n).map(|i| if i % 7 == 0 { other(i / 7) } else { triangle(i) }).collect()
}

fn receiver(k: u32) -> Receiver {
    Receiver { point: vector(k, 100) * 1.3, normal: vector(k, 103).normalize(), both_sides: k % 2 == 1 }
}

#[test]
fn stated_probabilities_are_those_of_the_choice() {
    for n in [1, 2, 3, 50, 400, 3000] {
        let clusters = Clusters::new(&emitters(n));
        for k in 0..10 {
            let receiver = receiver(k);
            let all: Vec<f64> = (0..n).map(|i| f64::from(clusters.probability(&receiver, i))).collect();
            let tries = 1 << 14;
            let (mut counts, mut found) = (vec![0u32; n as usize], 0);
            for j in 0..tries {
                let Some(c) = clusters.sample(&receiver, (j as f32 + 0.5) / tries as f32) else { continue };
                found += 1;
                counts[c.emitter as usize] += 1;
                assert!((0.0..1.0).contains(&c.again));
                let p = clusters.probability(&receiver, c.emitter);
                assert!((c.probability - p).abs() <= 1e-5 * p, "{} and {p}", c.probability);
            }
            // Bounds are generous, so a choice may end where nothing contributes: what is missing to 1.
            let (sum, share) = (all.iter().sum::<f64>(), f64::from(found) / f64::from(tries));
            assert!((share - sum).abs() < 0.02 && sum < 1.0 + 1e-4, "{n}: {share} and {sum}");
            // Numbers at equal distances hit an interval as often as it is long, give or take one for each level.
            for (i, (count, p)) in counts.iter().zip(&all).enumerate() {
                let expected = p * f64::from(tries);
                assert!((f64::from(*count) - expected).abs() < 4.0 + 0.01 * expected, "{i}: {count}, {expected}");
            }
        }
    }
}

/// An emitter that can light the receiver must never have probability zero.
#[test]
fn nothing_that_contributes_is_left_out() {
    let all = emitters(900);
    let clusters = Clusters::new(&all);
    let mut lit = 0;
    for k in 0..50 {
        let receiver = Receiver { both_sides: false, ..receiver(k) };
        for (i, e) in all.iter().enumerate() {
            let to = e.center() - receiver.point;
            let cosine = -e.axis.dot(to.normalize());
            let emits = if e.two_sided {
                true
            } else {
                cosine > e.cos_spread.min(0.999) || e.cos_spread == 1.0 && cosine > 0.0
            };
            if emits && to.dot(receiver.normal) > 0.0 {
                lit += 1;
                assert!(clusters.probability(&receiver, i as u32) > 0.0, "receiver {k}, emitter {i}");
            }
        }
    }
    assert!(lit > 3000);
}

#[test]
fn many_identical_emitters_do_not_make_the_tree_deep() {
    let same = vec![EmitterBounds::point(Vec3::ONE); 5000];
    let clusters = Clusters::new(&same);
    let receiver = Receiver { point: Vec3::new(0.0, 0.0, 0.5), normal: Vec3::Z, both_sides: false };
    for i in [0, 17, 4999] {
        assert!((clusters.probability(&receiver, i) * 5000.0 - 1.0).abs() < 0.01);
    }
}

#[test]
fn nothing_overflows_at_an_emitter() {
    let all = [EmitterBounds::point(Vec3::ZERO), EmitterBounds { power: 1e6, ..EmitterBounds::point(Vec3::X) }];
    let clusters = Clusters::new(&all);
    for point in [Vec3::ZERO, Vec3::new(0.0, 0.0, -1e-12), Vec3::new(1.0, 0.0, -1e-30)] {
        let receiver = Receiver { point, normal: Vec3::Z, both_sides: true };
        for k in 0..16 {
            let chosen = clusters.sample(&receiver, k as f32 / 16.0);
            assert!(chosen.is_none_or(|c| c.probability > 0.0 && c.probability <= 1.0), "{chosen:?}");
        }
    }
}

/// Choices of many receivers, sixteen at a time.
struct Choices<'a>(&'a Clusters);

impl Work for Choices<'_> {
    type Output = Vec<[(u32, f32, f32); LANES]>;

    #[inline(always)]
    fn run<L: Lanes>(self, l: L) -> Self::Output {
        let Self(clusters) = self;
        let (mut out, mut room) = (Vec::new(), LightRoom::default());
        for group in 0..12 {
            let places: [Receiver; LANES] = std::array::from_fn(|i| receiver(group * 16 + i as u32));
            let lanes = |f: &dyn Fn(&Receiver) -> f32| l.load(&std::array::from_fn(|i| f(&places[i])));
            let vector =
                |f: &dyn Fn(&Receiver) -> Vec3| V3::new(lanes(&|r| f(r).x), lanes(&|r| f(r).y), lanes(&|r| f(r).z));
            let side = lanes(&|r| if r.both_sides { -1.0 } else { 1.0 });
            let receiver = ReceiverLanes::<L> { point: vector(&|r| r.point), normal: vector(&|r| r.normal), side };
            let u = l.load(&std::array::from_fn(|i| unit_float(hash_combine(group, 7 * i as u32))));
            let chosen = clusters.sample_lanes(l, &receiver, l.first(16), u, &mut room);
            let (emitter, probability, again) =
                (chosen.emitter.array(), chosen.probability.array(), chosen.again.array());
            out.push(std::array::from_fn(|i| (emitter[i], probability[i], again[i])));
        }
        out
    }
}

#[test]
fn lanes_choose_as_one_by_one() {
    for n in [1, 5, 128, 700, 3000] {
        let clusters = Clusters::new(&emitters(n));
        let plain = AnyLanes::new(SimdTier::Scalar).run(Choices(&clusters));
        for tier in SimdTier::ALL {
            assert_eq!(plain, AnyLanes::new(tier).run(Choices(&clusters)), "{tier}");
        }
        let mut none = 0;
        for (group, lanes) in plain.iter().enumerate() {
            for (i, (emitter, probability, again)) in lanes.iter().enumerate() {
                let receiver = receiver(group as u32 * 16 + i as u32);
                let u = unit_float(hash_combine(group as u32, 7 * i as u32));
                let one = clusters.sample(&receiver, u);
                match one {
                    Some(c) => assert_eq!((c.emitter, c.probability, c.again), (*emitter, *probability, *again)),
                    None => assert_eq!(*probability, 0.0),
                }
                none += u32::from(one.is_none());
            }
        }
        assert!(none < 190, "{n}: {none}");
    }
}
