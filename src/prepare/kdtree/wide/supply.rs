//! The rays of a batch made ready for a stream, sixteen at a time: their reciprocals and shears are computed in lanes, and rays
//! that pass by all children of the root never come to the stream.
//!
//! All numbers are, bit for bit, those of [`SlabRay::set`](super::super::slab::SlabRay::set) and
//! [`ShearedRay::new`](crate::math::triangle::ShearedRay::new); whether a ray enters a box is what the kernels say.

use super::super::batch::RayBatch;
use super::super::slab::{self, GROWTH};
use super::node::WideNode;
use super::packet_lanes::column;
use crate::lanes::{AnyLanes, Floats, LANES, Lanes, Mask, V3, Words, Work};
use crate::math::Hit;

/// Rays that are made ready at a time.
const MOST: usize = 4 * LANES;
/// Room for them, and for what compressed vectors write behind their ends.
const ROOM: usize = MOST + LANES;
/// Rays by which a batch is judged: whether it pays to look who passes by everything.
const SAMPLE: usize = 2 * MOST;
/// It does from this share of the sample on, one in so many.
const PAYS: usize = 8;

/// What a stream wants to know of a ray.
#[derive(Clone, Copy, Debug)]
pub struct ReadyRay {
    /// Its number in the batch.
    pub ray: usize,
    /// Reciprocals of its direction.
    pub inv: [f32; 3],
    /// See [`ShearedRay`](crate::math::triangle::ShearedRay).
    pub shear: [f32; 2],
    /// Bits for directions that are negative along x, y, z.
    pub octant: usize,
    /// The axis along which the direction is longest.
    pub along: usize,
    /// Whether it is of usual length and parallel to no axis: else all but its number means nothing.
    pub plain: bool,
}

/// Rays side by side.
struct Ready {
    /// Reciprocals of the directions, and shears.
    floats: [[f32; ROOM]; 5],
    /// Octants, from bit 3 on the longest axes, and at bit 5 whether a ray is plain.
    kinds: [u32; ROOM],
    numbers: [u32; ROOM],
    len: usize,
    /// Rays that pass by everything.
    missed: [u32; ROOM],
    misses: usize,
}

/// Hands out the rays of a batch.
pub struct Supply<'a> {
    lanes: AnyLanes,
    root: &'a WideNode,
    rays: &'a RayBatch<'a>,
    /// Rays that were made ready so far, or were seen to miss everything.
    done: usize,
    /// Of the ready ones, the next that is handed out.
    next: usize,
    ready: Ready,
    /// Whether it is worth while to look who passes by everything.
    looks: bool,
    /// How many did among those that were looked at.
    missed: usize,
}

impl<'a> Supply<'a> {
    /// Of all rays of a batch.
    pub fn new(lanes: AnyLanes, root: &'a WideNode, rays: &'a RayBatch<'a>) -> Self {
        let ready = Ready {
            floats: [[0.0; ROOM]; 5],
            kinds: [0; ROOM],
            numbers: [0; ROOM],
            len: 0,
            missed: [0; ROOM],
            misses: 0,
        };
        Self { lanes, root, rays, done: 0, next: 0, ready, looks: true, missed: 0 }
    }

    /// The next ray; `missed` is told of those before it that meet nothing.
    #[inline(always)]
    pub fn next(&mut self, missed: &mut impl FnMut(usize, Option<Hit>)) -> Option<ReadyRay> {
        while self.next == self.ready.len {
            if self.done == self.rays.len() {
                return None;
            }
            self.refill();
            for &ray in &self.ready.missed[..self.ready.misses] {
                missed(ray as usize, None);
            }
        }
        let at = self.next;
        self.next += 1;
        let (ready, kind) = (&self.ready, self.ready.kinds[at]);
        Some(ReadyRay {
            ray: ready.numbers[at] as usize,
            inv: [ready.floats[0][at], ready.floats[1][at], ready.floats[2][at]],
            shear: [ready.floats[3][at], ready.floats[4][at]],
            octant: (kind & 7) as usize,
            along: (kind >> 3 & 3) as usize,
            plain: kind >> 5 != 0,
        })
    }

    #[inline(never)]
    fn refill(&mut self) {
        let to = (self.done + MOST).min(self.rays.len());
        let Self { lanes, root, rays, done, ready, .. } = self;
        let of = (*done, to);
        if self.looks {
            lanes.run(Readying::<true> { root, rays, of, ready });
        } else {
            lanes.run(Readying::<false> { root, rays, of, ready });
        }
        (self.next, self.done) = (0, to);
        self.missed += self.ready.misses;
        self.looks &= self.done < SAMPLE || self.missed * PAYS >= self.done;
    }
}

