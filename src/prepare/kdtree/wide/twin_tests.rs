//! The kernels against their twin in plain code.

use super::super::block::{self, Block, words_of};
use super::super::bounds::Bounds;
use super::super::slab::SlabRay;
use super::super::split::mix;
use super::kernel::{BoxRay, Kernel};
use super::node::{WIDTH, WideNode};
use super::scalar::Scalar;
use super::stack::{Stack, Waiting};
use crate::math::triangle::ShearedRay;
use crate::math::{Placement, Ray};
use crate::prepare::kdtree::Triangles;
use glam::Vec3;

pub(super) struct Random(pub u64);

impl Random {
    pub fn unit(&mut self) -> f32 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        (mix(self.0) >> 40) as f32 / 16_777_216.0
    }

    pub fn point(&mut self) -> Vec3 {
        Vec3::new(self.unit(), self.unit(), self.unit())
    }

    pub fn ray(&mut self, i: usize) -> Ray {
        let mut dir = self.point() - self.point();
        if i.is_multiple_of(7) {
            dir[i % 3] = 0.0;
        }
        Ray { origin: self.point() * 3.0 - 1.0, dir, t_max: f32::INFINITY }
    }
}

/// Sixteen boxes side by side along x, in an order that the kernels must permute.
pub(super) fn node(random: &mut Random) -> WideNode {
    let mut node = WideNode::empty();
    node.count = 13;
    node.children = std::array::from_fn(|slot| slot as u32 + 100);
    node.leaf_base = 7;
    for slot in 0..13 {
        let (lo, size) = (random.point(), random.point() * 0.3);
        node.set_bounds(slot, &Bounds::new(lo.to_array(), (lo + size).to_array()));
    }
    let backwards = (0..WIDTH as u64).fold(0, |order, slot| order << 4 | slot);
    node.orders = [0xfedc_ba98_7654_3210, backwards, 0xefcd_ab89_6745_2301, 0xfedc_ba98_3210_7654];
    node
}

/// Triangles, such as a strip, some of which share corners.
pub(super) struct Strip(pub Vec<[Vec3; 3]>);

impl Triangles for Strip {
    fn len(&self) -> usize {
        self.0.len()
    }

    fn vertices(&self, triangle: u32) -> [Vec3; 3] {
        self.0[triangle as usize]
    }
}

/// Distances equal to rounding: a fused operation rounds once less.
fn close(a: f32, b: f32) -> bool {
    (a - b).abs() <= 1e-5 * (1.0 + a.abs())
}

