//! Rough lobes in f64, by the textbook: visible microfacet normals (Heitz 2018), integrated albedos.

use glam::DVec3;
use std::f64::consts::TAU;

/// Fresnel's reflectance of a dielectric and the cosine on the far side; `None` for total reflection.
pub fn dielectric(cosine: f64, eta: f64) -> Option<(f64, f64)> {
    let cosine_t2 = 1.0 - (1.0 - cosine * cosine) / (eta * eta);
    let cosine_t = (cosine_t2 > 0.0).then(|| cosine_t2.sqrt())?;
    let s = (cosine - eta * cosine_t) / (cosine + eta * cosine_t);
    let p = (eta * cosine - cosine_t) / (eta * cosine + cosine_t);
    Some((0.5 * (s * s + p * p), cosine_t))
}

/// What a rough lobe is made of.
#[derive(Clone, Copy, Debug)]
pub enum Stuff {
    /// Schlick's reflectance from this one at normal incidence.
    Metal(f64),
    /// A clear dielectric of this index.
    Glass(f64),
}

/// Entries of an albedo over cosines in (0, 1].
const NODES: usize = 48;

/// GGX microfacets, scaled for what bounces among them more than once (Turquin 2019; for glass by the inverse albedo).
#[derive(Clone, Debug)]
pub struct Rough {
    alpha: f64,
    stuff: Stuff,
    /// Scale by the cosine of the viewer, from the front and from the back.
    scale: [Vec<f64>; 2],
}

impl Rough {
    pub fn new(alpha: f64, stuff: Stuff) -> Self {
        let mut rough = Self { alpha, stuff, scale: [vec![1.0; NODES], vec![1.0; NODES]] };
        let cosines: Vec<f64> = (0..NODES).map(|k| (k as f64 + 0.5) / NODES as f64).collect();
        rough.scale = [true, false].map(|front| match stuff {
            Stuff::Glass(_) => cosines.iter().map(|c| 1.0 / rough.albedo(*c, front)).collect(),
            Stuff::Metal(_) => {
                let white = Self { stuff: Stuff::Metal(1.0), ..rough.clone() };
                let whites: Vec<f64> = cosines.iter().map(|c| white.albedo(*c, front)).collect();
                let mean = whites.iter().zip(&cosines).map(|(e, c)| e * c).sum::<f64>() * 2.0 / NODES as f64;
                let scale = |(c, e): (&f64, &f64)| {
                    let f = rough.albedo(*c, front) / e;
                    1.0 + f * mean / (1.0 - f * (1.0 - mean)) * (1.0 - e) / e
                };
                cosines.iter().zip(&whites).map(scale).collect()
            }
        });
        rough
    }

    /// What one encounter sends on of the light from all directions: the mean weight over a grid of numbers.
    fn albedo(&self, cosine: f64, front: bool) -> f64 {
        const GRID: usize = 96;
        let wo = DVec3::new((1.0 - cosine * cosine).sqrt(), 0.0, cosine);
        let at = |k: usize| (k as f64 + 0.5) / GRID as f64;
        let mut sum = 0.0;
        for i in 0..GRID {
            for j in 0..GRID {
                let h = self.normal(wo, [at(i), at(j)]);
                for (share, wi) in self.ways(wo, h, front).into_iter().flatten() {
                    sum += share * self.weight(wo, wi);
                }
            }
        }
        sum / (GRID * GRID) as f64
    }

    /// A microfacet normal that is seen from `wo` (Heitz 2018, "Sampling the GGX Distribution of Visible Normals").
    fn normal(&self, wo: DVec3, [u, v]: [f64; 2]) -> DVec3 {
        let view = DVec3::new(self.alpha * wo.x, self.alpha * wo.y, wo.z).normalize();
        let first = DVec3::new(-view.y, view.x, 0.0).try_normalize().unwrap_or(DVec3::X);
        let second = view.cross(first);
        let (x, y) = (u.sqrt() * (TAU * v).cos(), u.sqrt() * (TAU * v).sin());
        let lit = 0.5 * (1.0 + view.z);
        let y = (1.0 - lit) * (1.0 - x * x).sqrt() + lit * y;
        let n = first * x + second * y + view * (1.0 - x * x - y * y).max(0.0).sqrt();
        DVec3::new(self.alpha * n.x, self.alpha * n.y, n.z.max(0.0)).normalize()
    }

