//! A cell's references, dealt to the sides of a plane.

use super::Triangles;
use super::bounds::{Bounds, Reference};
use super::references;
use super::split::{Cell, Plane, mix, sides};
use crate::lanes::{Lanes, Work};

/// References whose corners are looked up before they are cut: memory answers for all of them at once.
const AHEAD: usize = 16;

/// The two sides of a plane.
pub struct Sides {
    /// The plane.
    pub plane: Plane,
    /// Below it.
    pub left: Cell,
    /// Above it.
    pub right: Cell,
}

/// Deals `refs[base..]` to the sides of a plane: the left side stays in place, the right one goes to `right`, which is empty.
/// `None`, with the references as they were, when the plane gains nothing or costs more duplicates than the cell may have.
pub struct Deal<'a, T> {
    /// What is referred to.
    pub triangles: &'a T,
    /// The cell's references lie at the end.
    pub refs: &'a mut Vec<Reference>,
    /// Where they begin.
    pub base: usize,
    /// Where those of the right side go.
    pub right: &'a mut Vec<Reference>,
    /// The plane.
    pub plane: Plane,
    /// The cell.
    pub cell: &'a Cell,
}

// Nothing here is done in lanes by hand: the compiler uses the tier's instructions, and all of them find the same.
impl<T: Triangles> Work for Deal<'_, T> {
    type Output = Option<Sides>;

    #[inline(always)]
    fn run<L: Lanes>(self, _: L) -> Option<Sides> {
        let Self { triangles, refs, base, right, plane, cell } = self;
        let (counts, weights) = count(&refs[base..], plane);
        let [only_left, both, only_right] = weights;
        let gains = only_left + only_right > 0 && only_left + both > 0 && only_right + both > 0;
        if !gains || both > cell.budget {
            return None;
        }
        let begin_cut = counts[2] + 1;
        let kept = part(refs, base, right, counts, plane);
        let mut left_side = Side { bounds: Bounds::around(&refs[base..kept]), triangles: only_left };
        let mut right_side = Side { bounds: Bounds::around(&right[..counts[2]]), triangles: only_right };
        refs.truncate(kept);
        let mut len = counts[2];
        let end_cut = begin_cut + counts[1];
        let mut corners = [[[[0.0; 3]; 3]; 2]; AHEAD];
        for first in (begin_cut..end_cut).step_by(AHEAD) {
            let some = first..(first + AHEAD).min(end_cut);
            for (corners, reference) in corners.iter_mut().zip(&right[some.clone()]) {
                *corners = references::corners_of(triangles, reference);
            }
            for (at, corners) in some.zip(&corners) {
                let (below, above) = references::cut(&right[at], corners, plane);
                if let Some(below) = below {
                    left_side.add(&below);
                    refs.push(below);
                }
                if let Some(above) = above {
                    right_side.add(&above);
                    right[len] = above;
                    len += 1;
                }
            }
        }
        right.truncate(len);
        Some(divide(cell, plane, &left_side, &right_side))
    }
}

/// What lies on a side.
struct Side {
    bounds: Bounds,
    triangles: usize,
}

impl Side {
    #[inline(always)]
    fn add(&mut self, part: &Reference) {
        self.bounds.merge(part);
        self.triangles += part.weight() as usize;
    }
}

/// How many references lie on the left alone, on both sides, and on the right alone; and their triangles.
#[inline(always)]
fn count(refs: &[Reference], plane: Plane) -> ([usize; 3], [usize; 3]) {
    let (mut left, mut right, mut left_weight, mut right_weight, mut weight) = (0u32, 0u32, 0u32, 0u32, 0u32);
    for reference in refs {
        let (l, r) = sides(reference, plane);
        left += u32::from(l);
        right += u32::from(r);
        left_weight += u32::from(l) * reference.weight();
        right_weight += u32::from(r) * reference.weight();
        weight += reference.weight();
    }
    let three = |all: u32, left: u32, right: u32| [all - right, left + right - all, all - left].map(|n| n as usize);
    (three(refs.len() as u32, left, right), three(weight, left_weight, right_weight))
}

/// Moves what lies on the left alone to the front, and says where it ends; what lies on the right alone goes to the front of `right`, and
/// what lies on both sides behind it, after a free place. Without a branch on the side, which nobody could foretell.
#[inline(always)]
fn part(refs: &mut [Reference], base: usize, right: &mut Vec<Reference>, counts: [usize; 3], plane: Plane) -> usize {
    right.resize(counts[1] + counts[2] + 2, Bounds::EMPTY);
    let (mut left_end, mut right_end, mut cut_end) = (base, 0, counts[2] + 1);
    for i in base..refs.len() {
        let reference = refs[i];
        let (l, r) = sides(&reference, plane);
        refs[left_end] = reference;
        right[if l & r { cut_end } else { right_end }] = reference;
        left_end += usize::from(!r);
        right_end += usize::from(!l);
        cut_end += usize::from(l & r);
    }
    left_end
}

