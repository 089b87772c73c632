//! What a cell sees of a triangle.
//!
//! A cell refers to a triangle that reaches into it. A hit that the triangle test reports may lie beside the triangle by a
//! few ulps of its size, its [`thickness`] (`slab` has the bound), and so perhaps beside the cell: therefore the boxes that
//! rays are tested against, but not the cells, are widened by it.

use super::bounds::Bounds;
use super::slab::RELATIVE_ERROR;

/// How far around the triangle its hits may lie: a fraction of its size, plus what denormals may lose.
pub fn thickness(corners: &[[f32; 3]; 3]) -> f32 {
    let extent = |axis: usize| {
        let [a, b, c] = corners.map(|corner| corner[axis]);
        a.max(b).max(c) - a.min(b).min(c)
    };
    let size = extent(0).max(extent(1)).max(extent(2));
    size * RELATIVE_ERROR + f32::MIN_POSITIVE
}

/// The box around a whole triangle.
#[inline(always)]
pub fn whole(corners: &[[f32; 3]; 3]) -> Bounds {
    let ends = |pick: fn(f32, f32) -> f32| [0, 1, 2].map(|k| pick(pick(corners[0][k], corners[1][k]), corners[2][k]));
    Bounds::new(ends(f32::min), ends(f32::max))
}

/// The box around the part of a triangle that lies in `cell`; `None` where it does not reach.
pub fn clipped(corners: &[[f32; 3]; 3], cell: &Bounds) -> Option<Bounds> {
    let mut polygon = Polygon::new(corners);
    polygon.keep_within(cell);
    let mut reach = Reach::NOTHING;
    polygon.corners[..polygon.len].iter().for_each(|corner| reach.take(corner, true));
    reach.bounds_in(cell)
}

/// The boxes around the two parts into which a plane cuts what lies of a triangle in `cell`: below and above the plane. `whole` is the
/// box around the triangle.
#[inline(always)]
pub fn cut(
    corners: &[[f32; 3]; 3],
    whole: &Bounds,
    cell: &Bounds,
    axis: usize,
    at: f32,
) -> (Option<Bounds>, Option<Bounds>) {
    let mut polygon = Polygon::new(corners);
    polygon.keep_within_where(cell, whole);
    let (below, above) = polygon.halves(axis, f64::from(at));
    (below.bounds_in(cell), above.bounds_in(cell))
}

/// The corners of the part of a triangle that lies in `cell`; none where it does not reach.
pub fn part(corners: &[[f32; 3]; 3], cell: &Bounds) -> Vec<[f64; 3]> {
    let mut polygon = Polygon::new(corners);
    polygon.keep_within(cell);
    polygon.corners[..polygon.len].iter().map(|&[x, y, z, _]| [x, y, z]).collect()
}

/// A convex polygon: a triangle cut by up to six planes (Sutherland & Hodgman 1974), so with nine corners at most.
#[derive(Clone, Copy)]
struct Polygon {
    /// The last lane is free: four numbers make a vector.
    corners: [[f64; 4]; 10],
    len: usize,
}

impl Polygon {
    #[inline(always)]
    fn new(triangle: &[[f32; 3]; 3]) -> Self {
        let mut corners = [[0.0; 4]; 10];
        for (corner, [x, y, z]) in corners.iter_mut().zip(triangle) {
            *corner = [f64::from(*x), f64::from(*y), f64::from(*z), 0.0];
        }
        Self { corners, len: 3 }
    }

    /// Keeps what lies in a cell.
    fn keep_within(&mut self, cell: &Bounds) {
        self.keep_within_where(cell, &Bounds::new([f32::NEG_INFINITY; 3], [f32::INFINITY; 3]));
    }

    /// Keeps what lies in a cell; `whole` is a box around the polygon.
    #[inline(always)]
    fn keep_within_where(&mut self, cell: &Bounds, whole: &Bounds) {
        for axis in 0..3 {
            if whole.lo(axis) < cell.lo(axis) {
                self.keep(axis, f64::from(cell.lo(axis)), 1.0);
            }
            if whole.hi(axis) > cell.hi(axis) {
                self.keep(axis, f64::from(cell.hi(axis)), -1.0);
            }
        }
    }

    /// Keeps the half where `sign · (x − plane) ≥ 0`.
    #[inline(always)]
    fn keep(&mut self, axis: usize, plane: f64, sign: f64) {
        let inside = |corner: &[f64; 4]| sign * (corner[axis] - plane) >= 0.0;
        if self.corners[..self.len].iter().all(inside) {
            return;
        }
        let old = self.corners;
        let old = &old[..self.len];
        self.len = 0;
        let Some(mut a) = old.last() else { return };
        for b in old {
            if inside(a) != inside(b) {
                self.push(between(a, b, axis, plane));
            }
            if inside(b) {
                self.push(*b);
            }
            a = b;
        }
    }

    #[inline(always)]
    fn push(&mut self, corner: [f64; 4]) {
        // A convex polygon never gets here with ten corners; rounding may make it slightly concave, and then one is spare.
        if let Some(slot) = self.corners.get_mut(self.len) {
            *slot = corner;
            self.len += 1;
        }
    }

