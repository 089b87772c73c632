//! Polygons to triangles: fans where they are right, ear clipping where they are not.

use earcut::Earcut;
use glam::{DVec2, DVec3};

/// Ear clipping takes quadratic time on hostile outlines. One [`Triangulator`] spends this much of corners², then it
/// fans: some seconds, and far beyond what real files need.
const WORK: usize = 1_000_000_000;
/// Outlines up to here cost nothing to speak of and always go through.
const SMALL: usize = 80;
/// Outlines beyond are fanned.
const LARGE: usize = 8192;

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
    work_left: usize,
}

impl Default for Triangulator {
    fn default() -> Self {
        Self { earcut: Earcut::new(), flat: Vec::new(), indices: Vec::new(), triangles: Vec::new(), work_left: WORK }
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
        if n > SMALL {
            match self.work_left.checked_sub(n.saturating_mul(n)) {
                Some(left) if n <= LARGE => self.work_left = left,
                _ => return self.fan(0, n),
            }
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

#[cfg(test)]
mod tests {
    use super::*;

    fn area_vector(corners: &[DVec3], triangles: &[[u32; 3]]) -> DVec3 {
        let at = |i: u32| corners[i as usize];
        triangles.iter().map(|[a, b, c]| (at(*b) - at(*a)).cross(at(*c) - at(*a))).sum()
    }

    fn total_area(corners: &[DVec3], triangles: &[[u32; 3]]) -> f64 {
        let one = |t: &[u32; 3]| area_vector(corners, std::slice::from_ref(t)).length();
        triangles.iter().map(one).sum()
    }

    /// n − 2 triangles that face the polygon's way, cover it once and share every inner edge.
    fn assert_covers(corners: &[DVec3]) {
        let triangles = Triangulator::default().polygon(corners).to_vec();
        let n = corners.len();
        assert_eq!(triangles.len(), n - 2, "{corners:?} {triangles:?}");
        let normal = newell_normal(corners);
        assert!((area_vector(corners, &triangles) - normal).length() < 1e-9 * normal.length());
        assert!((total_area(corners, &triangles) - normal.length()).abs() < 1e-9 * normal.length(), "{triangles:?}");
        let mut edges: Vec<[u32; 2]> = triangles.iter().flat_map(|[a, b, c]| [[*a, *b], [*b, *c], [*c, *a]]).collect();
        edges.extend((0..n as u32).map(|i| [(i + 1) % n as u32, i]));
        for [a, b] in &edges {
            assert!(edges.contains(&[*b, *a]), "edge {a}-{b} is open: {triangles:?}");
        }
    }

    /// A flat outline on planes of several directions.
    fn on_planes(outline: &[[f64; 2]]) -> Vec<Vec<DVec3>> {
        let planes = [
            (DVec3::X, DVec3::Y),
            (DVec3::Y, DVec3::X),
            (DVec3::Z, DVec3::Y),
            (DVec3::NEG_Z, DVec3::X),
            (DVec3::new(1.0, 2.0, 3.0), DVec3::new(-3.0, 0.0, 1.0)),
        ];
        let place = |(u, v): (DVec3, DVec3)| outline.iter().map(|p| 500.0 * DVec3::ONE + u * p[0] + v * p[1]).collect();
        planes.into_iter().map(place).collect()
    }

    #[test]
    fn simple_polygons_are_covered_once() {
        let square = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];
        let dart = [[0.0, 0.0], [2.0, 0.0], [0.5, 0.5], [0.0, 2.0]];
        let dart_seen_from_its_wing = [[2.0, 0.0], [0.5, 0.5], [0.0, 2.0], [0.0, 0.0]];
        let l = [[0.0, 0.0], [2.0, 0.0], [2.0, 1.0], [1.0, 1.0], [1.0, 2.0], [0.0, 2.0]];
        let u = [[2.0, 1.0], [2.0, 3.0], [3.0, 3.0], [3.0, 0.0], [0.0, 0.0], [0.0, 3.0], [1.0, 3.0], [1.0, 1.0]];
        for outline in [&square[..], &dart, &dart_seen_from_its_wing, &l, &u] {
            on_planes(outline).iter().for_each(|p| assert_covers(p));
        }
    }

    #[test]
    fn corners_on_straight_edges_keep_their_triangles() {
        let wall = [[0.0, 0.0], [1.0, 0.0], [2.0, 0.0], [2.0, 1.0], [2.0, 2.0], [1.0, 2.0], [0.0, 2.0], [0.0, 1.0]];
        let u_with_corners_on_edges = [
            [2.0, 1.0],
            [2.0, 2.0],
            [2.0, 3.0],
            [3.0, 3.0],
            [3.0, 1.0],
            [3.0, 0.0],
            [2.0, 0.0],
            [1.0, 0.0],
            [0.0, 0.0],
            [0.0, 1.0],
            [0.0, 3.0],
            [1.0, 3.0],
            [1.0, 2.0],
            [1.0, 1.0],
        ];
        for outline in [&wall[..], &u_with_corners_on_edges] {
            on_planes(outline)[..4].iter().for_each(|p| assert_covers(p));
        }
    }

    #[test]
    fn random_star_shapes_are_covered_once() {
        let mut state = 1_u64;
        let mut random = || {
            state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
            (state >> 40) as f64 / (1u64 << 24) as f64
        };
        for n in (4..60).chain([200, 1000]) {
            let outline: Vec<[f64; 2]> = (0..n)
                .map(|i| {
                    let (angle, radius) = (std::f64::consts::TAU * f64::from(i) / f64::from(n), 0.2 + random());
                    [radius * libm::cos(angle), radius * libm::sin(angle)]
                })
                .collect();
            on_planes(&outline).iter().for_each(|p| assert_covers(p));
        }
    }

    #[test]
    fn non_planar_quads_keep_their_boundary() {
        let quad = [DVec3::ZERO, DVec3::X, DVec3::new(1.0, 1.0, 0.5), DVec3::Y];
        let triangles = Triangulator::default().polygon(&quad).to_vec();
        assert_eq!(triangles, [[0, 1, 2], [0, 2, 3]]);
        assert!((area_vector(&quad, &triangles) - newell_normal(&quad)).length() < 1e-12);
    }

    #[test]
    fn degenerate_and_hostile_outlines_end() {
        let mut triangulator = Triangulator::default();
        assert!(triangulator.polygon(&[DVec3::ZERO, DVec3::X]).is_empty());
        assert_eq!(triangulator.polygon(&[DVec3::ONE; 6]).len(), 4);
        assert_eq!(triangulator.polygon(&[DVec3::NAN; 5]).len(), 3);
        assert_eq!(triangulator.polygon(&[DVec3::ZERO, DVec3::X, 2.0 * DVec3::X, 3.0 * DVec3::X]).len(), 2);
        let bow_tie = [DVec3::ZERO, DVec3::new(1.0, 1.0, 0.0), DVec3::X, DVec3::Y];
        assert_eq!(triangulator.polygon(&bow_tie).len(), 2);
        let mut state = 7_u32;
        let mut random = || {
            state = state.wrapping_mul(1664525).wrapping_add(1013904223);
            f64::from(state >> 8)
        };
        let on_circle = |x: f64| DVec3::new(libm::cos(x), libm::sin(x), 0.0);
        for n in [5, 50, 500, 4096, LARGE - 1, 100_000] {
            let x = |i: usize| std::f64::consts::TAU * i as f64 / n as f64;
            let shapes: [Vec<DVec3>; 6] = [
                (0..n).map(|_| DVec3::new(random(), random(), random())).collect(),
                // A star of crossing chords, a circle drawn many times, a comb drawn forth and back.
                (0..n).map(|i| on_circle(x(i) * (n / 2 - 1) as f64)).collect(),
                (0..n).map(|i| on_circle(x(i) * 7.0)).collect(),
                (0..n).map(|i| DVec3::new((i % 3) as f64, i.min(n - i) as f64, 0.0)).collect(),
                // A double spiral, and one with teeth that cross their neighbours.
                (0..n).map(|i| on_circle(i.min(n - i) as f64 * 0.1) * (1.0 + x(i))).collect(),
                (0..n).map(|i| on_circle(x(i)) * (1.0 + 0.5 * (i % 2) as f64 + 1e-3 * random() / 1e7)).collect(),
            ];
            for (k, shape) in shapes.iter().enumerate() {
                let start = std::time::Instant::now();
                let triangles = Triangulator::default().polygon(shape).to_vec();
                assert!(!triangles.is_empty() && triangles.iter().flatten().all(|i| (*i as usize) < n));
                println!("shape {k} of {n} corners: {:?}", start.elapsed());
                assert!(start.elapsed().as_secs() < 5, "shape {k} of {n} corners");
            }
        }
    }
}