/// The cells of the sides: they share what is left of the duplicates that their cell may have.
fn divide(cell: &Cell, plane: Plane, left: &Side, right: &Side) -> Sides {
    let all = left.triangles + right.triangles;
    let spare = cell.budget.saturating_sub(all.saturating_sub(cell.triangles));
    let left_share = (spare as f64 * left.triangles as f64 / all as f64) as usize;
    let child = |side: &Side, budget: usize, number: u64| Cell {
        bounds: side.bounds,
        triangles: side.triangles,
        depth: cell.depth + 1,
        budget,
        path: mix(cell.path.wrapping_mul(2).wrapping_add(number)),
    };
    Sides { plane, left: child(left, left_share, 0), right: child(right, spare - left_share, 1) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lanes::AnyLanes;
    use crate::math::simd::SimdTier;
    use glam::Vec3;

    /// Slanted triangles, two by two along x.
    struct Slanted;

    impl Triangles for Slanted {
        fn len(&self) -> usize {
            200
        }

        fn vertices(&self, triangle: u32) -> [Vec3; 3] {
            let at = |x: f32, y: f32| Vec3::new(0.1 * (triangle / 2) as f32 + x, y, x * y);
            if triangle.is_multiple_of(2) {
                [at(0.0, 0.0), at(1.0, 0.0), at(1.0, 1.0)]
            } else {
                [at(0.0, 0.0), at(1.0, 1.0), at(0.0, 1.0)]
            }
        }
    }

    #[test]
    fn sides_hold_what_reaches_there_by_any_instructions() {
        let mut all = vec![Bounds::EMPTY; 200];
        let len = references::make(&Slanted, 0, true, &mut all);
        assert_eq!(len, 100);
        all.truncate(len);
        let cell = Cell { bounds: Bounds::around(&all), triangles: 200, depth: 0, budget: 1000, path: 1 };
        let plane = Plane { axis: 0, at: 5.25 };
        let of = |tier| {
            let (mut refs, mut right) = (all.clone(), Vec::new());
            let deal = Deal { triangles: &Slanted, refs: &mut refs, base: 0, right: &mut right, plane, cell: &cell };
            let sides = AnyLanes::new(tier).run(deal).unwrap();
            (sides, refs, right)
        };
        let (sides, left, right) = of(SimdTier::Scalar);
        let mut seen = [[false; 200]; 2];
        for (side, seen) in [&left, &right].into_iter().zip(&mut seen) {
            side.iter().flat_map(Reference::triangles).for_each(|t| seen[t as usize] = true);
        }
        for t in 0..200 {
            let x = Slanted.vertices(t).map(|v| v.x);
            let reaches = [x.iter().any(|x| *x < plane.at), x.iter().any(|x| *x > plane.at)];
            assert_eq!([seen[0][t as usize], seen[1][t as usize]], reaches, "{t}");
        }
        let triangles = |side: &[Reference]| side.iter().map(|r| r.weight() as usize).sum::<usize>();
        assert_eq!((sides.left.triangles, sides.right.triangles), (triangles(&left), triangles(&right)));
        assert_eq!(sides.left.budget + sides.right.budget, 1000 - (triangles(&left) + triangles(&right) - 200));
        assert!(left.iter().all(|r| r.hi(0) <= plane.at) && right.iter().all(|r| r.lo(0) >= plane.at));
        for tier in [SimdTier::Avx2, SimdTier::Avx512] {
            let (_, other_left, other_right) = of(tier);
            let same = |a: &[Reference], b: &[Reference]| {
                let bits = |r: &Reference| r.0.map(f32::to_bits);
                a.len() == b.len() && a.iter().zip(b).all(|(a, b)| bits(a) == bits(b))
            };
            assert!(same(&left, &other_left) && same(&right, &other_right), "{tier}");
        }
        let none = Cell { budget: 3, ..cell };
        let (mut refs, mut right) = (all.clone(), Vec::new());
        let deal = Deal { triangles: &Slanted, refs: &mut refs, base: 0, right: &mut right, plane, cell: &none };
        assert!(AnyLanes::new(SimdTier::Scalar).run(deal).is_none(), "more duplicates than the cell may have");
        assert_eq!((refs.len(), right.len()), (100, 0));
    }
}
