//! Bounds on rounding errors, and what rays need of them (Pharr, Jakob & Humphreys, "Physically Based Rendering",
//! 4th ed., section 6.8).

use glam::Vec3;

/// γₙ = n·ε / (1 − n·ε): the relative error of n dependent operations in `f32`, ε being half an ulp.
pub const fn gamma(n: u32) -> f32 {
    let ne = n as f32 * (f32::EPSILON * 0.5);
    ne / (1.0 - ne)
}

/// A point moved off its surface, to the side that `towards` points to, just beyond where the rounding of the point
/// itself could have left it (pbrt's `OffsetRayOrigin`). `error` bounds the absolute error of each coordinate, `normal`
/// is the geometric normal on either side.
pub fn offset_point(point: Vec3, error: Vec3, normal: Vec3, towards: Vec3) -> Vec3 {
    let distance = normal.abs().dot(error);
    let side = if towards.dot(normal) < 0.0 { -1.0 } else { 1.0 };
    let offset = normal * (distance * side);
    let moved = point + offset;
    let round = |moved: f32, offset: f32| {
        if offset > 0.0 {
            moved.next_up()
        } else if offset < 0.0 {
            moved.next_down()
        } else {
            moved
        }
    };
    Vec3::new(round(moved.x, offset.x), round(moved.y, offset.y), round(moved.z, offset.z))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_moved_point_is_on_the_asked_side_at_any_scale() {
        for exponent in -12..12 {
            let scale = libm::powf(10.0, exponent as f32);
            let p = Vec3::new(0.3, -1.7, 12.0) * scale;
            let n = Vec3::new(0.6, 0.64, 0.48);
            let error = p.abs() * gamma(7);
            for towards in [n, -n, n + Vec3::X * 3.0] {
                let q = offset_point(p, error, n, towards);
                let signed = (q.as_dvec3() - p.as_dvec3()).dot(n.as_dvec3());
                assert!(signed * f64::from(towards.dot(n)) > 0.0);
                assert!(signed.abs() >= f64::from(error.abs().dot(n.abs())) * 0.99);
            }
        }
    }
}