/// Makes some rays ready; with `LOOKS`, only those that enter a child of the root.
struct Readying<'a, const LOOKS: bool> {
    root: &'a WideNode,
    rays: &'a RayBatch<'a>,
    /// The first of them, and the one behind the last.
    of: (usize, usize),
    ready: &'a mut Ready,
}

impl<const LOOKS: bool> Work for Readying<'_, LOOKS> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(self, l: L) {
        let Self { root, rays, of: (from, to), ready } = self;
        (ready.len, ready.misses) = (0, 0);
        let (zero, one) = (l.splat(0.0), l.splat(1.0));
        for first in (from..to).step_by(LANES) {
            let real = l.first(to - first);
            let [dx, dy, dz] = rays.dir;
            let dir = V3::new(column(l, dx, first), column(l, dy, first), column(l, dz, first));
            let inv = V3::new(one / dir.x, one / dir.y, one / dir.z);
            let (a, b, c) = (dir.x.abs(), dir.y.abs(), dir.z.abs());
            let (longest, shortest) = (a.max(b).max(c), a.min(b).min(c));
            let [least, most] = slab::PLAIN;
            let plain = longest.ge(l.splat(least)) & longest.le(l.splat(most)) & shortest.ge(l.splat(slab::PARALLEL));
            let negative = [dir.x.lt(zero), dir.y.lt(zero), dir.z.lt(zero)];
            let mut goes = real;
            if LOOKS {
                goes = goes & (!plain | enters(l, root, rays, first, inv, negative));
                let missed: &mut [u32; LANES] = slots(&mut ready.missed, ready.misses);
                (l.lane_numbers() + first as u32).compress(real & !goes).store(missed);
                ready.misses += (real & !goes).count();
            }
            let along_x = b.le(a) & c.le(a);
            let along_y = !along_x & c.le(b);
            let x = L::F::select(along_x, dir.y, L::F::select(along_y, dir.z, dir.x));
            let y = L::F::select(along_x, dir.z, L::F::select(along_y, dir.x, dir.y));
            let z = L::F::select(along_x, dir.x, L::F::select(along_y, dir.y, dir.z));
            let bit = |mask: L::M, bit: u32| L::U::select(mask, l.word(bit), l.word(0));
            let axis = L::U::select(along_x, l.word(0), L::U::select(along_y, l.word(1 << 3), l.word(2 << 3)));
            let kind = bit(negative[0], 1) | bit(negative[1], 2) | bit(negative[2], 4) | bit(plain, 1 << 5) | axis;
            let at = ready.len;
            inv.x.compress(goes).store(slots(&mut ready.floats[0], at));
            inv.y.compress(goes).store(slots(&mut ready.floats[1], at));
            inv.z.compress(goes).store(slots(&mut ready.floats[2], at));
            (x / z).compress(goes).store(slots(&mut ready.floats[3], at));
            (y / z).compress(goes).store(slots(&mut ready.floats[4], at));
            kind.compress(goes).store(slots(&mut ready.kinds, at));
            (l.lane_numbers() + first as u32).compress(goes).store(slots(&mut ready.numbers, at));
            ready.len += goes.count();
        }
    }
}

#[inline(always)]
fn slots<T>(row: &mut [T; ROOM], at: usize) -> &mut [T; LANES] {
    (&mut row[at..at + LANES]).try_into().expect("sixteen")
}

/// Which of sixteen plain rays enter any child of a node.
#[inline(always)]
fn enters<L: Lanes>(l: L, node: &WideNode, rays: &RayBatch, first: usize, inv: V3<L::F>, negative: [L::M; 3]) -> L::M {
    let [ox, oy, oz] = rays.origin;
    let origin = [column(l, ox, first), column(l, oy, first), column(l, oz, first)];
    let inv = [inv.x, inv.y, inv.z];
    let limit = column(l, rays.t_max, first) * GROWTH + f32::MIN_POSITIVE;
    let mut any = l.mask(0);
    for slot in 0..node.count as usize {
        let (mut enter, mut leave) = (l.splat(0.0), l.splat(f32::INFINITY));
        for axis in 0..3 {
            let (lo, hi) = (l.splat(node.planes[axis][slot]), l.splat(node.planes[axis + 3][slot]));
            let near = L::F::select(negative[axis], hi, lo);
            let far = L::F::select(negative[axis], lo, hi);
            enter = ((near - origin[axis]) * inv[axis]).max(enter);
            leave = ((far - origin[axis]) * inv[axis]).min(leave);
        }
        any = any | enter.le(leave * GROWTH) & enter.le(limit);
    }
    any
}

