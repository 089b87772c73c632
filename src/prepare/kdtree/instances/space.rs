//! Rays as a shared tree sees them.
//!
//! A hit at the distance t on a placed triangle has a point q of that triangle with `|q − (o + t·d)| ≤ 8u·t·|d| + 7u·D` on each
//! axis (`super::super::slab`; u = 2⁻²⁴, D is the extent of the triangle). Let A be the placement and B its inverse. Corners of
//! placed triangles are rounded to f32, off by u·W, when W bounds their coordinates; t·|d| is at most W + |o| but for terms in u.
//! So for the like point q' of the triangle in the mesh's coordinates, with |·| taken number by number,
//!
//! `|q' − (B·o + t·B·d)| ≤ |B|·(9u·W + 8u·|o| + 7u·D) + what rounds in f64 + u·|B·o| + u·|B·d|·t`,
//!
//! where the last two are the rounding to f32 of origin and direction, and `|B·d|·t ≤ |q'| + |B·o|` but for terms in u. With
//! that much of blur, q' is found by the boxes and planes of the tree over the mesh in its own coordinates, as exactly as
//! if it had been built over the placed triangles.

use super::super::slab::SlabRay;
use crate::math::{Placement, Ray};
use glam::{DMat3, DVec3, Vec3};

/// u, the relative error of a rounded f32.
const U: f64 = 1.0 / 16_777_216.0;
/// More than what rounds in a few operations of f64.
const U64: f64 = 1e-14;

/// The coordinates of a placed mesh.
#[derive(Clone, Debug)]
pub struct Space {
    /// From the mesh to the common frame.
    pub placement: Placement,
    /// From the common frame to the mesh: three columns. All rows of four are for vectors; the last number means nothing.
    inverse: [[f64; 4]; 3],
    /// Where the common origin lies in the mesh's coordinates.
    from: [f64; 4],
    /// Blur by each of the axes of a ray's origin.
    blur_of_origin: [[f32; 4]; 3],
    /// Blur of any ray.
    blur: [f32; 4],
}

impl Space {
    /// Of an invertible placement of a mesh. `own` bounds the magnitudes of the mesh's coordinates, `placed` is the box around
    /// the placed triangles.
    pub fn new(placement: &Placement, own: DVec3, placed: (Vec3, Vec3)) -> Self {
        let map = placement.affine();
        let (matrix, translation) = (map.matrix3, map.translation);
        let inverse = matrix.inverse();
        let from = -(inverse * translation);
        let reach = placed.0.abs().max(placed.1.abs()).as_dvec3();
        let extent = f64::from((placed.1 - placed.0).max_element());
        let magnitude = |m: &DMat3| DMat3::from_cols(m.x_axis.abs(), m.y_axis.abs(), m.z_axis.abs());
        let (inverse_size, matrix_size) = (magnitude(&inverse), magnitude(&matrix));
        let undone = magnitude(&(inverse * matrix - DMat3::IDENTITY));
        let in_f64 = (matrix_size * own + translation.abs()) * U64;
        let placed_error = reach * (12.0 * U) + DVec3::splat(extent * 10.0 * U + 1e-37) + in_f64;
        let blur = inverse_size * placed_error
            + inverse_size * translation.abs() * U64
            + (undone * 2.0 + DMat3::IDENTITY * (2.0 * U)) * own;
        // Rounded up: these are sums of few positive numbers.
        let up = |v: DVec3| ((v * 1.0001).as_vec3() + Vec3::splat(f32::MIN_POSITIVE)).extend(0.0).to_array();
        let columns = |m: &DMat3| [m.x_axis, m.y_axis, m.z_axis];
        Self {
            placement: *placement,
            inverse: columns(&inverse).map(|column| column.extend(0.0).to_array()),
            from: from.extend(0.0).to_array(),
            blur_of_origin: columns(&inverse_size).map(|column| up(column * (12.0 * U))),
            blur: up(blur),
        }
    }

    /// Sets a ray as the tree sees it; gives the largest blur.
    #[inline(always)]
    pub fn set(&self, slab: &mut SlabRay, ray: &Ray) -> f32 {
        let [x, y, z] = &self.inverse;
        let (o, d) = (ray.origin.as_dvec3(), ray.dir.as_dvec3());
        let ([by_x, by_y, by_z], far) = (&self.blur_of_origin, ray.origin.abs());
        let (mut origin, mut dir, mut blur) = ([0.0; 4], [0.0; 4], [0.0; 4]);
        for i in 0..4 {
            origin[i] = x[i] * o.x + y[i] * o.y + z[i] * o.z + self.from[i];
            dir[i] = x[i] * d.x + y[i] * d.y + z[i] * d.z;
        }
        for i in 0..4 {
            let by_origin = by_x[i] * far.x + by_y[i] * far.y + by_z[i] * far.z;
            blur[i] = self.blur[i] + by_origin + (origin[i] as f32).abs() * (4.5 * U as f32);
        }
        let [blur_x, blur_y, blur_z, _] = blur;
        slab.set_blurred([origin[0], origin[1], origin[2]], [dir[0], dir[1], dir[2]], [blur_x, blur_y, blur_z]);
        blur_x.max(blur_y).max(blur_z)
    }
}