    /// How far its halves below and above a plane reach.
    #[inline(always)]
    fn halves(&self, axis: usize, plane: f64) -> (Reach, Reach) {
        let (mut below, mut above) = (Reach::NOTHING, Reach::NOTHING);
        let corners = &self.corners[..self.len];
        let Some(mut a) = corners.last() else { return (below, above) };
        for b in corners {
            let (from, to) = (a[axis] - plane, b[axis] - plane);
            if from * to < 0.0 {
                let point = between(a, b, axis, plane);
                below.take(&point, true);
                above.take(&point, true);
            }
            below.take(b, to <= 0.0);
            above.take(b, to >= 0.0);
            a = b;
        }
        (below, above)
    }
}

/// Where an edge passes a plane.
#[inline(always)]
fn between(a: &[f64; 4], b: &[f64; 4], axis: usize, plane: f64) -> [f64; 4] {
    let share = (plane - a[axis]) / (b[axis] - a[axis]);
    std::array::from_fn(|k| if k == axis { plane } else { a[k] + share * (b[k] - a[k]) })
}

/// How far points reach.
#[derive(Clone, Copy)]
struct Reach {
    lo: [f64; 4],
    hi: [f64; 4],
}

impl Reach {
    const NOTHING: Self = Self { lo: [f64::INFINITY; 4], hi: [f64::NEG_INFINITY; 4] };

    /// Takes a point in, if so.
    #[inline(always)]
    fn take(&mut self, point: &[f64; 4], if_so: bool) {
        self.lo = std::array::from_fn(|k| if if_so & (point[k] < self.lo[k]) { point[k] } else { self.lo[k] });
        self.hi = std::array::from_fn(|k| if if_so & (point[k] > self.hi[k]) { point[k] } else { self.hi[k] });
    }

    /// The box, rounded outwards where f32 cannot tell its ends, within a cell.
    #[inline(always)]
    fn bounds_in(&self, cell: &Bounds) -> Option<Bounds> {
        // An ulp and a little more, without a branch.
        let wider = |x: f32, inside: bool| if inside { x.abs() * f32::EPSILON + f32::MIN_POSITIVE } else { 0.0 };
        let down = |x: f64| x as f32 - wider(x as f32, f64::from(x as f32) > x);
        let up = |x: f64| x as f32 + wider(x as f32, f64::from(x as f32) < x);
        let bounds = Bounds::new([0, 1, 2].map(|k| down(self.lo[k])), [0, 1, 2].map(|k| up(self.hi[k])));
        let part = bounds.intersection(cell);
        (!part.is_empty()).then_some(part)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_corner_region_of_a_slanted_triangle_is_not_touched() {
        let triangle = [[0.0, 0.0, 0.0], [4.0, 0.0, 0.0], [0.0, 4.0, 0.0]];
        let beyond_the_slant = Bounds::new([3.0, 3.0, -1.0], [4.0, 4.0, 1.0]);
        assert!(clipped(&triangle, &beyond_the_slant).is_none());
        let at_the_slant = Bounds::new([1.0, 1.0, -1.0], [2.5, 3.5, 1.0]);
        let part = clipped(&triangle, &at_the_slant).unwrap();
        assert_eq!((part.lo(0), part.hi(1)), (1.0, 3.0), "ends that f32 can tell are exact");
    }

    #[test]
    fn points_and_lines_are_kept_where_they_are() {
        let point = [[1.0, 2.0, 3.0]; 3];
        let cell = Bounds::new([1.0, 0.0, 0.0], [5.0, 5.0, 5.0]);
        assert!(clipped(&point, &cell).is_some(), "a point on the border touches the cell");
        assert!(clipped(&point, &Bounds::new([1.1, 0.0, 0.0], [5.0, 5.0, 5.0])).is_none());
        assert!(whole(&point).contains(&Bounds::new([1.0, 2.0, 3.0], [1.0, 2.0, 3.0])));
    }

    #[test]
    fn a_cut_gives_what_clipping_to_each_side_gives() {
        let mut state = 7u64;
        let mut draw = || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (state >> 40) as f32 / 16_777_216.0
        };
        let mut both = 0;
        for _ in 0..2000 {
            let triangle = [0, 1, 2].map(|_| [0, 1, 2].map(|_| 2.0 * draw() - 0.5));
            let Some(cell) = clipped(&triangle, &Bounds::new([0.0; 3], [1.0; 3])) else { continue };
            let axis = (3.0 * draw()) as usize;
            let at = cell.lo(axis) + draw() * (cell.hi(axis) - cell.lo(axis));
            let (mut lower, mut upper) = (cell, cell);
            lower.set_hi(axis, at);
            upper.set_lo(axis, at);
            let (below, above) = cut(&triangle, &whole(&triangle), &cell, axis, at);
            for (got, side) in [(below, lower), (above, upper)] {
                let wanted = clipped(&triangle, &side);
                assert_eq!(got.is_some(), wanted.is_some());
                let (Some(got), Some(wanted)) = (got, wanted) else { continue };
                for (a, b) in got.0.iter().zip(&wanted.0) {
                    assert!((a - b).abs() < 1e-6, "{triangle:?} in {cell:?} at {at} on {axis}: {got:?}, {wanted:?}");
                }
            }
            both += usize::from(below.is_some() && above.is_some());
        }
        assert!(both > 1000, "{both}");
    }
}
