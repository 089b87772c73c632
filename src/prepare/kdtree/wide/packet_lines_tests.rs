//! Bounds on what estimates tell, against the exact test: thousands of lines beside edges and corners, at many scales.

use super::super::block::{self, Block, words_of};
use super::super::split::mix;
use super::packet_lines::{Frame, LinesOfBlocks, surely_ahead};
use crate::lanes::{AnyLanes, Floats, LANES, Lanes, Mask, V3, Work};
use crate::math::Ray;
use crate::math::simd::SimdTier;
use crate::math::triangle::{ShearedRay, corners_of};
use crate::prepare::kdtree::Triangles;
use glam::Vec3;

struct Random(u64);

impl Random {
    fn unit(&mut self) -> f32 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        (mix(self.0) >> 40) as f32 / 16_777_216.0
    }

    fn point(&mut self) -> Vec3 {
        Vec3::new(self.unit(), self.unit(), self.unit()) - 0.5
    }
}

struct Soup(Vec<[Vec3; 3]>);

impl Triangles for Soup {
    fn len(&self) -> usize {
        self.0.len()
    }

    fn vertices(&self, triangle: u32) -> [Vec3; 3] {
        self.0[triangle as usize]
    }
}

/// Sixteen triangles near a place, of sizes down to a thousandth of the scale, and sixteen rays: most of them through a corner, a
/// point of an edge or beside it, some from a point of a triangle's plane.
fn scene(random: &mut Random, round: usize) -> (Soup, Vec<Ray>) {
    let scale = [1.0, 1e-6, 1e6, 1e-3][round % 4];
    let size = [1.0, 1e-1, 1e-3][round / 4 % 3];
    let place = random.point() * [0.0, 1.0, 300.0][round / 12 % 3];
    let triangles: Vec<[Vec3; 3]> = (0..LANES)
        .map(|i| {
            let at = place + random.point() * size * [4.0, 0.5][round % 2];
            let mut corners = [at, at + random.point() * size, at + random.point() * size];
            if i % 5 == 0 {
                // A needle.
                corners[2] = corners[0].lerp(corners[1], random.unit()) + random.point() * size * 1e-4;
            }
            corners.map(|corner| corner * scale)
        })
        .collect();
    let rays = (0..LANES)
        .map(|i| {
            let [a, b, c] = triangles[(i * 7) % LANES];
            let on_edge = a.lerp(b, random.unit());
            let target = match i % 4 {
                0 => a,
                1 => on_edge,
                2 => on_edge + random.point() * (size * scale * 1e-5),
                _ => on_edge.lerp(c, random.unit()),
            };
            let away = random.point() * scale * [0.01, 1.0, 30.0][i % 3];
            let beside = if i % 5 == 0 { random.point() * (scale * 1e-7) } else { away };
            let origin = target + beside;
            let dir = if i % 5 == 0 { random.point() } else { target - origin };
            Ray { origin, dir: dir.normalize() * [1.0, 1e-3, 1e3][i % 3], t_max: f32::INFINITY }
        })
        .collect();
    (Soup(triangles), rays)
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

struct Check;

impl Work for Check {
    type Output = Tally;

    #[inline(always)]
    fn run<L: Lanes>(self, l: L) -> Tally {
        let (mut random, mut tally) = (Random(11), Tally::default());
        for round in 0..3000 {
            let (soup, rays) = scene(&mut random, round);
            let ids: Vec<u32> = (0..LANES as u32).collect();
            let mut words = vec![0; words_of(LANES, 0)];
            block::write(&mut words, &ids, 0, &[[0; LANES]; 3], &soup);
            let mut kept = LinesOfBlocks::new(&[]);
            let lines = kept.of(l, &Block { len: LANES, pool: 0, words: &words });
            let column = |of: &dyn Fn(&Ray) -> f32| l.load(&std::array::from_fn(|i| of(&rays[i])));
            let origin = V3::new(column(&|r| r.origin.x), column(&|r| r.origin.y), column(&|r| r.origin.z));
            let dir = V3::new(column(&|r| r.dir.x), column(&|r| r.dir.y), column(&|r| r.dir.z));
            let mut frame = Frame::none(l);
            frame.turn_to(l, lines, origin, dir);
            let between = frame.between(l, lines, 0xFFFF);
            for i in 0..LANES {
                let ([low, high], certain) = frame.distance(l, lines, i);
                let ahead = surely_ahead(l, low).bits();
                let (low, high, certain) = (low.array(), high.array(), certain.bits());
                for (lane, ray) in rays.iter().enumerate() {
                    let hit = ShearedRay::new(ray).meet(corners_of(soup.0[i]), 0);
                    let is = |bits: u32| bits >> lane & 1 != 0;
                    let told = format!("round {round}, triangle {i}, ray {lane}: {hit:?}");
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
        tally
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
                let soup = Soup(vec![[Vec3::ZERO, Vec3::X * size, Vec3::Y * size]]);
                let mut words = vec![0; words_of(1, 0)];
                block::write(&mut words, &[0], 0, &[[0; LANES]; 3], &soup);
                let mut kept = LinesOfBlocks::new(&[]);
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
