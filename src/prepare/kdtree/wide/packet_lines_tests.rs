//! Bounds on what estimates tell, against the exact test: thousands of lines beside edges and corners, at many scales.

use super::super::block::{self, Block, words_of};
use super::super::bounds::Bounds;
use super::node::{WIDTH, WideNode};
use super::packet_kept::{KeptLines, TreeNumber};
use super::packet_lines::{Frame, Lines, surely_ahead};
use super::twin_tests::{Random, Strip};
use crate::lanes::{AnyLanes, Floats, LANES, Lanes, Mask, V3, Work};
use crate::math::Ray;
use crate::math::simd::SimdTier;
use crate::math::triangle::{ShearedRay, corners_of};
use glam::Vec3;
use std::slice;

/// A point within half a unit of the origin.
fn centred(random: &mut Random) -> Vec3 {
    random.point() - 0.5
}

/// Sixteen triangles near a place, of sizes down to a thousandth of the scale, and sixteen rays: most of them through a corner, a
/// point of an edge or beside it, some from a point of a triangle's plane.
fn scene(random: &mut Random, round: usize) -> (Strip, Vec<Ray>) {
    let scale = [1.0, 1e-6, 1e6, 1e-3][round % 4];
    let size = [1.0, 1e-1, 1e-3][round / 4 % 3];
    let place = centred(random) * [0.0, 1.0, 300.0][round / 12 % 3];
    let mut triangles: Vec<[Vec3; 3]> = (0..LANES)
        .map(|i| {
            let at = place + centred(random) * size * [4.0, 0.5][round % 2];
            let mut corners = [at, at + centred(random) * size, at + centred(random) * size];
            if i % 5 == 0 {
                // A needle.
                corners[2] = corners[0].lerp(corners[1], random.unit()) + centred(random) * size * 1e-4;
            }
            corners.map(|corner| corner * scale)
        })
        .collect();
    if round % 2 == 1 {
        // Pairs with an edge in common, which a block keeps in a pool.
        (1..LANES)
            .step_by(2)
            .for_each(|i| [triangles[i][0], triangles[i][1]] = [triangles[i - 1][2], triangles[i - 1][1]]);
    }
    let rays = (0..LANES)
        .map(|i| {
            let [a, b, c] = triangles[(i * 7) % LANES];
            let on_edge = a.lerp(b, random.unit());
            let target = match i % 4 {
                0 => a,
                1 => on_edge,
                2 => on_edge + centred(random) * (size * scale * 1e-5),
                _ => on_edge.lerp(c, random.unit()),
            };
            let away = centred(random) * scale * [0.01, 1.0, 30.0][i % 3];
            let beside = if i % 5 == 0 { centred(random) * (scale * 1e-7) } else { away };
            let origin = target + beside;
            let dir = if i % 5 == 0 { centred(random) } else { target - origin };
            Ray { origin, dir: dir.normalize() * [1.0, 1e-3, 1e3][i % 3], t_max: f32::INFINITY }
        })
        .collect();
    (Strip(triangles), rays)
}

/// What became of all that was asked.
#[derive(Default)]
struct Tally {
    met: usize,
    missed: usize,
    surely_met: usize,
    surely_missed: usize,
    /// The largest error of a distance, as a share of its bound.
    worst: f32,
}

/// A block of triangles, and rays about it.
struct Place {
    strip: Strip,
    rays: Vec<Ray>,
    words: Vec<u32>,
    len: usize,
    pool: usize,
}

impl Place {
    fn new(random: &mut Random, round: usize, len: usize) -> Self {
        let (strip, rays) = scene(random, round);
        let ids: Vec<u32> = (0..len as u32).collect();
        let (pool, indices) = block::pool(&ids, &strip, block::POOL);
        let mut words = vec![0; words_of(len, pool)];
        block::write(&mut words, &ids, pool, &indices, &strip);
        Self { strip, rays, words, len, pool }
    }

    /// Adds its box to a node.
    fn put_into(&self, node: &mut WideNode) {
        let corners = self.strip.0[..self.len].as_flattened();
        let low = corners.iter().copied().fold(Vec3::INFINITY, Vec3::min);
        let high = corners.iter().copied().fold(Vec3::NEG_INFINITY, Vec3::max);
        node.set_bounds(node.count as usize, &Bounds::new(low.to_array(), high.to_array()));
        node.count += 1;
    }
}

struct Check;

impl Work for Check {
    type Output = Tally;

