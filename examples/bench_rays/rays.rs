//! Rays as a path tracer shoots them.

use crate::meshes::{Mesh, hash};
use glam::Vec3;
use kiln::math::Ray;
use kiln::prepare::kdtree::{KdTree, Triangles};

/// Rays of one kind.
pub struct Set {
    pub name: &'static str,
    pub any: bool,
    pub rays: Vec<Ray>,
}

const SIDE: u32 = 700;

fn camera(lo: Vec3, hi: Vec3) -> Vec<Ray> {
    let (centre, radius) = ((lo + hi) * 0.5, (hi - lo).length() * 0.5);
    let back = Vec3::new(0.5, 0.45, 1.0).normalize();
    let (eye, forward) = (centre + back * (2.0 * radius), -back);
    let right = forward.cross(Vec3::Y).normalize();
    let up = right.cross(forward);
    let half = 0.414;
    let ray = |i: u32| {
        let (x, y) = ((i % SIDE) as f32 + 0.5, (i / SIDE) as f32 + 0.5);
        let (a, b) = ((2.0 * x / SIDE as f32 - 1.0) * half, (1.0 - 2.0 * y / SIDE as f32) * half);
        Ray { origin: eye, dir: (forward + right * a + up * b).normalize(), t_max: 1e30 }
    };
    (0..SIDE * SIDE).map(ray).collect()
}

/// Cosine-distributed rays from where rays hit.
fn bounce(mesh: &Mesh, tree: &KdTree, rays: &[Ray], radius: f32, salt: u32) -> Vec<Ray> {
    let mut next = Vec::new();
    for (i, ray) in rays.iter().enumerate() {
        let Some(hit) = tree.closest(ray, |_| true) else { continue };
        let [a, b, c] = mesh.vertices(hit.triangle);
        let normal = (b - a).cross(c - a).normalize_or_zero();
        let normal = if normal.dot(ray.dir) > 0.0 { -normal } else { normal };
        let (z, angle) = (1.0 - 2.0 * hash(i as u32, salt), core::f32::consts::TAU * hash(i as u32, salt + 1));
        let r = (1.0 - z * z).max(0.0).sqrt();
        let dir = normal * 1.0001 + Vec3::new(r * libm::cosf(angle), r * libm::sinf(angle), z);
        let origin = ray.origin + ray.dir * hit.t + normal * (1e-4 * radius);
        next.push(Ray { origin, dir: dir.normalize(), t_max: 1e30 });
    }
    next
}

fn shuffled(rays: &[Ray]) -> Vec<Ray> {
    let mut rays = rays.to_vec();
    for i in (1..rays.len()).rev() {
        rays.swap(i, (f64::from(hash(i as u32, 77)) * (i + 1) as f64) as usize);
    }
    rays
}

/// Camera, bounce, shuffled bounce, second bounce, shadow.
pub fn sets(mesh: &Mesh, tree: &KdTree) -> Vec<Set> {
    let (lo, hi) = mesh.points.iter().fold((mesh.points[0], mesh.points[0]), |(lo, hi), p| (lo.min(*p), hi.max(*p)));
    let radius = (hi - lo).length() * 0.5;
    let first = camera(lo, hi);
    let second = bounce(mesh, tree, &first, radius, 1);
    let third = bounce(mesh, tree, &second, radius, 3);
    let light = (lo + hi) * 0.5 + Vec3::Y * (1.5 * radius);
    let to_light = |(i, ray): (usize, &Ray)| {
        let (u, v) = (2.0 * hash(i as u32, 5) - 1.0, 2.0 * hash(i as u32, 6) - 1.0);
        let target = light + Vec3::new(u, 0.0, v) * (0.5 * radius);
        Ray { origin: ray.origin, dir: target - ray.origin, t_max: 0.999 }
    };
    let shadow = second.iter().enumerate().map(to_light).collect();
    let shuffled = shuffled(&second);
    let set = |name, any, rays| Set { name, any, rays };
    vec![
        set("camera", false, first),
        set("bounce", false, second),
        set("shuffled", false, shuffled),
        set("bounce2", false, third),
        set("shadow", true, shadow),
    ]
}
