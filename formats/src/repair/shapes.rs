//! Shapes that the renderer and importers cut into triangles.

use std::collections::HashMap;

/// Subdivisions at most: beyond them the indices and the memory of a machine end.
const MOST_LEVELS: u32 = 10;

/// The unit sphere as an icosahedron of which every triangle is cut in four, `levels` times (at most 10).
///
/// Gives 10·4ˡ + 2 positions, which lie on the sphere and are its normals too, and 20·4ˡ triangles, counter-clockwise
/// seen from outside. The deepest point of a triangle lies 0.0003 of the radius below the sphere at 5 levels, and a
/// quarter of that with each level more.
pub fn icosphere(levels: u32) -> (Vec<[f32; 3]>, Vec<[u32; 3]>) {
    let golden = 0.5 * (1.0 + 5.0_f64.sqrt());
    let mut positions = Vec::new();
    for (a, b) in [(1.0, golden), (-1.0, golden), (1.0, -golden), (-1.0, -golden)] {
        positions.extend([[0.0, a, b], [a, b, 0.0], [b, 0.0, a]].map(unit));
    }
    let mut triangles = icosahedron_faces(&positions);
    for _ in 0..levels.min(MOST_LEVELS) {
        let mut middles = HashMap::with_capacity(triangles.len() * 3 / 2);
        let mut finer = Vec::with_capacity(triangles.len() * 4);
        for [a, b, c] in triangles {
            let mut middle = |i: u32, j: u32| {
                *middles.entry((i.min(j), i.max(j))).or_insert_with(|| {
                    let (p, q): ([f64; 3], [f64; 3]) = (positions[i as usize], positions[j as usize]);
                    positions.push(unit([p[0] + q[0], p[1] + q[1], p[2] + q[2]]));
                    (positions.len() - 1) as u32
                })
            };
            let (ab, bc, ca) = (middle(a, b), middle(b, c), middle(c, a));
            finer.extend([[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]);
        }
        triangles = finer;
    }
    (positions.into_iter().map(|p| p.map(|x| x as f32)).collect(), triangles)
}

fn unit(p: [f64; 3]) -> [f64; 3] {
    let length = p.iter().map(|x| x * x).sum::<f64>().sqrt();
    p.map(|x| x / length)
}

/// The 20 triples of corners that are all neighbours, turned outward.
fn icosahedron_faces(corners: &[[f64; 3]]) -> Vec<[u32; 3]> {
    let dot = |p: [f64; 3], q: [f64; 3]| p[0] * q[0] + p[1] * q[1] + p[2] * q[2];
    let cross =
        |p: [f64; 3], q: [f64; 3]| [p[1] * q[2] - p[2] * q[1], p[2] * q[0] - p[0] * q[2], p[0] * q[1] - p[1] * q[0]];
    // Neighbours lie 63.4° apart (cosine 1/√5), others 116.6° or more.
    let neighbours = |i: usize, j: usize| dot(corners[i], corners[j]) > 0.0;
    let n = corners.len();
    let mut faces = Vec::new();
    for i in 0..n {
        for j in i + 1..n {
            for k in j + 1..n {
                if neighbours(i, j) && neighbours(j, k) && neighbours(k, i) {
                    let outward = dot(cross(corners[i], corners[j]), corners[k]) > 0.0;
                    let (j, k) = if outward { (j, k) } else { (k, j) };
                    faces.push([i as u32, j as u32, k as u32]);
                }
            }
        }
    }
    faces
}

#[cfg(test)]
mod tests {
    use super::icosphere;

    #[test]
    fn every_level_is_a_closed_sphere() {
        for levels in 0..=4 {
            let (positions, triangles) = icosphere(levels);
            assert_eq!(positions.len(), 10 * (1 << (2 * levels)) + 2);
            assert_eq!(triangles.len(), 20 * (1 << (2 * levels)));
            let mut edges: Vec<[u32; 2]> =
                triangles.iter().flat_map(|[a, b, c]| [[*a, *b], [*b, *c], [*c, *a]]).collect();
            edges.sort_unstable();
            for [a, b] in &edges {
                assert!(edges.binary_search(&[*b, *a]).is_ok(), "level {levels}: edge {a}–{b} has one side only");
            }
            edges.dedup();
            assert_eq!(edges.len(), 3 * triangles.len(), "level {levels}: an edge runs twice the same way");
        }
    }
}