    fn eta(&self, front: bool) -> f64 {
        match self.stuff {
            Stuff::Glass(index) if front => index,
            Stuff::Glass(index) => 1.0 / index,
            Stuff::Metal(_) => 1.0,
        }
    }

    /// Where a facet sends light, by reflection and by refraction, with the share of each.
    fn ways(&self, wo: DVec3, h: DVec3, front: bool) -> [Option<(f64, DVec3)>; 2] {
        let cosine = wo.dot(h);
        if cosine <= 0.0 {
            return [None; 2];
        }
        let mirrored = h * (2.0 * cosine) - wo;
        let eta = self.eta(front);
        let (reflectance, refracted) = match self.stuff {
            Stuff::Metal(f0) => (f0 + (1.0 - f0) * (1.0 - cosine).powi(5), None),
            Stuff::Glass(_) => match dielectric(cosine, eta) {
                None => (1.0, None),
                Some((r, cosine_t)) => (r, Some((1.0 - r, h * (cosine / eta - cosine_t) - wo / eta))),
            },
        };
        [(mirrored.z > 0.0).then_some((reflectance, mirrored)), refracted.filter(|(_, wi)| wi.z < 0.0)]
    }

    /// G2 / G1(wo), without Fresnel's share.
    fn weight(&self, wo: DVec3, wi: DVec3) -> f64 {
        let a2 = self.alpha * self.alpha;
        let lambda = |w: DVec3| 0.5 * ((1.0 + a2 * (1.0 - w.z * w.z) / (w.z * w.z)).sqrt() - 1.0);
        // Height-correlated where both are above the surface.
        match wi.z > 0.0 {
            true => (1.0 + lambda(wo)) / (1.0 + lambda(wo) + lambda(wi)),
            false => 1.0 / (1.0 + lambda(wi)),
        }
    }

    /// A direction for the viewer's, both in the frame of the surface, and what the path is multiplied by.
    pub fn sample(&self, wo: DVec3, front: bool, [u, v, choice]: [f64; 3]) -> Option<(DVec3, f64)> {
        let h = self.normal(wo, [u, v]);
        let [reflected, refracted] = self.ways(wo, h, front);
        let share = reflected.map_or_else(|| refracted.map_or(1.0, |(t, _)| 1.0 - t), |(r, _)| r);
        let at = wo.z * NODES as f64 - 0.5;
        let k = (at.max(0.0) as usize).min(NODES - 2);
        let scale = &self.scale[usize::from(!front)];
        let scale = scale[k] + (scale[k + 1] - scale[k]) * (at - k as f64);
        if matches!(self.stuff, Stuff::Metal(_)) {
            let (reflectance, wi) = reflected?;
            return Some((wi, reflectance * self.weight(wo, wi) * scale));
        }
        if choice < share {
            let (_, wi) = reflected?;
            return Some((wi, self.weight(wo, wi) * scale));
        }
        let (_, wi) = refracted?;
        let eta = self.eta(front);
        Some((wi, self.weight(wo, wi) * scale / (eta * eta)))
    }
}

#[test]
fn the_albedo_of_nearly_smooth_metal_is_its_reflectance_and_rough_white_metal_is_scaled_to_white() {
    let nearly = Rough::new(0.01, Stuff::Metal(0.6));
    assert!((nearly.albedo(0.8, true) - 0.6).abs() < 2e-3);
    let rough = Rough::new(0.7, Stuff::Metal(1.0));
    let k = NODES / 2;
    let cosine = (k as f64 + 0.5) / NODES as f64;
    assert!((rough.albedo(cosine, true) * rough.scale[0][k] - 1.0).abs() < 1e-9);
}
