//! The commonest BSDF, diffuse and rough reflection, for sixteen surface points at once. What it computes is that of the
//! lobes one by one ([`super::lambert`], [`super::ggx_reflection`], [`super::microfacet`]), to rounding.

use super::GRAZING;
use crate::lanes::functions::{sin_cos_small, sin_cos_turns};
use crate::lanes::{Floats, V3};
use crate::math::warp::ONE_MINUS_EPSILON;
use std::f32::consts::{FRAC_1_PI, FRAC_PI_4};

/// A Lambert lobe and a GGX reflection lobe at one surface point: what [`super::Bsdf::rough`] gives.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct RoughLobes {
    /// Of the Lambert lobe.
    pub albedo: [f32; 3],
    /// GGX α of the reflection.
    pub alpha: f32,
    /// Reflectance at normal incidence.
    pub f0: [f32; 3],
    /// Reflectance at grazing incidence.
    pub f90: [f32; 3],
    /// Probability of choosing the Lambert lobe; that of the other one is the rest.
    pub diffuse_share: f32,
}

impl RoughLobes {
    /// A Lambert lobe alone.
    pub fn lambert(albedo: glam::Vec3) -> Self {
        Self { albedo: albedo.to_array(), diffuse_share: 1.0, ..Self::default() }
    }
}

/// [`RoughLobes`] in lanes.
#[derive(Clone, Copy, Debug)]
pub struct RoughLanes<F: Floats> {
    /// Of the Lambert lobe.
    pub albedo: V3<F>,
    /// GGX α.
    pub alpha: F,
    /// Reflectance at normal incidence.
    pub f0: V3<F>,
    /// Reflectance at grazing incidence.
    pub f90: V3<F>,
    /// Probability of the Lambert lobe.
    pub diffuse_share: F,
    /// Whether any lane has the reflection at all.
    pub reflects: bool,
}

impl<F: Floats> RoughLanes<F> {
    /// f·|cos θi| and the density over solid angle with which [`Self::sample`] makes `wi`.
    #[inline(always)]
    pub fn eval(&self, wo: V3<F>, wi: V3<F>) -> (V3<F>, F) {
        let zero = wo.z.fill(0.0);
        let least = wo.z.fill(GRAZING);
        let seen = wo.z.ge(least) & wi.z.ge(least);
        let lambert = wi.z * FRAC_1_PI;
        let (mut value, mut density) = (self.albedo * lambert, lambert);
        if self.reflects {
            let (ggx, pdf) = self.reflection(wo, wi);
            let has = self.diffuse_share.lt(zero.fill(1.0));
            value = value + ggx.only(has);
            density =
                F::select(has, self.diffuse_share * lambert + (zero.fill(1.0) - self.diffuse_share) * pdf, lambert);
        }
        (value.only(seen), density.only(seen))
    }

    /// f·|cos θi| and density of the reflection lobe alone, both directions above the surface.
    #[inline(always)]
    fn reflection(&self, wo: V3<F>, wi: V3<F>) -> (V3<F>, F) {
        let one = wo.z.fill(1.0);
        let h = (wo + wi).normalized();
        let a2 = self.alpha * self.alpha;
        let d = a2 * h.z * h.z + h.x * h.x + h.y * h.y;
        let distribution = (a2 * FRAC_1_PI / (d * d)).only(h.z.gt(one.fill(0.0)));
        let (stretched_o, stretched_i) = (stretched(a2, wo), stretched(a2, wi));
        let shadowing = one.fill(2.0) / (wo.z * stretched_i + wi.z * stretched_o);
        let scalar = distribution * shadowing * wi.z * 0.25;
        let m = (one - wo.dot(h)).max(one.fill(0.0)).min(one);
        let m2 = m * m;
        let fresnel = self.f0 + (self.f90 - self.f0) * (m2 * m2 * m);
        let pdf = distribution * 0.5 / (wo.z + stretched_o);
        (fresnel * scalar, pdf)
    }

    /// A direction for `u_lobe` (which matters only if something reflects) and `u` in [0, 1); it may lie below the surface: then nothing is reflected.
    #[inline(always)]
    pub fn sample(&self, wo: V3<F>, u_lobe: F, u: [F; 2]) -> V3<F> {
        let diffuse = cosine_hemisphere(u);
        if !self.reflects {
            return diffuse;
        }
        let h = self.visible_normal(wo, u);
        let reflected = (h * (wo.dot(h) * 2.0) - wo).normalized();
        V3::select(u_lobe.lt(self.diffuse_share), diffuse, reflected)
    }

    /// Dupuy & Benyoub 2023, as [`super::microfacet::sample_visible_normal`].
    #[inline(always)]
    fn visible_normal(&self, wo: V3<F>, u: [F; 2]) -> V3<F> {
        let one = wo.z.fill(1.0);
        let std = V3::new(wo.x * self.alpha, wo.y * self.alpha, wo.z).normalized();
        let u0 = u[0].min(one.fill(ONE_MINUS_EPSILON));
        let z = (one - u0) * (std.z + 1.0) - std.z;
        let sin = (one - z * z).max(one.fill(0.0)).sqrt();
        let (sin_phi, cos_phi) = sin_cos_turns(u[1]);
        let h = V3::new(sin * cos_phi, sin * sin_phi, z) + std;
        V3::new(h.x * self.alpha, h.y * self.alpha, h.z.max(one.fill(1e-7))).normalized()
    }
}

