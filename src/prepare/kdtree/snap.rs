//! Planes of large cells, moved to where they cut few references.
//!
//! Where a plane between two bins lies exactly hardly matters to the cost of a large cell, but much to how many references it
//! cuts: meshes have rows of edges, and a plane along a row cuts nothing.

use super::bounds::Reference;
use super::split::{Cell, Plane};

/// Planes that are compared.
const PLANES: usize = 32;
/// References whose edges are looked at, about.
const LOOK_AT: usize = 2048;

/// The plane at an edge of a reference, within half a bin's `width` of `plane`, that cuts the fewest of all references; or `plane`
/// itself.
#[inline(always)]
pub fn to_an_edge(refs: &[Reference], cell: &Cell, plane: Plane, width: f32) -> Plane {
    let axis = plane.axis;
    let from = (plane.at - 0.5 * width).max(cell.bounds.lo(axis));
    let to = (plane.at + 0.5 * width).min(cell.bounds.hi(axis));
    let mut planes = [plane.at; PLANES];
    let mut len = 1;
    for reference in refs.iter().step_by(refs.len().div_ceil(LOOK_AT)) {
        for at in [reference.lo(axis), reference.hi(axis)] {
            if from < at && at < to && len < PLANES {
                planes[len] = at;
                len += 1;
            }
        }
    }
    let mut cut = [0u32; PLANES];
    for reference in refs {
        let (lo, hi) = (reference.lo(axis), reference.hi(axis));
        if lo < to && hi > from {
            for (cut, at) in cut.iter_mut().zip(&planes) {
                *cut += u32::from((lo < *at) & (*at < hi));
            }
        }
    }
    let best = (0..len).min_by_key(|&k| cut[k]).unwrap_or(0);
    Plane { axis, at: planes[best] }
}

#[cfg(test)]
mod tests {
    use super::super::bounds::Bounds;
    use super::*;

    #[test]
    fn a_plane_moves_between_two_rows() {
        // Rows of boxes from k to k + 1.
        let row = |i: u32| {
            let k = (i % 10) as f32;
            Bounds::new([k, 0.0, 0.0], [k + 1.0, 1.0, 1.0]).of_triangle(i, 0.0)
        };
        let refs: Vec<Reference> = (0..5000).map(row).collect();
        let cell = Cell { bounds: Bounds::around(&refs), triangles: refs.len(), depth: 0, budget: 10_000, path: 1 };
        let moved = to_an_edge(&refs, &cell, Plane { axis: 0, at: 4.7 }, 1.0);
        assert_eq!(moved, Plane { axis: 0, at: 5.0 });
        let none_near = Plane { axis: 0, at: 4.5 };
        assert_eq!(to_an_edge(&refs, &cell, none_near, 0.5), none_near, "there is no edge within a quarter");
    }
}