#[cfg(test)]
mod tests {
    use super::super::kernel::{BoxRay, Kernel};
    use super::super::scalar::Scalar;
    use super::super::stack::Stack;
    use super::super::twin_tests::{Random, node};
    use super::*;
    use crate::math::Ray;
    use crate::math::simd::SimdTier;
    use crate::math::triangle::ShearedRay;
    use crate::prepare::kdtree::slab::SlabRay;
    use glam::Vec3;

    /// Whether a kernel says that a ray enters a child of a node.
    fn enters_one(node: &WideNode, ray: &Ray) -> bool {
        let (slab, mut boxes) = (SlabRay::new(ray), BoxRay::default());
        boxes.set(&slab);
        Stack::with(|stack| {
            Scalar.open(&boxes, node, slab.scaled(ray.t_max), stack);
            !stack.top().enter.is_nan()
        })
    }

    /// Rays by their numbers as the stream gets them, and which it never sees.
    fn supplied(tier: SimdTier, node: &WideNode, batch: &RayBatch) -> (Vec<ReadyRay>, Vec<usize>) {
        let (mut supply, mut ready, mut missed) = (Supply::new(AnyLanes::new(tier), node, batch), vec![], vec![]);
        let mut note = |ray, hit: Option<Hit>| {
            assert_eq!(hit, None);
            missed.push(ray);
        };
        while let Some(ray) = supply.next(&mut note) {
            ready.push(ray);
        }
        (ready, missed)
    }

    #[test]
    fn rays_are_those_that_are_made_one_by_one_and_only_those_that_enter_nothing_are_left_out() {
        let mut random = Random(5);
        for (count, far) in [(0, 0), (1, 0), (15, 1), (300, 2), (1000, 2), (700, 40)] {
            let node = node(&mut random);
            // In the last batch hardly any ray passes by, so that nobody looks any more.
            let aimed = far == 40;
            let rays: Vec<Ray> = (0..count)
                .map(|i| {
                    let mut ray = random.ray(i);
                    if aimed && i % 20 == 0 {
                        (ray.origin, ray.dir) = (Vec3::splat(10.0), Vec3::new(1.0, 2.0, 3.0));
                    } else if aimed {
                        let middle =
                            [0, 1, 2].map(|axis| 0.5 * (node.planes[axis][i % 13] + node.planes[axis + 3][i % 13]));
                        ray.dir = Vec3::from(middle) - ray.origin;
                    } else if i % 3 < far {
                        ray.t_max = random.unit();
                    }
                    ray
                })
                .collect();
            let rows =
                |of: fn(&Ray) -> Vec3| [0, 1, 2].map(|axis| rays.iter().map(|ray| of(ray)[axis]).collect::<Vec<_>>());
            let (origin, dir) = (rows(|ray| ray.origin), rows(|ray| ray.dir));
            let t_max: Vec<f32> = rays.iter().map(|ray| ray.t_max).collect();
            let (origin, dir) = (origin.each_ref().map(|row| &row[..]), dir.each_ref().map(|row| &row[..]));
            let batch = RayBatch { origin, dir, t_max: &t_max, reaches: &[], leaves: &[] };
            for tier in SimdTier::ALL {
                let (ready, missed) = supplied(tier, &node, &batch);
                let mut numbers: Vec<usize> =
                    ready.iter().map(|ready| ready.ray).chain(missed.iter().copied()).collect();
                numbers.sort_unstable();
                assert_eq!(numbers, (0..count).collect::<Vec<_>>(), "each once");
                // Where less than an eighth of the sample misses, nobody looks any more.
                let last = missed.iter().copied().max().unwrap_or(0);
                assert!(!aimed || last < SAMPLE, "{last} was looked at");
                assert!(missed.iter().all(|ray| !enters_one(&node, &rays[*ray])), "none is left out that enters");
                let miss = rays.iter().filter(|ray| slab::is_plain(ray) && !enters_one(&node, ray)).count();
                assert!(
                    if aimed { missed.len() < miss + 1 } else { missed.len() == miss },
                    "{} of {miss}",
                    missed.len()
                );
                for made in ready {
                    let ray = &rays[made.ray];
                    assert_eq!(made.plain, slab::is_plain(ray));
                    if made.plain {
                        let (slab, sheared) = (SlabRay::new(ray), ShearedRay::new(ray));
                        assert_eq!((made.inv, made.octant), (slab.inv, slab.octant));
                        assert_eq!((made.shear, made.along), ([sheared.shear_x, sheared.shear_y], sheared.axes[2]));
                    }
                }
            }
        }
    }
}
