//! Rays as a path tracer shoots them: from a camera, after a diffuse bounce, and towards a light above.

use crate::math::{Hit, Ray};
use crate::prepare::PreparedScene;
use glam::Vec3;

/// Rays of one kind.
#[derive(Clone, Debug)]
pub struct RaySet {
    /// `camera`, `bounce` or `shadow`.
    pub name: &'static str,
    /// Whether it is asked if anything is met, not what is nearest.
    pub any_hit: bool,
    /// The rays, in the frame of the tree.
    pub rays: Vec<Ray>,
}

/// Pixels along a side of the camera's square picture.
const SIDE: u32 = 700;
/// Rays that leave a surface start so far from it, relative to the scene's size.
const LIFT: f32 = 1e-4;

/// A number in [0, 1) by its address (the finaliser of MurmurHash3, Stafford's variant 13).
fn number(i: usize, purpose: u64) -> f32 {
    let mut x = (i as u64) << 8 | purpose;
    x = (x ^ (x >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9).wrapping_add(0x9e37_79b9_7f4a_7c15);
    x = (x ^ (x >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    ((x ^ (x >> 31)) >> 40) as f32 / 16_777_216.0
}

/// A pinhole camera, 45° wide, that sees the whole scene from above to one side, row by row.
fn camera(centre: Vec3, radius: f32) -> Vec<Ray> {
    let back = Vec3::new(0.5, 0.45, 1.0).normalize();
    let eye = centre + back * (2.0 * radius);
    let right = (-back).cross(Vec3::Y).normalize();
    let up = right.cross(-back);
    let half = 0.414;
    let ray = |i: u32| {
        let (x, y) = ((i % SIDE) as f32 + 0.5, (i / SIDE) as f32 + 0.5);
        let (a, b) = ((2.0 * x / SIDE as f32 - 1.0) * half, (1.0 - 2.0 * y / SIDE as f32) * half);
        Ray { origin: eye, dir: (right * a + up * b - back).normalize(), t_max: f32::INFINITY }
    };
    (0..SIDE * SIDE).map(ray).collect()
}

/// Camera rays, a cosine-distributed bounce from each of their hits, and a ray from each hit to a point of a square light above.
pub fn sets(prepared: &PreparedScene) -> Vec<RaySet> {
    let Some((lo, hi)) = prepared.bounds else { return Vec::new() };
    let (lo, hi) = (prepared.frame.point(lo), prepared.frame.point(hi));
    let (centre, radius) = ((lo + hi) * 0.5, (hi - lo).length() * 0.5);
    let first = camera(centre, radius);
    let light = centre + Vec3::Y * (1.5 * radius);
    let (mut bounce, mut shadow) = (Vec::new(), Vec::new());
    for (i, ray) in first.iter().enumerate() {
        let Some(Hit { t, triangle, .. }) = prepared.tree.closest(ray, |_| true) else { continue };
        let [a, b, c] = prepared.geometry.corners(triangle);
        let normal = (b - a).cross(c - a).normalize_or_zero();
        let normal = if normal.dot(ray.dir) > 0.0 { -normal } else { normal };
        let origin = ray.origin + ray.dir * t + normal * (LIFT * radius);
        let (z, angle) = (1.0 - 2.0 * number(i, 1), core::f32::consts::TAU * number(i, 2));
        let r = (1.0 - z * z).max(0.0).sqrt();
        let dir = normal * 1.0001 + Vec3::new(r * libm::cosf(angle), r * libm::sinf(angle), z);
        bounce.push(Ray { origin, dir: dir.normalize(), t_max: f32::INFINITY });
        let across = Vec3::new(2.0 * number(i, 3) - 1.0, 0.0, 2.0 * number(i, 4) - 1.0);
        shadow.push(Ray { origin, dir: light + across * (0.5 * radius) - origin, t_max: 0.999 });
    }
    let set = |name, any_hit, rays| RaySet { name, any_hit, rays };
    [set("camera", false, first), set("bounce", false, bounce), set("shadow", true, shadow)]
        .into_iter()
        .filter(|set| !set.rays.is_empty())
        .collect()
}