/// How many triangles are tested in vain.
fn check(kernel: impl Kernel) -> u32 {
    let mut random = Random(3);
    let mut vain = 0;
    for i in 0..2000 {
        let (node, ray) = (node(&mut random), random.ray(i));
        let mut boxes = BoxRay::default();
        boxes.set(&SlabRay::new(&ray));
        let limit = if i.is_multiple_of(3) { 0.5 } else { f32::INFINITY };
        let opened = |open: &mut dyn FnMut(&mut Stack)| {
            Stack::with(|stack| {
                open(stack);
                std::iter::from_fn(|| Some(stack.pop()).filter(|top| !top.enter.is_nan())).collect::<Vec<Waiting>>()
            })
        };
        let expected = opened(&mut |stack| Scalar.open(&boxes, &node, limit, stack));
        let found = opened(&mut |stack| kernel.open(&boxes, &node, limit, stack));
        // Boxes that are entered just where the ray ends may be on one list alone.
        let certain = |entries: &[Waiting]| -> Vec<Waiting> {
            entries.iter().copied().filter(|w| !close(w.enter, limit)).collect()
        };
        let words: Vec<u32> = found.iter().map(|child| child.word).collect();
        let (expected, found) = (certain(&expected), certain(&found));
        assert_eq!(expected.len(), found.len(), "ray {i}");
        for (plain, fast) in expected.iter().zip(&found) {
            assert_eq!((plain.word, plain.leaf_base), (fast.word, fast.leaf_base), "ray {i}");
            assert!(close(plain.enter, fast.enter), "ray {i}: {} {}", plain.enter, fast.enter);
        }
        // The first child by itself, then the others; and all of them in any order.
        let first = |open: &mut dyn FnMut(&mut Stack) -> Option<u32>| -> Vec<u32> {
            Stack::with(|stack| {
                let first = open(stack);
                let others = std::iter::from_fn(|| Some(stack.pop()).filter(|top| top.enter <= limit));
                first.into_iter().chain(others.map(|child| child.word)).collect()
            })
        };
        assert_eq!(first(&mut |stack| kernel.open_first(&boxes, &node, limit, stack)), words);
        let mut any = first(&mut |stack| kernel.open_any(&boxes, &node, limit, stack));
        any.sort_unstable();
        let mut sorted = words;
        sorted.sort_unstable();
        assert_eq!(any, sorted);

        let len = 1 + i % 16;
        // Neighbours share two corners, or one: then there are up to 31 different ones.
        let step = 1 + (i / 16) % 2;
        let points: Vec<Vec3> = (0..step * len + 2).map(|_| random.point()).collect();
        let strip = Strip(points.windows(3).step_by(step).map(|w| [w[0], w[1], w[2]]).collect());
        let ids: Vec<u32> = (0..len as u32).collect();
        for (pool, indices) in [(0, [[0; 16]; 3]), block::pool(&ids, &strip, block::POOL)] {
            let mut words = vec![0; words_of(len, pool)];
            block::write(&mut words, &ids, pool, &indices, &strip);
            words.resize(words.len() + 64, u32::MAX);
            let block = Block { len, pool, words: &words };
            let target = strip.0[i % len].iter().sum::<Vec3>() / 3.0;
            let sheared = ShearedRay::new(&Ray { dir: target - ray.origin, ..ray });
            let barred = (i % 31) as u32;
            // Up to no end, and to exactly where a triangle is met.
            let hit = sheared.meet(strip.0[i % len].map(|v| v.to_array()), 0).map_or(1.0, |hit| hit.t);
            for end in [f32::INFINITY, 1e30, hit, 0.5 * hit] {
                let met = Scalar.candidates(&sheared, &block, barred, end);
                let candidates = kernel.candidates(&sheared, &block, barred, end);
                assert_eq!(met & !candidates, 0, "a triangle is lost");
                assert!(candidates < 1 << len, "a lane behind the last triangle");
                vain += (candidates & !met).count_ones();
            }
        }
    }
    vain
}

/// Places come out bit for bit.
fn check_places(kernel: impl Kernel) {
    let mut random = Random(5);
    for _ in 0..200 {
        let mut row = || [0; 4].map(|_| f64::from(random.unit()) * 3.7 - 1.1 / 3.0);
        let placement = Placement { rows: [row(), row(), row()] };
        for stride in [3, 16, 21] {
            let from: Vec<u32> = (0..2 * stride + WIDTH).map(|_| (random.unit() * 9.0 - 4.0).to_bits()).collect();
            let (mut expected, mut placed) = ([0; 3 * WIDTH], [0; 3 * WIDTH]);
            Scalar.place(&placement, &from, stride, &mut expected);
            kernel.place(&placement, &from, stride, &mut placed);
            assert_eq!(placed, expected);
        }
    }
}

#[cfg(target_arch = "x86_64")]
#[test]
fn avx2_does_what_plain_code_does() {
    match super::avx2::Avx2::new() {
        Some(kernel) => {
            assert!(check(kernel) < 20, "next to nothing is tested in vain");
            check_places(kernel);
        }
        None => println!("skipped: no AVX2 on this machine"),
    }
}

#[cfg(target_arch = "x86_64")]
#[test]
fn avx512_does_what_plain_code_does() {
    match super::avx512::Avx512::new() {
        Some(kernel) => {
            assert!(check(kernel) < 20, "next to nothing is tested in vain");
            check_places(kernel);
        }
        None => println!("skipped: no AVX-512 on this machine"),
    }
}
