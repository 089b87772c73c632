//! Polygons to triangles: fans where they are right, ear clipping where they are not.

use earcut::Earcut;
use glam::{DVec2, DVec3};

/// Corners beyond which a concave polygon is fanned: ear clipping takes quadratic time and worse on hostile outlines.
const MAX_EARCUT_CORNERS: usize = 4096;

/// Turns polygons into triangles. Keeps its buffers from one polygon to the next.
///
/// The polygon is projected along the dominant axis of its Newell normal (Sutherland et al. 1974), which keeps
/// collinear corners collinear. Convex ones and those that see all of their outline from the first corner become a
/// fan, as nearly every tool does it; the rest goes through `earcut`. A polygon of n corners gives n − 2 triangles
/// unless its outline crosses itself; those at collinear corners have no area but keep the neighbours watertight.
pub struct Triangulator {
    earcut: Earcut<f64>,
    flat: Vec<[f64; 2]>,
    indices: Vec<u32>,
    triangles: Vec<[u32; 3]>,
}

impl Default for Triangulator {
    fn default() -> Self {
        Self { earcut: Earcut::new(), flat: Vec::new(), indices: Vec::new(), triangles: Vec::new() }
    }
}

impl std::fmt::Debug for Triangulator {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Triangulator").finish_non_exhaustive()
    }
}

impl Triangulator {
    /// The triangles of one polygon as indices into `corners`, wound as the polygon is. Fewer than three corners give
    /// none. Concave, non-planar and self-intersecting outlines are all legal; so are corners that are not finite
    /// (they get a fan).
    pub fn polygon(&mut self, corners: &[DVec3]) -> &[[u32; 3]] {
        self.triangles.clear();
        let n = corners.len();
        if n == 3 {
            self.triangles.push([0, 1, 2]);
        } else if n > 3 && u32::try_from(n).is_ok() {
            self.many(corners);
        }
        &self.triangles
    }

    fn many(&mut self, corners: &[DVec3]) {
        let n = corners.len();
        let normal = newell_normal(corners);
        if !normal.is_finite() || normal == DVec3::ZERO {
            return self.fan(0, n);
        }
        self.project(corners, normal);
        // For a quadrilateral one of the two diagonals always works.
        for apex in 0..if n == 4 { 2 } else { 1 } {
            if self.sees_all_from(apex) {
                return self.fan(apex, n);
            }
        }
        if n > MAX_EARCUT_CORNERS {
            return self.fan(0, n);
        }
        self.earcut.earcut_slice(&self.flat, &[], &mut self.indices);
        self.triangles.extend(self.indices.chunks_exact(3).filter_map(|t| <[u32; 3]>::try_from(t).ok()));
        if self.triangles.is_empty() {
            return self.fan(0, n);
        }
        let area: f64 = self.triangles.iter().map(|t| self.flat_area(*t)).sum();
        if area < 0.0 {
            self.triangles.iter_mut().for_each(|t| t.swap(1, 2));
        }
        if self.triangles.len() < n - 2 {
            self.close_slits(n);
        }
    }

    /// Drops the dominant axis of the normal, so that the outline runs counter-clockwise.
    fn project(&mut self, corners: &[DVec3], normal: DVec3) {
        let a = normal.abs();
        let axis = if a.x >= a.y && a.x >= a.z {
            0
        } else if a.y >= a.z {
            1
        } else {
            2
        };
        let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
        let (u, v) = if normal[axis] < 0.0 { (v, u) } else { (u, v) };
        // Relative to a corner: differences of near coordinates are exact, products of far ones are not.
        let origin = corners.first().copied().unwrap_or_default();
        self.flat.clear();
        self.flat.extend(corners.iter().map(|c| {
            let d = *c - origin;
            [d[u], d[v]]
        }));
    }

    fn flat_area(&self, triangle: [u32; 3]) -> f64 {
        let [a, b, c] = triangle.map(|i| DVec2::from(self.flat.get(i as usize).copied().unwrap_or_default()));
        0.5 * (b - a).perp_dot(c - a)
    }

    /// Whether the fan from `apex` has no triangle turned over (but for rounding).
    fn sees_all_from(&self, apex: u32) -> bool {
        let n = self.flat.len() as u32;
        let areas = (1..n - 1).map(|i| self.flat_area([apex, (apex + i) % n, (apex + i + 1) % n]));
        let (lowest, total) = areas.fold((0.0_f64, 0.0), |(low, sum), a| (low.min(a), sum + a));
        lowest >= -1e-12 * total
    }

    fn fan(&mut self, apex: u32, n: usize) {
        let n = n as u32;
        self.triangles.clear();
        self.triangles.extend((1..n - 1).map(|i| [apex, (apex + i) % n, (apex + i + 1) % n]));
    }

    /// Ear clipping drops corners on a straight line: one triangle's edge a→b then faces b→c→a of its neighbours.
    /// Such slits have no area; triangles without area close them, so that rounding cannot open them to rays.
    fn close_slits(&mut self, n: usize) {
        let n = n as u32;
        // Edges that want a partner: those of the triangles turned around, against those of the outline.
        let mut have: Vec<[u32; 2]> =
            self.triangles.iter().flat_map(|[a, b, c]| [[*a, *b], [*b, *c], [*c, *a]]).collect();
        have.extend((0..n).map(|i| [(i + 1) % n, i]));
        have.sort_unstable();
        let mut open: Vec<[u32; 2]> = Vec::new();
        open.extend(have.iter().map(|[a, b]| [*b, *a]).filter(|partner| have.binary_search(partner).is_err()));
        open.sort_unstable();
        // Walk the open edges into loops; each loop becomes a fan.
        let mut used = vec![false; open.len()];
        for start in 0..open.len() {
            let mut outline: Vec<u32> = Vec::new();
            let mut at = start;
            while let (Some([from, to]), Some(false)) = (open.get(at), used.get(at)) {
                used[at] = true;
                outline.push(*from);
                let first = open.partition_point(|e| e[0] < *to);
                at = (first..open.len()).take_while(|k| open[*k][0] == *to).find(|k| !used[*k]).unwrap_or(usize::MAX);
            }
            if let Some((apex, rest)) = outline.split_first() {
                self.triangles.extend(rest.windows(2).map(|w| [*apex, w[0], w[1]]));
            }
        }
    }
}

/// Twice the polygon's vector area, by Newell's formula relative to the first corner.
pub fn newell_normal(corners: &[DVec3]) -> DVec3 {
    let Some((origin, rest)) = corners.split_first() else { return DVec3::ZERO };
    rest.windows(2).map(|w| (w[0] - *origin).cross(w[1] - *origin)).sum()
}
