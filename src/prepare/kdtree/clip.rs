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
pub fn whole(corners: &[[f32; 3]; 3]) -> Bounds {
    let ends = |pick: fn(f32, f32) -> f32| [0, 1, 2].map(|k| pick(pick(corners[0][k], corners[1][k]), corners[2][k]));
    Bounds::new(ends(f32::min), ends(f32::max))
}

/// The box around the part of a triangle that lies in `cell`; `None` where it does not reach.
pub fn clipped(corners: &[[f32; 3]; 3], cell: &Bounds) -> Option<Bounds> {
    let mut polygon = Polygon::new(corners);
    polygon.keep_within(cell);
    polygon.bounds_in(cell)
}

/// The boxes around the two parts into which a plane cuts a triangle within `cell`: below and above the plane.
pub fn cut(corners: &[[f32; 3]; 3], cell: &Bounds, axis: usize, at: f32) -> (Option<Bounds>, Option<Bounds>) {
    let mut polygon = Polygon::new(corners);
    polygon.keep_within(cell);
    let (mut lower, mut upper) = (*cell, *cell);
    lower.set_hi(axis, at);
    upper.set_lo(axis, at);
    let part = |mut polygon: Polygon, sign: f64, cell: &Bounds| {
        polygon.keep(axis, f64::from(at), sign);
        polygon.bounds_in(cell)
    };
    (part(polygon, -1.0, &lower), part(polygon, 1.0, &upper))
}

/// The corners of the part of a triangle that lies in `cell`; none where it does not reach.
pub fn part(corners: &[[f32; 3]; 3], cell: &Bounds) -> Vec<[f64; 3]> {
    let mut polygon = Polygon::new(corners);
    polygon.keep_within(cell);
    polygon.corners[..polygon.len].to_vec()
}

/// A convex polygon: a triangle cut by up to six planes (Sutherland & Hodgman 1974), so with nine corners at most.
#[derive(Clone, Copy)]
struct Polygon {
    corners: [[f64; 3]; 10],
    len: usize,
}

impl Polygon {
    fn new(triangle: &[[f32; 3]; 3]) -> Self {
        let mut corners = [[0.0; 3]; 10];
        for (corner, from) in corners.iter_mut().zip(triangle) {
            *corner = from.map(f64::from);
        }
        Self { corners, len: 3 }
    }

    /// Keeps what lies in a cell.
    fn keep_within(&mut self, cell: &Bounds) {
        for axis in 0..3 {
            self.keep(axis, f64::from(cell.lo(axis)), 1.0);
            self.keep(axis, f64::from(cell.hi(axis)), -1.0);
        }
    }

    /// Keeps the half where `sign · (x − plane) ≥ 0`.
    fn keep(&mut self, axis: usize, plane: f64, sign: f64) {
        let inside = |corner: &[f64; 3]| sign * (corner[axis] - plane) >= 0.0;
        if self.corners[..self.len].iter().all(inside) {
            return;
        }
        let old = self.corners;
        let old = &old[..self.len];
        self.len = 0;
        for (i, b) in old.iter().enumerate() {
            let a = &old[if i == 0 { old.len() - 1 } else { i - 1 }];
            if inside(a) != inside(b) {
                let s = (plane - a[axis]) / (b[axis] - a[axis]);
                let mut cut = [0, 1, 2].map(|k| a[k] + s * (b[k] - a[k]));
                cut[axis] = plane;
                self.push(cut);
            }
            if inside(b) {
                self.push(*b);
            }
        }
    }

    fn push(&mut self, corner: [f64; 3]) {
        // A convex polygon never gets here with ten corners; rounding may make it slightly concave, and then one is spare.
        if let Some(slot) = self.corners.get_mut(self.len) {
            *slot = corner;
            self.len += 1;
        }
    }

    /// The box around it, rounded outwards where f32 cannot tell its ends, within a cell.
    fn bounds_in(&self, cell: &Bounds) -> Option<Bounds> {
        let mut lo = [f64::INFINITY; 3];
        let mut hi = [f64::NEG_INFINITY; 3];
        for corner in &self.corners[..self.len] {
            for axis in 0..3 {
                lo[axis] = if corner[axis] < lo[axis] { corner[axis] } else { lo[axis] };
                hi[axis] = if corner[axis] > hi[axis] { corner[axis] } else { hi[axis] };
            }
        }
        let down = |x: f64| if f64::from(x as f32) > x { (x as f32).next_down() } else { x as f32 };
        let up = |x: f64| if f64::from(x as f32) < x { (x as f32).next_up() } else { x as f32 };
        let part = Bounds::new(lo.map(down), hi.map(up)).intersection(cell);
        (self.len > 0 && !part.is_empty()).then_some(part)
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
}
