//! What a cell sees of a triangle.
//!
//! A hit that the triangle test reports may lie beside the triangle by a few ulps of its size (`slab` has the bound).
//! So each triangle is thickened by [`thickness`]: a cell refers to it when it touches the thick triangle, and the boxes
//! of references hold all of the thick triangle within the cell.

use super::bounds::Bounds;
use super::slab::RELATIVE_ERROR;

/// How far around the triangle its hits may lie: a fraction of its size, plus what denormals may lose.
pub fn thickness(corners: &[[f32; 3]; 3]) -> f64 {
    let extent = |axis: usize| {
        let x = corners.map(|corner| f64::from(corner[axis]));
        x[0].max(x[1]).max(x[2]) - x[0].min(x[1]).min(x[2])
    };
    let size = extent(0).max(extent(1)).max(extent(2));
    size * f64::from(RELATIVE_ERROR) + f64::from(f32::MIN_POSITIVE)
}

/// The box around a whole thick triangle, rounded outwards.
pub fn whole(corners: &[[f32; 3]; 3]) -> Bounds {
    let thick = thickness(corners);
    Polygon::new(corners).bounds(thick)
}

/// The box around the part of a thick triangle that lies in `cell`; `None` where it does not reach.
pub fn clipped(corners: &[[f32; 3]; 3], cell: &Bounds) -> Option<Bounds> {
    let thick = thickness(corners);
    let mut polygon = Polygon::new(corners);
    polygon.keep_within(cell, thick);
    if polygon.len == 0 {
        return None;
    }
    let part = polygon.bounds(thick).intersection(cell);
    (!part.is_empty()).then_some(part)
}

/// The boxes around the two parts into which a plane cuts a thick triangle within `cell`: below and above the plane.
pub fn cut(corners: &[[f32; 3]; 3], cell: &Bounds, axis: usize, at: f32) -> (Option<Bounds>, Option<Bounds>) {
    let thick = thickness(corners);
    let mut polygon = Polygon::new(corners);
    polygon.keep_within(cell, thick);
    let (mut lower, mut upper) = (*cell, *cell);
    lower.set_hi(axis, at);
    upper.set_lo(axis, at);
    let part = |mut polygon: Polygon, sign: f64, cell: &Bounds| {
        polygon.keep(axis, f64::from(at) + sign * -thick, sign);
        let part = if polygon.len > 0 { polygon.bounds(thick).intersection(cell) } else { Bounds::EMPTY };
        (!part.is_empty()).then_some(part)
    };
    (part(polygon, -1.0, &lower), part(polygon, 1.0, &upper))
}

/// The corners of the part of a triangle (not thickened) that lies in `cell`; none where it does not reach.
pub fn part(corners: &[[f32; 3]; 3], cell: &Bounds) -> Vec<[f64; 3]> {
    let mut polygon = Polygon::new(corners);
    polygon.keep_within(cell, 0.0);
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

    /// Keeps what lies in a cell that is widened by `thick`.
    fn keep_within(&mut self, cell: &Bounds, thick: f64) {
        for axis in 0..3 {
            self.keep(axis, f64::from(cell.lo(axis)) - thick, 1.0);
            self.keep(axis, f64::from(cell.hi(axis)) + thick, -1.0);
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

    fn bounds(&self, thick: f64) -> Bounds {
        let mut lo = [f64::INFINITY; 3];
        let mut hi = [f64::NEG_INFINITY; 3];
        for corner in &self.corners[..self.len] {
            for axis in 0..3 {
                lo[axis] = lo[axis].min(corner[axis]);
                hi[axis] = hi[axis].max(corner[axis]);
            }
        }
        Bounds::new(lo.map(|x| ((x - thick) as f32).next_down()), hi.map(|x| ((x + thick) as f32).next_up()))
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
        assert!((part.hi(0) - 2.5).abs() < 1e-4 && (part.hi(1) - 3.0).abs() < 1e-4 && part.lo(0) == 1.0);
        assert!(part.hi(1) > 3.0, "the box holds the thick triangle");
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