    #[inline(always)]
    fn run<L: Lanes>(self, l: L) -> Tally {
        let (mut random, mut tallies) = (Random(11), [Tally::default(), Tally::default()]);
        for round in 0..250 {
            let places: Vec<Place> =
                (0..12).map(|i| Place::new(&mut random, round, 1 + (i * 7 + 15) % LANES)).collect();
            // Every other time as if all of them were a small tree.
            let small = round / 4 % 2 == 1;
            let mut root = WideNode::empty();
            places.iter().take(WIDTH).for_each(|place| place.put_into(&mut root));
            let mut kept = KeptLines::new(TreeNumber::next(), if small { slice::from_ref(&root) } else { &[] });
            // More blocks than are kept, and each of them again.
            for place in places.iter().chain(&places) {
                let block = Block { len: place.len, pool: place.pool, words: &place.words };
                check(l, place, kept.of(l, &block), &mut tallies[usize::from(small)]);
            }
        }
        let [own, _] = tallies;
        own
    }
}

/// What rays and triangles are, against what the lines say of them.
#[inline(always)]
fn check<L: Lanes>(l: L, place: &Place, lines: &Lines, tally: &mut Tally) {
    let Place { strip, rays, .. } = place;
    let column = |of: &dyn Fn(&Ray) -> f32| l.load(&std::array::from_fn(|i| of(&rays[i])));
    let origin = V3::new(column(&|r| r.origin.x), column(&|r| r.origin.y), column(&|r| r.origin.z));
    let dir = V3::new(column(&|r| r.dir.x), column(&|r| r.dir.y), column(&|r| r.dir.z));
    let mut frame = Frame::none(l);
    frame.turn_to(l, lines, origin, dir);
    let between = frame.between(l, lines, 0xFFFF);
    assert_eq!(lines.len(), place.len);
    for i in 0..lines.len() {
        let ([low, high], certain) = frame.distance(l, lines, i);
        let ahead = surely_ahead(l, low).bits();
        let (low, high, certain) = (low.array(), high.array(), certain.bits());
        for (lane, ray) in rays.iter().enumerate() {
            let hit = ShearedRay::new(ray).meet(corners_of(strip.0[i]), 0);
            let is = |bits: u32| bits >> lane & 1 != 0;
            let told = format!("triangle {i}, ray {lane}: {hit:?}");
            if let Some(hit) = hit {
                tally.met += 1;
                assert!(is(between.possible[i]), "{told} is lost");
                if is(certain) {
                    let (low, high) = (low[lane], high[lane]);
                    assert!(low <= hit.t && hit.t <= high, "{told} is not in {low} to {high}");
                    assert!(!is(ahead) || hit.t > 0.0, "{told} is behind");
                    let off = (hit.t - 0.5 * (low + high)).abs() / (0.5 * (high - low));
                    tally.worst = tally.worst.max(off);
                }
                tally.surely_met += usize::from(is(between.sure[i]) && is(certain));
            } else {
                tally.missed += 1;
                assert!(!(is(between.sure[i]) && is(certain)), "{told} is met");
                tally.surely_missed += usize::from(!is(between.possible[i]));
            }
        }
    }
}

#[test]
fn estimates_lose_nothing_and_claim_nothing_wrong() {
    for tier in [SimdTier::Scalar, SimdTier::Avx2, SimdTier::Avx512] {
        let Tally { met, missed, surely_met, surely_missed, worst } = AnyLanes::new(tier).run(Check);
        println!("{tier:?}: {surely_met} of {met} met, {surely_missed} of {missed} missed, distances within {worst}");
        // Most rays were aimed at edges and corners, where nothing is certain; elsewhere most must be.
        assert!(met > 10_000 && surely_met * 5 > met, "{surely_met} of {met} met");
        assert!(surely_missed * 10 > missed * 9, "{surely_missed} of {missed} missed");
    }
}

#[test]
fn what_may_overflow_is_not_certain() {
    struct Far;
    impl Work for Far {
        type Output = ();

        #[inline(always)]
        fn run<L: Lanes>(self, l: L) {
            for size in [1e12, 1e30, f32::MAX] {
                let strip = Strip(vec![[Vec3::ZERO, Vec3::X * size, Vec3::Y * size]]);
                let mut words = vec![0; words_of(1, 0)];
                block::write(&mut words, &[0], 0, &[[0; LANES]; 3], &strip);
                let mut kept = KeptLines::new(TreeNumber::next(), &[]);
                let lines = kept.of(l, &Block { len: 1, pool: 0, words: &words });
                let mut frame = Frame::none(l);
                let one = V3::splat(l.splat(1.0));
                frame.turn_to(l, lines, one * l.splat(size * 0.25), -one);
                let between = frame.between(l, lines, 0xFFFF);
                assert_eq!((between.possible[0], between.sure[0]), (0xFFFF, 0), "{size}");
                assert_eq!(frame.distance(l, lines, 0).1.bits(), 0, "{size}");
            }
        }
    }
    AnyLanes::new(SimdTier::Scalar).run(Far);
    AnyLanes::new(SimdTier::Avx512).run(Far);
}