/// [`super::microfacet::stretched`], with α².
#[inline(always)]
fn stretched<F: Floats>(a2: F, w: V3<F>) -> F {
    (w.z * w.z + a2 * (w.x * w.x + w.y * w.y)).sqrt()
}

/// A direction by the cosine, by the concentric map: [`crate::math::warp::cosine_hemisphere`].
#[inline(always)]
fn cosine_hemisphere<F: Floats>(u: [F; 2]) -> V3<F> {
    let zero = u[0].fill(0.0);
    let (x, y) = (u[0] * 2.0 - 1.0, u[1] * 2.0 - 1.0);
    let flat = x.abs().gt(y.abs());
    let (long, short) = (F::select(flat, x, y), F::select(flat, y, x));
    let ratio = F::select(long.eq(zero), zero, short / long);
    let (sin, cos) = sin_cos_small(ratio * FRAC_PI_4);
    // cos(π/2 − θ) is sin θ.
    let px = long * F::select(flat, cos, sin);
    let py = long * F::select(flat, sin, cos);
    V3::new(px, py, (zero.fill(1.0) - px * px - py * py).max(zero).sqrt())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lanes::{AnyLanes, LANES, Lanes, Work};
    use crate::math::simd::SimdTier;
    use crate::math::warp;
    use crate::shading::test_support::{Random, plastic};
    use crate::shading::{Bsdf, MetalRoughParams};
    use glam::Vec3;

    fn splat<L: Lanes>(l: L, v: [f32; 3]) -> V3<L::F> {
        V3::new(l.splat(v[0]), l.splat(v[1]), l.splat(v[2]))
    }

    /// Samples and their values for one viewer and sixteen numbers.
    struct Scatter<'a>(&'a RoughLobes, Vec3, &'a [[f32; LANES]; 3]);

    impl Work for Scatter<'_> {
        type Output = Vec<(Vec3, Vec3, f32)>;

        #[inline(always)]
        fn run<L: Lanes>(self, l: L) -> Self::Output {
            let lobes = RoughLanes {
                albedo: splat(l, self.0.albedo),
                alpha: l.splat(self.0.alpha),
                f0: splat(l, self.0.f0),
                f90: splat(l, self.0.f90),
                diffuse_share: l.splat(self.0.diffuse_share),
                reflects: self.0.diffuse_share < 1.0,
            };
            let wo = splat(l, self.1.to_array());
            let u = self.2.map(|u| l.load(&u));
            let wi = lobes.sample(wo, u[2], [u[0], u[1]]);
            let (value, pdf) = lobes.eval(wo, wi);
            (0..LANES).map(|i| (wi.lane(i).into(), value.lane(i).into(), pdf.array()[i])).collect()
        }
    }

    #[test]
    fn lanes_scatter_as_the_lobes_one_by_one() {
        let (mut reflected, mut random) = (0, Random(7));
        for (k, roughness) in [0.05f32, 0.2, 0.5, 1.0, 0.4, 0.9].into_iter().enumerate() {
            let params = MetalRoughParams {
                base_color: Vec3::new(0.8, 0.5, 0.1),
                metallic: [0.0, 1.0, 0.3][k % 3],
                roughness,
                specular: if k == 5 { 0.0 } else { 1.0 },
                ..plastic()
            };
            for step in 1..40u32 {
                let wo = Vec3::new(0.3, -0.2, step as f32 * 0.05).normalize();
                let bsdf = Bsdf::metal_rough(&params, wo.z);
                let lobes = bsdf.rough().expect("two lobes at most, both rough");
                let u: [[f32; LANES]; 3] = std::array::from_fn(|_| std::array::from_fn(|_| random.next()));
                let all = AnyLanes::new(SimdTier::detect()).run(Scatter(&lobes, wo, &u));
                for (i, (wi, value, pdf)) in all.into_iter().enumerate() {
                    let (expected, density) = bsdf.eval(wo, wi);
                    let off = (value - expected).abs().max_element() / expected.max_element().max(1e-3);
                    // A narrow lobe steepens the rounding of the half vector.
                    let tolerance = 1e-5 + 4e-6 / lobes.alpha;
                    assert!(off < tolerance, "{value} {expected} at {wi}, α {}", lobes.alpha);
                    assert!((pdf - density).abs() <= tolerance * density.max(1e-3), "{pdf} {density}");
                    match bsdf.sample(wo, u[2][i], [u[0][i], u[1][i]].map(warp::into_unit)) {
                        Some(one) => {
                            reflected += 1;
                            assert!((one.wi - wi).length() < 1e-5, "{} {wi}", one.wi);
                        }
                        None => assert!(pdf == 0.0 || value == Vec3::ZERO || wi.z < 1e-5),
                    }
                }
            }
        }
        assert!(reflected > 2000);
    }
}
