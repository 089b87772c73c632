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
    /// From the common frame to the mesh.
    inverse: DMat3,
    /// Where the common origin lies in the mesh's coordinates.
    from: DVec3,
    /// Blur by each of the axes of a ray's origin.
    blur_of_origin: [Vec3; 3],
    /// Blur of any ray.
    blur: Vec3,
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
        let up = |v: DVec3| (v * 1.0001).as_vec3() + Vec3::splat(f32::MIN_POSITIVE);
        let columns = [inverse_size.x_axis, inverse_size.y_axis, inverse_size.z_axis];
        Self {
            placement: *placement,
            inverse,
            from,
            blur_of_origin: columns.map(|column| up(column * (12.0 * U))),
            blur: up(blur),
        }
    }

    /// Sets a ray as the tree sees it; gives the largest blur.
    #[inline(always)]
    pub fn set(&self, slab: &mut SlabRay, ray: &Ray) -> f32 {
        let origin = self.inverse * ray.origin.as_dvec3() + self.from;
        let dir = self.inverse * ray.dir.as_dvec3();
        let [x, y, z] = ray.origin.abs().to_array();
        let by_origin = self.blur_of_origin[0] * x + self.blur_of_origin[1] * y + self.blur_of_origin[2] * z;
        let blur = self.blur + by_origin + origin.as_vec3().abs() * (4.5 * U as f32);
        slab.set_blurred(origin, dir, blur);
        blur.max_element()
    }
}
