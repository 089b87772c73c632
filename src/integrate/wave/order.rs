//! Paths in the order of their directions, so that neighbours go like ways.
//!
//! Where sixteen neighbours go through a tree as one packet, they meet fewer boxes and triangles so. After the first scattering the paths of a tile
//! begin near each other, and directions alone are an order worth having; later they begin anywhere, and it gains nothing
//! (scripts/runs/2026-11-23-quadrilaterals.md). What paths bring does not depend on their places.

use super::rows::Rows;
use super::{PATHS, path};
use crate::lanes::{Floats, LANES, Lanes, Words, Work};

/// Cells along each side of the square that directions are mapped to.
const SIDE: usize = 16;
const CELLS: usize = SIDE * SIDE;

/// Room to put paths in order.
pub(super) struct Order {
    other: Rows<{ path::FLOATS }, { path::WORDS }>,
    cells: Vec<u32>,
    order: Vec<u32>,
}

impl Default for Order {
    fn default() -> Self {
        Self { other: Rows::new(PATHS), cells: vec![0; PATHS + LANES], order: vec![0; PATHS + LANES] }
    }
}

/// Puts paths in order.
pub(super) struct Sort<'a> {
    pub order: &'a mut Order,
    pub paths: &'a mut Rows<{ path::FLOATS }, { path::WORDS }>,
}

impl Work for Sort<'_> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(self, l: L) {
        let Self { order: Order { other, cells, order }, paths } = self;
        let n = paths.len;
        for at in (0..n).step_by(LANES) {
            let cell = cell(l, paths.load_vector(l, path::DIR, at).components());
            cell.store((&mut cells[at..at + LANES]).try_into().expect("sixteen"));
        }
        // Counted, and then each put behind those of smaller cells and those before it in its own.
        let mut next = [0u32; CELLS + 1];
        cells[..n].iter().for_each(|cell| next[*cell as usize % CELLS + 1] += 1);
        (0..CELLS).for_each(|k| next[k + 1] += next[k]);
        for (i, cell) in cells[..n].iter().enumerate() {
            let place = &mut next[*cell as usize % CELLS];
            order[*place as usize] = i as u32;
            *place += 1;
        }
        other.take(l, paths, order);
        std::mem::swap(paths, other);
    }
}

/// The cells of directions of any length: on the octahedron unfolded to a square (Meyer et al. 2010, "On Floating-Point Normal Vectors"), in
/// Z-order, so that neighbours in number mostly are neighbours. Any cell for what has no direction.
#[inline(always)]
fn cell<L: Lanes>(l: L, [x, y, z]: [L::F; 3]) -> L::U {
    let (zero, one) = (l.splat(0.0), l.splat(1.0));
    let inv = one / (x.abs() + y.abs() + z.abs());
    let (u, v) = (x * inv, y * inv);
    let below = z.lt(zero);
    let (folded_u, folded_v) = ((one - v.abs()).copysign(u), (one - u.abs()).copysign(v));
    let (u, v) = (L::F::select(below, folded_u, u), L::F::select(below, folded_v, v));
    spread(along(l, u)) | spread(along(l, v)).shl::<1>()
}

/// The cell along a side for a number from -1 to 1.
#[inline(always)]
fn along<L: Lanes>(l: L, x: L::F) -> L::U {
    ((x + 1.0) * (0.5 * SIDE as f32)).max(l.splat(0.0)).truncate().min(l.word(SIDE as u32 - 1))
}

/// The lowest four bits, each followed by a zero.
#[inline(always)]
fn spread<U: Words>(x: U) -> U {
    let two = (x | x.shl::<2>()) & x.fill(0b11_0011);
    (two | two.shl::<1>()) & x.fill(0b101_0101)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lanes::AnyLanes;
    use crate::math::simd::SimdTier;
    use crate::sampling::{hash_combine, unit_float};
    use glam::Vec3;

    #[test]
    fn paths_are_all_still_there_and_neighbours_go_like_ways() {
        for n in [0, 1, 15, 16, 700, PATHS] {
            let number = |i: usize, k: u32| unit_float(hash_combine(i as u32, k)) * 2.0 - 1.0;
            for tier in SimdTier::ALL {
                let (mut paths, mut order) = (Rows::new(PATHS), Order::default());
                paths.len = n;
                for i in 0..n {
                    paths.set_vector(path::DIR, i, Vec3::new(number(i, 1), number(i, 2), number(i, 3)));
                    paths.set_float(path::SPREAD, i, i as f32);
                    paths.set_word(path::SLOT, i, i as u32);
                }
                let before: Vec<Vec3> = (0..n).map(|i| paths.vector(path::DIR, i)).collect();
                AnyLanes::new(tier).run(Sort { order: &mut order, paths: &mut paths });
                let mut slots = paths.words(path::SLOT).to_vec();
                for (i, slot) in slots.iter().enumerate() {
                    assert_eq!(paths.vector(path::DIR, i), before[*slot as usize]);
                    assert_eq!(paths.float(path::SPREAD, i), *slot as f32);
                }
                slots.sort_unstable();
                assert_eq!(slots, (0..n as u32).collect::<Vec<_>>());
                let spread = |dirs: &[Vec3]| {
                    let mean =
                        |some: &[Vec3]| some.iter().map(|d| d.normalize()).sum::<Vec3>().length() / some.len() as f32;
                    let groups = dirs.chunks_exact(LANES);
                    groups.clone().map(mean).sum::<f32>() / groups.len() as f32
                };
                if n == PATHS {
                    let after: Vec<Vec3> = (0..n).map(|i| paths.vector(path::DIR, i)).collect();
                    assert!(spread(&before) < 0.4 && spread(&after) > 0.95, "{} {}", spread(&before), spread(&after));
                }
            }
        }
    }
}
