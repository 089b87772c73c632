//! Shading normals bent so that what they promise can be seen: neither the viewer nor what he sees reflected may lie below
//! the surface.

use glam::Vec3;

/// The least cosine between the viewer and a shading normal that leans away from him: beyond it the normal is bent back,
/// since a viewer below the shading horizon would see black (numerics: clamp to the visible side).
pub(super) const LEAST_COSINE: f32 = 0.02;

/// The shading normal on the viewer's side of the surface, bent towards the viewer where he would be below its horizon.
/// A viewer who sees the face itself at a grazing angle sees it so: the face's own normal is never bent.
pub(super) fn visible_normal(shading: Vec3, normal: Vec3, wo: Vec3) -> Vec3 {
    let shading = if shading.dot(normal) < 0.0 { -shading } else { shading };
    let cosine = shading.dot(wo);
    let least = LEAST_COSINE.min(normal.dot(wo));
    if cosine >= least {
        return shading;
    }
    (shading + wo * (least - cosine)).try_normalize().filter(|n| n.dot(wo) > 0.0).unwrap_or(normal)
}

/// The least cosine between the face's normal and a mirrored direction.
pub(super) const LEAST_MIRRORED: f32 = 0.01;

/// The shading normal turned towards the face's just as far as the mirror image of `wo` in it needs to be above the face;
/// `None` where it is already. All are unit vectors, `wo` and `shading` on the side of `normal`.
///
/// A metal's bumps would have black rims, and coarse glass black facets: what they mirror there is below the surface, and
/// paths cannot go there (Cycles, `ensure_valid_specular_reflection`). The normal n' in the plane of both normals has to give
/// 2 (n'·wo)(n'·n) − wo·n = t, which is quadratic in (n'·n)².
pub(super) fn reflecting_normal(shading: Vec3, normal: Vec3, wo: Vec3) -> Option<Vec3> {
    let z = wo.dot(normal);
    let least = LEAST_MIRRORED.min(0.9 * z);
    let mirrored = 2.0 * shading.dot(wo) * shading.dot(normal) - z;
    if mirrored >= least || z <= 0.0 {
        return None;
    }
    let along = (shading - normal * shading.dot(normal)).try_normalize()?;
    let x = wo.dot(along);
    let a = x * x + z * z;
    let b = 2.0 * (a + z * least);
    let c = (z + least) * (z + least);
    let root = (b * b - 4.0 * a * c).max(0.0).sqrt();
    let cos2 = (0.25 * (if x < 0.0 { b + root } else { b - root }) / a).clamp(0.0, 1.0);
    let bent = along * (1.0 - cos2).sqrt() + normal * cos2.sqrt();
    bent.try_normalize().filter(|n| n.dot(wo) > 0.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::warp::uniform_hemisphere;

    #[test]
    fn mirror_images_come_above_the_face_and_the_normal_turns_no_further() {
        let mut turned = 0;
        for i in 0..20_000_u32 {
            let number = |k: u32| crate::sampling::unit_float(crate::sampling::hash_combine(i, k));
            let wo = uniform_hemisphere([number(0), number(1)]);
            let shading = visible_normal(uniform_hemisphere([number(2), number(3)]), Vec3::Z, wo);
            let mirrored = |n: Vec3| (n * (2.0 * n.dot(wo)) - wo).z;
            let least = LEAST_MIRRORED.min(0.9 * wo.z);
            match reflecting_normal(shading, Vec3::Z, wo) {
                None => assert!(mirrored(shading) >= least - 1e-6),
                Some(bent) => {
                    turned += 1;
                    assert!((bent.length() - 1.0).abs() < 1e-6);
                    // A tenth of the least: what is under the root cancels where both normals nearly agree.
                    assert!((mirrored(bent) - least).abs() < 1e-3, "{wo} {shading} {bent}: {}", mirrored(bent));
                    // In the plane of both normals, between them.
                    assert!(bent.dot(Vec3::Z.cross(shading)).abs() < 1e-5 && bent.z >= shading.z - 1e-5);
                }
            }
        }
        assert!(turned > 3000, "{turned}");
    }

    #[test]
    fn the_faces_own_normal_stays() {
        for wo in [Vec3::Z, Vec3::new(0.6, 0.0, 0.8), Vec3::new(1.0, 0.0, 1e-4).normalize()] {
            assert_eq!(reflecting_normal(Vec3::Z, Vec3::Z, wo), None);
            assert_eq!(visible_normal(Vec3::Z, Vec3::Z, wo), Vec3::Z);
        }
    }
}
