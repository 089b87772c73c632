//! The primitives of `.ray` as triangles: counter-clockwise seen from outside, normals outward.

use crate::repair::shapes::icosphere;
use std::f64::consts::TAU;

/// Radii below this are raised to it, as in the course tracers.
const SMALLEST_RADIUS: f64 = 1e-4;

/// What a mesh is made of. Texture coordinates have v downwards, or there are none.
#[derive(Debug, Default)]
pub(super) struct Tessellation {
    pub positions: Vec<[f32; 3]>,
    pub normals: Vec<[f32; 3]>,
    pub uvs: Vec<[f32; 2]>,
    pub triangles: Vec<[u32; 3]>,
}

impl Tessellation {
    fn vertex(&mut self, position: [f64; 3], normal: [f64; 3]) -> u32 {
        self.positions.push(position.map(|x| x as f32));
        self.normals.push(normal.map(|x| x as f32));
        (self.positions.len() - 1) as u32
    }

    /// A flat disc across the z axis that faces up or down.
    fn cap(&mut self, ring: &[[f64; 2]], z: f64, radius: f64, up: bool) {
        let normal = [0.0, 0.0, if up { 1.0 } else { -1.0 }];
        let centre = self.vertex([0.0, 0.0, z], normal);
        let rim: Vec<u32> = ring.iter().map(|[x, y]| self.vertex([radius * x, radius * y, z], normal)).collect();
        for (a, b) in around(&rim) {
            self.triangles.push(if up { [centre, a, b] } else { [centre, b, a] });
        }
    }
}

/// Each element with its successor, the last with the first.
fn around(ring: &[u32]) -> impl Iterator<Item = (u32, u32)> {
    ring.iter().copied().zip(ring.iter().copied().cycle().skip(1))
}

/// The unit sphere around the origin.
pub(super) fn sphere(levels: u32) -> Tessellation {
    let (positions, triangles) = icosphere(levels);
    Tessellation { normals: positions.clone(), positions, uvs: Vec::new(), triangles }
}

/// The unit sphere with texture coordinates: u once around the y axis, from −z by −x and +z, v from pole to pole. The base dialect
/// has none; its forks that lay textures around spheres do it by longitude and latitude.
pub(super) fn globe(segments: u32) -> Tessellation {
    let (columns, rows) = (segments.max(16), (segments / 2).max(8));
    let mut shape = Tessellation::default();
    for row in 0..=rows {
        let v = f64::from(row) / f64::from(rows);
        let (sin_v, cos_v) = (libm::sin(0.5 * TAU * v), libm::cos(0.5 * TAU * v));
        for column in 0..=columns {
            let u = f64::from(column) / f64::from(columns);
            let (sin_u, cos_u) = (libm::sin(TAU * (u - 0.5)), libm::cos(TAU * (u - 0.5)));
            let position = [sin_v * sin_u, cos_v, sin_v * cos_u];
            shape.vertex(position, position);
            shape.uvs.push([u as f32, v as f32]);
        }
    }
    let at = |row: u32, column: u32| row * (columns + 1) + column;
    for row in 0..rows {
        for column in 0..columns {
            let (a, b) = (at(row, column), at(row + 1, column));
            let (c, d) = (b + 1, a + 1);
            if row + 1 < rows {
                shape.triangles.push([a, b, c]);
            }
            // At the poles one of the two has no area.
            if row > 0 {
                shape.triangles.push([a, c, d]);
            }
        }
    }
    shape
}

/// The square z = 0, x and y in [−0.5, 0.5], that faces +z.
pub(super) fn square() -> Tessellation {
    let mut shape = Tessellation::default();
    for (u, v) in [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)] {
        shape.vertex([u - 0.5, v - 0.5, 0.0], [0.0, 0.0, 1.0]);
        shape.uvs.push([u as f32, 1.0 - v as f32]);
    }
    shape.triangles = vec![[0, 1, 2], [0, 2, 3]];
    shape
}

/// The cube [−0.5, 0.5]³. On the face across one axis, u and v run along the other two in the order of the axes;
/// on negative faces u runs backwards.
pub(super) fn cube() -> Tessellation {
    let mut shape = Tessellation::default();
    for (axis, p, q) in [(0, 1, 2), (1, 0, 2), (2, 0, 1)] {
        for sign in [1.0, -1.0] {
            let mut normal = [0.0; 3];
            normal[axis] = sign;
            let corners = [(-0.5, -0.5), (0.5, -0.5), (0.5, 0.5), (-0.5, 0.5)].map(|(along_p, along_q)| {
                let mut position = [0.0; 3];
                position[axis] = 0.5 * sign;
                position[p] = along_p;
                position[q] = along_q;
                shape.uvs.push([(0.5 + sign * along_p) as f32, (0.5 - along_q) as f32]);
                shape.vertex(position, normal)
            });
            // p × q is the axis itself, but for y, where it is the opposite.
            let [a, b, c, d] = corners;
            let outward = (sign > 0.0) == (axis != 1);
            shape.triangles.extend(if outward { [[a, b, c], [a, c, d]] } else { [[a, c, b], [a, d, c]] });
        }
    }
    shape
}

/// A cone around the z axis from `bottom` radius at z = 0 to `top` radius at z = `height`; a cylinder when they are
/// equal. All must be ≥ 0 and `height` > 0.
///
/// Where one radius is below the course's smallest and the other is not, that end is a point: a vertex per segment,
/// with the mean normal of its segment.
pub(super) fn cone(height: f64, bottom: f64, top: f64, capped: bool, segments: u32) -> Tessellation {
    let ring: Vec<[f64; 2]> = (0..segments)
        .map(|i| TAU * f64::from(i) / f64::from(segments))
        .map(|angle| [libm::cos(angle), libm::sin(angle)])
        .collect();
    let both_tiny = bottom < SMALLEST_RADIUS && top < SMALLEST_RADIUS;
    let radius = |r: f64| match r < SMALLEST_RADIUS {
        true if both_tiny => SMALLEST_RADIUS,
        true => 0.0,
        false => r,
    };
    let (bottom, top) = (radius(bottom), radius(top));
    let mut shape = Tessellation::default();
    let slant = libm::hypot(height, bottom - top);
    let normal = |[x, y]: [f64; 2]| [x * height / slant, y * height / slant, (bottom - top) / slant];
    let half_turn = TAU / (2.0 * f64::from(segments));
    let (cos, sin) = (libm::cos(half_turn), libm::sin(half_turn));
    let between = |[x, y]: [f64; 2]| [x * cos - y * sin, x * sin + y * cos];
    let mut edge = |z: f64, radius: f64| -> Vec<u32> {
        let vertex = |direction: &[f64; 2]| {
            let towards = if radius > 0.0 { *direction } else { between(*direction) };
            shape.vertex([radius * direction[0], radius * direction[1], z], normal(towards))
        };
        ring.iter().map(vertex).collect()
    };
    let (lower, upper) = (edge(0.0, bottom), edge(height, top));
    for ((a, b), (c, d)) in around(&lower).zip(around(&upper)) {
        if bottom > 0.0 {
            shape.triangles.push(if top > 0.0 { [a, b, d] } else { [a, b, c] });
        }
        if top > 0.0 {
            shape.triangles.push([a, d, c]);
        }
    }
    if capped && bottom > 0.0 {
        shape.cap(&ring, 0.0, bottom, false);
    }
    if capped && top > 0.0 {
        shape.cap(&ring, height, top, true);
    }
    shape
}
