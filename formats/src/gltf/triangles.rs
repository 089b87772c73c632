//! From the modes of primitives to lists of triangles.

use gltf::json::mesh::Mode;

/// The triangles of a primitive, counter-clockwise as glTF 2.0, 3.7.2.1 has them; `None` for points and lines.
pub(super) fn assemble(mode: Mode, indices: &[u32]) -> Option<Vec<[u32; 3]>> {
    let different = |t: &[u32; 3]| t[0] != t[1] && t[1] != t[2] && t[2] != t[0];
    match mode {
        Mode::Points | Mode::Lines | Mode::LineLoop | Mode::LineStrip => None,
        Mode::Triangles => Some(indices.as_chunks().0.to_vec()),
        // Repeated corners in strips are stitches, not surface.
        Mode::TriangleStrip => {
            let strip = indices.windows(3).zip([false, true].into_iter().cycle());
            let triangles = strip.filter_map(|(w, odd)| {
                let [a, b, c] = *w.first_chunk()?;
                Some(if odd { [a, c, b] } else { [a, b, c] })
            });
            Some(triangles.filter(different).collect())
        }
        Mode::TriangleFan => {
            let centre = *indices.first().unwrap_or(&0);
            let rim = indices.get(1..).unwrap_or_default();
            let triangles = rim.windows(2).filter_map(|w| w.first_chunk().map(|[b, c]| [*b, *c, centre]));
            Some(triangles.filter(different).collect())
        }
    }
}

/// As [`assemble`], with strips and fans that begin anew behind each index `restart`, where there is such a number.
pub(super) fn assemble_pieces(mode: Mode, indices: &[u32], restart: Option<u32>) -> Option<Vec<[u32; 3]>> {
    match restart.filter(|r| matches!(mode, Mode::TriangleStrip | Mode::TriangleFan) && indices.contains(r)) {
        None => assemble(mode, indices),
        Some(restart) => indices.split(|i| *i == restart).map(|piece| assemble(mode, piece)).try_fold(
            Vec::new(),
            |mut all, piece| {
                all.extend(piece?);
                Some(all)
            },
        ),
    }
}

/// How many triangles a primitive of so many indices has at most.
pub(super) fn upper_bound(mode: Mode, indices: usize) -> u64 {
    let n = indices as u64;
    match mode {
        Mode::Points | Mode::Lines | Mode::LineLoop | Mode::LineStrip => 0,
        Mode::Triangles => n / 3,
        Mode::TriangleStrip | Mode::TriangleFan => n.saturating_sub(2),
    }
}

/// Drops the triangles that name vertices beyond `vertices`; returns how many.
pub(super) fn drop_out_of_range(triangles: &mut Vec<[u32; 3]>, vertices: usize) -> usize {
    let before = triangles.len();
    if triangles.as_flattened().iter().max().is_some_and(|max| *max as usize >= vertices) {
        triangles.retain(|t| t.iter().all(|i| (*i as usize) < vertices));
    }
    before - triangles.len()
}

/// Where only a small part of the vertices is named, renumbers the triangles to name that part densely and returns
/// its sorted list. Primitives often share one large vertex array; copying it for each would be quadratic.
pub(super) fn compact(triangles: &mut [[u32; 3]], vertices: usize) -> Option<Vec<u32>> {
    let corners = triangles.as_flattened_mut();
    if vertices <= corners.len().saturating_mul(2).max(64) {
        return None;
    }
    let mut used = corners.to_vec();
    used.sort_unstable();
    used.dedup();
    for corner in corners {
        // Every corner is in the list.
        *corner = used.binary_search(corner).map_or(0, |i| i as u32);
    }
    Some(used)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn strips_alternate_their_winding_and_skip_stitches() {
        let strip = assemble(Mode::TriangleStrip, &[0, 1, 2, 3, 3, 4]);
        assert_eq!(strip, Some(vec![[0, 1, 2], [1, 3, 2]]));
        assert_eq!(assemble(Mode::TriangleFan, &[0, 1, 2, 3]), Some(vec![[1, 2, 0], [2, 3, 0]]));
        assert_eq!(assemble(Mode::TriangleStrip, &[0, 1]), Some(vec![]));
        assert_eq!(assemble(Mode::TriangleFan, &[]), Some(vec![]));
        assert_eq!(assemble(Mode::LineStrip, &[0, 1, 2]), None);
    }

    #[test]
    fn strips_and_fans_begin_anew_where_they_are_told() {
        let strip = assemble_pieces(Mode::TriangleStrip, &[0, 1, 2, 255, 3, 4, 5, 6], Some(255));
        assert_eq!(strip, Some(vec![[0, 1, 2], [3, 4, 5], [4, 6, 5]]));
        let fan = assemble_pieces(Mode::TriangleFan, &[0, 1, 2, 255, 3, 4, 5], Some(255));
        assert_eq!(fan, Some(vec![[1, 2, 0], [4, 5, 3]]));
        assert_eq!(assemble_pieces(Mode::Triangles, &[0, 1, 255], Some(255)), Some(vec![[0, 1, 255]]));
    }

    #[test]
    fn compacting_names_the_same_vertices() {
        let mut triangles = vec![[900, 5, 70], [5, 70, 8]];
        let used = compact(&mut triangles, 1000);
        assert_eq!(used, Some(vec![5, 8, 70, 900]));
        assert_eq!(triangles, [[3, 0, 2], [0, 2, 1]]);
        assert_eq!(compact(&mut triangles, 12), None);
    }
}
