//! A plain path tracer in f64: every triangle is tried, directions come from the BSDF alone, nothing is clever. What Kiln
//! computes in f32 is compared with it.

use crate::double_lobes::{Rough, dielectric};
use crate::furnaces::Numbers;
use glam::DVec3;
use kiln::integrate::View;
use std::f64::consts::TAU;

/// How a triangle scatters.
#[derive(Clone, Copy, Debug)]
pub enum Scatter {
    /// Lambert of this albedo.
    Matte(f64),
    /// A mirror of this reflectance at normal incidence, by Schlick's approximation.
    Mirror(f64),
    /// The surface of a clear body of this index, smooth.
    Glass(f64),
    /// The same, rough: the number of its lobe in [`Twin::lobes`].
    RoughGlass(usize),
    /// Rough metal: the number of its lobe in [`Twin::lobes`].
    RoughMetal(usize),
}

#[derive(Clone, Copy, Debug)]
pub struct Triangle {
    pub corners: [DVec3; 3],
    pub scatter: Scatter,
    /// Emission of the front.
    pub emission: f64,
}

impl Triangle {
    pub fn normal(&self) -> DVec3 {
        let [a, b, c] = self.corners;
        (b - a).cross(c - a)
    }

    /// Distance along the ray in lengths of `dir` (Möller & Trumbore 1997), with the least weight of a corner: negative
    /// outside of the triangle.
    pub fn meet(&self, origin: DVec3, dir: DVec3) -> Option<(f64, f64)> {
        let [a, b, c] = self.corners;
        let (e1, e2) = (b - a, c - a);
        let p = dir.cross(e2);
        let det = e1.dot(p);
        if det == 0.0 {
            return None;
        }
        let s = origin - a;
        let q = s.cross(e1);
        let (u, v) = (s.dot(p) / det, dir.dot(q) / det);
        Some((e2.dot(q) / det, u.min(v).min(1.0 - u - v)))
    }
}

/// Triangles in a world of constant radiance.
pub struct Twin {
    pub triangles: Vec<Triangle>,
    pub lobes: Vec<Rough>,
    pub world: f64,
    pub depth: u32,
}

impl Twin {
    /// The nearest triangle in front that is not `leaves`, and its distance.
    fn closest(&self, origin: DVec3, dir: DVec3, leaves: Option<usize>) -> Option<(usize, f64)> {
        let others = self.triangles.iter().enumerate().filter(|(k, _)| Some(*k) != leaves);
        let hits = others.filter_map(|(k, t)| {
            t.meet(origin, dir).filter(|(t, inside)| *t > 0.0 && *inside >= 0.0).map(|(t, _)| (k, t))
        });
        hits.min_by(|a, b| a.1.total_cmp(&b.1))
    }

    fn path(&self, mut origin: DVec3, mut dir: DVec3, numbers: &mut Numbers) -> f64 {
        let (mut radiance, mut throughput, mut leaves) = (0.0, 1.0, None);
        for depth in 0..=self.depth {
            let Some((k, t)) = self.closest(origin, dir, leaves) else { return radiance + throughput * self.world };
            let triangle = &self.triangles[k];
            let outward = triangle.normal().normalize();
            let front = dir.dot(outward) < 0.0;
            radiance += if front { throughput * triangle.emission } else { 0.0 };
            if depth == self.depth {
                break;
            }
            let normal = if front { outward } else { -outward };
            origin += dir * t;
            dir = match triangle.scatter {
                Scatter::Matte(albedo) => {
                    throughput *= albedo;
                    let (r, phi) = (numbers.next().sqrt(), TAU * numbers.next());
                    let (x, y) = normal.any_orthonormal_pair();
                    x * (r * phi.cos()) + y * (r * phi.sin()) + normal * (1.0 - r * r).sqrt()
                }
                Scatter::Mirror(f0) => {
                    let cosine = -dir.dot(normal);
                    throughput *= f0 + (1.0 - f0) * (1.0 - cosine).powi(5);
                    dir + normal * (2.0 * cosine)
                }
                Scatter::Glass(index) => {
                    let eta = if front { index } else { 1.0 / index };
                    let cosine = -dir.dot(normal);
                    match dielectric(cosine, eta) {
                        Some((reflectance, cosine_t)) if numbers.next() >= reflectance => {
                            // Radiance is spread over another solid angle on the far side.
                            throughput /= eta * eta;
                            (dir / eta + normal * (cosine / eta - cosine_t)).normalize()
                        }
                        _ => dir + normal * (2.0 * cosine),
                    }
                }
                Scatter::RoughMetal(k) | Scatter::RoughGlass(k) => {
                    let (x, y) = normal.any_orthonormal_pair();
                    let wo = DVec3::new(-dir.dot(x), -dir.dot(y), -dir.dot(normal));
                    let numbers = [numbers.next(), numbers.next(), numbers.next()];
                    let Some((wi, weight)) = self.lobes[k].sample(wo, front, numbers) else { return radiance };
                    throughput *= weight;
                    (x * wi.x + y * wi.y + normal * wi.z).normalize()
                }
            };
            leaves = Some(k);
        }
        radiance
    }

    /// Mean radiance over a view, and its standard error.
    pub fn mean(&self, view: &View, samples: u32, numbers: &mut Numbers) -> (f64, f64) {
        let c = &view.camera;
        let (mut sum, mut squares) = (0.0, 0.0);
        for _ in 0..samples {
            let (x, y) = (numbers.next(), numbers.next());
            let dir = (c.forward + c.right * (2.0 * x - 1.0) + c.up * (1.0 - 2.0 * y)).normalize();
            let radiance = self.path(c.origin, dir, numbers);
            sum += radiance;
            squares += radiance * radiance;
        }
        let n = f64::from(samples);
        let mean = sum / n;
        (mean, ((squares / n - mean * mean) / (n - 1.0)).sqrt())
    }
}
