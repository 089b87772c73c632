//! The references that a build begins with, and what planes leave of them.
//!
//! Two triangles with numbers that follow each other and a common edge are one reference, a *pair*, where their boxes are nearly the
//! same: the halves of a quadrilateral, neighbours in a strip. That halves what planes are judged by and what is dealt to their sides.
//! A pair that is cut stays one where both its triangles reach.

use super::Triangles;
use super::bounds::{Bounds, Reference};
use super::clip;
use super::split::{Plane, sides};

/// A pair's box has at most this share of its triangles' boxes' areas: what both would cost by themselves.
const MOST_OF_PAIR: f32 = 0.75;

#[inline(always)]
fn corners<T: Triangles>(triangles: &T, triangle: u32) -> [[f32; 3]; 3] {
    triangles.vertices(triangle).map(|corner| corner.to_array())
}

/// Makes references to the triangles from `first` on, as many as there is room for, and says how many those are; with or without
/// pairs.
pub fn make<T: Triangles>(triangles: &T, first: u32, pairs: bool, room: &mut [Reference]) -> usize {
    let mut made = 0;
    // The corners of the triangle before, if it may still become one of a pair.
    let mut before: Option<[[f32; 3]; 3]> = None;
    for triangle in first..first + room.len() as u32 {
        let corners = corners(triangles, triangle);
        let reference = clip::whole(&corners).of_triangle(triangle, clip::thickness(&corners));
        let neighbours = pairs && before.is_some_and(|before| share_an_edge(&before, &corners));
        let both = if neighbours { pair(&room[made - 1], &reference) } else { None };
        if let Some(both) = both {
            room[made - 1] = both;
            before = None;
        } else {
            room[made] = reference;
            made += 1;
            before = Some(corners);
        }
    }
    made
}

/// Whether two triangles have two corners in common.
fn share_an_edge(a: &[[f32; 3]; 3], b: &[[f32; 3]; 3]) -> bool {
    a.iter().filter(|corner| b.contains(corner)).count() >= 2
}

/// A triangle and the one that follows it as a pair, if that pays.
fn pair(first: &Reference, second: &Reference) -> Option<Reference> {
    let both = Bounds::around([first, second]);
    let pays = both.half_area() <= MOST_OF_PAIR * (first.half_area() + second.half_area());
    let thickness = first.thickness().max(second.thickness());
    pays.then(|| both.of_triangle(first.triangles().start, thickness).of_pair())
}

/// The corners of a reference's triangles; of a single one twice.
pub type Corners = [[[f32; 3]; 3]; 2];

/// Looks them up.
#[inline(always)]
pub fn corners_of<T: Triangles>(triangles: &T, reference: &Reference) -> Corners {
    let both = reference.triangles();
    [corners(triangles, both.start), corners(triangles, both.end - 1)]
}

/// What a plane cuts of a reference's triangles, below and above it. At least one part remains: a box around nothing would lose a
/// triangle.
#[inline(always)]
pub fn cut(reference: &Reference, corners: &Corners, plane: Plane) -> (Option<Reference>, Option<Reference>) {
    let (mut below, mut above) = (None, None);
    for (triangle, corners) in reference.triangles().zip(corners) {
        let whole = clip::whole(corners);
        let (left, right) = sides(&whole, plane);
        let (left_part, right_part) = clip::cut(corners, &whole, reference, plane.axis, plane.at);
        add(&mut below, left_part.filter(|_| left), triangle, reference.thickness());
        add(&mut above, right_part.filter(|_| right), triangle, reference.thickness());
    }
    if below.is_none() && above.is_none() {
        let (mut left, mut right) = (*reference, *reference);
        left.set_hi(plane.axis, plane.at);
        right.set_lo(plane.axis, plane.at);
        return (Some(left), Some(right));
    }
    (below, above)
}

/// Adds what a side has of a triangle to what it has of the one before.
#[inline(always)]
fn add(side: &mut Option<Reference>, part: Option<Bounds>, triangle: u32, thickness: f32) {
    let Some(part) = part else { return };
    *side = Some(match side {
        Some(first) => Bounds::around([first, &part]).of_triangle(first.triangles().start, thickness).of_pair(),
        None => part.of_triangle(triangle, thickness),
    });
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec3;

    /// Unit squares of two triangles in a row, then two large triangles that share an edge but lie across each other.
    struct Row;

    impl Triangles for Row {
        fn len(&self) -> usize {
            8
        }

        fn vertices(&self, triangle: u32) -> [Vec3; 3] {
            let x = (triangle / 2) as f32;
            let at = |dx: f32, y: f32| Vec3::new(x + dx, y, 0.5 * y);
            match triangle {
                6 => [Vec3::ZERO, Vec3::Y, Vec3::X * 100.0],
                7 => [Vec3::ZERO, Vec3::Y, Vec3::Z * 100.0],
                _ if triangle.is_multiple_of(2) => [at(0.0, 0.0), at(1.0, 0.0), at(1.0, 1.0)],
                _ => [at(0.0, 0.0), at(1.0, 1.0), at(0.0, 1.0)],
            }
        }
    }

    fn made(pairs: bool) -> Vec<Reference> {
        let mut room = vec![Bounds::EMPTY; 8];
        let len = make(&Row, 0, pairs, &mut room);
        room.truncate(len);
        room
    }

    #[test]
    fn halves_of_squares_are_pairs_and_others_are_not() {
        let ranges: Vec<_> = made(true).iter().map(Reference::triangles).collect();
        assert_eq!(ranges, [0..2, 2..4, 4..6, 6..7, 7..8]);
        assert_eq!(made(false).len(), 8);
    }

    #[test]
    fn a_cut_pair_keeps_on_each_side_what_its_triangles_have_there() {
        let square = made(true)[0];
        let corners = corners_of(&Row, &square);
        let (below, above) = cut(&square, &corners, Plane { axis: 0, at: 0.5 });
        let (below, above) = (below.unwrap(), above.unwrap());
        assert_eq!((below.triangles(), above.triangles()), (0..2, 0..2));
        assert_eq!((below.lo(0), below.hi(0), below.hi(1)), (0.0, 0.5, 1.0));
        assert_eq!((above.lo(0), above.hi(0), above.lo(1)), (0.5, 1.0, 0.0));
        // Of the part beyond x = 0.5 and below y = 0.25 only the first triangle has any.
        let (low, high) = cut(&above, &corners, Plane { axis: 1, at: 0.25 });
        assert_eq!(low.unwrap().triangles(), 0..1);
        assert_eq!(low.unwrap().weight(), 1);
        assert_eq!(high.unwrap().triangles(), 0..2);
    }
}
