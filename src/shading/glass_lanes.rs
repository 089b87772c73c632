//! A smooth interface between two dielectrics at sixteen points: twin of [`super::dielectric`].

use super::GRAZING;
use super::colour::{unit, unit_colour};
use super::fresnel::{STRAIGHT_ETA, dielectric_f0};
use super::metal_rough::MetalRoughParams;
use crate::lanes::{Floats, V3};

/// What light that meets smooth glass depends on: index on the far side over that on the viewer's, reflectance wanted at normal
/// incidence and at grazing incidence, tint of what is transmitted.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Glass {
    /// Index on the far side over index on the viewer's side.
    pub eta: f32,
    /// Reflectance at normal incidence.
    pub f0: [f32; 3],
    /// Reflectance at grazing incidence.
    pub f90: f32,
    /// Tint of what is transmitted.
    pub tint: [f32; 3],
}

/// [`Glass`] in lanes.
#[derive(Clone, Copy, Debug)]
pub struct GlassLanes<F> {
    /// As in [`Glass`].
    pub eta: F,
    /// As in [`Glass`].
    pub f0: V3<F>,
    /// As in [`Glass`].
    pub f90: F,
    /// As in [`Glass`].
    pub tint: V3<F>,
}

/// Where smooth glass sends light.
#[derive(Clone, Copy, Debug)]
pub struct GlassSample<F: Floats> {
    /// Towards the light.
    pub wi: V3<F>,
    /// f·|cos θi| over the probability.
    pub weight: V3<F>,
    /// Of this direction; 0 where the light is absorbed.
    pub probability: F,
    /// Where the light goes through.
    pub transmitted: F::Mask,
    /// (η_i/η_t)² in the weight.
    pub eta_scale: F,
}

impl Glass {
    /// Of a metal-rough surface that bounds a solid, lets all light through that it does not reflect, and is smooth.
    #[inline]
    pub fn new(p: &MetalRoughParams) -> Self {
        let (specular, ior) = (unit(p.specular), p.ior.max(1e-2).min(1e2));
        let f0 = unit_colour(p.specular_color * dielectric_f0(ior)) * specular;
        Self {
            eta: if p.entering { ior } else { 1.0 / ior },
            f0: f0.to_array(),
            f90: specular,
            tint: unit_colour(p.base_color).to_array(),
        }
    }
}

impl<F: Floats> GlassLanes<F> {
    /// Reflects or refracts for `u` in [0, 1), as [`super::dielectric::sample`] does.
    #[inline(always)]
    pub fn sample(&self, wo: V3<F>, u: F) -> GlassSample<F> {
        let (zero, one) = (u.fill(0.0), u.fill(1.0));
        let eta = self.eta;
        let cos = wo.z.max(zero).min(one);
        let cos2_t = one - (one - cos * cos) / (eta * eta);
        let total = cos2_t.le(zero);
        let cos_t = cos2_t.max(zero).sqrt();
        let parallel = (eta * cos - cos_t) / (eta * cos + cos_t);
        let perpendicular = (cos - eta * cos_t) / (cos + eta * cos_t);
        let f = (parallel * parallel + perpendicular * perpendicular) * 0.5;
        let r = (eta - 1.0) / (eta + 1.0);
        let exact_f0 = r * r;
        let rise = (f - exact_f0) / (one - exact_f0);
        let share = self.f0 + (V3::splat(self.f90) - self.f0) * rise;
        let share = V3::new(share.x.max(zero).min(one), share.y.max(zero).min(one), share.z.max(zero).min(one));
        let white = V3::splat(one);
        let reflected = V3::select(total, white, share);
        let transmitted = (white - share).times(self.tint).only(!total);
        let (r, t) = (bright(reflected), bright(transmitted));
        let probability = r / (r + t);
        let straight = (eta - 1.0).abs().lt(u.fill(STRAIGHT_ETA));
        let mirrors = u.lt(probability) & !straight;
        let inverse = one / eta;
        let refracted = V3::new(-wo.x * inverse, -wo.y * inverse, -cos_t).normalized();
        let wi = V3::select(mirrors, V3::new(-wo.x, -wo.y, wo.z), V3::select(straight, -wo, refracted));
        let eta_scale = F::select(mirrors | straight, one, inverse * inverse);
        let through = transmitted * (eta_scale / (one - probability));
        let weight = V3::select(mirrors, reflected * (one / probability), V3::select(straight, self.tint, through));
        let probability = F::select(mirrors, probability, F::select(straight, one, one - probability));
        let lost = !mirrors & !straight & t.eq(zero) | !straight & (r + t).le(zero) | wo.z.lt(u.fill(GRAZING));
        GlassSample { wi, weight, probability: probability.only(!lost), transmitted: !mirrors, eta_scale }
    }
}

/// As [`super::colour::luminance`].
#[inline(always)]
fn bright<F: Floats>(c: V3<F>) -> F {
    c.x * 0.2126 + c.y * 0.7152 + c.z * 0.0722
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lanes::{AnyLanes, LANES, Lanes, Mask, Work};
    use crate::math::simd::SimdTier;
    use crate::shading::Bsdf;
    use crate::shading::test_support::{Random, plastic};
    use glam::Vec3;

    struct Scatter(Glass, Vec3, [f32; LANES]);

    /// Direction, weight, probability, transmitted, scale.
    type Row = (Vec3, Vec3, f32, bool, f32);

    impl Work for Scatter {
        type Output = Vec<Row>;

        #[inline(always)]
        fn run<L: Lanes>(self, l: L) -> Self::Output {
            let Glass { eta, f0, f90, tint } = self.0;
            let glass =
                GlassLanes { eta: l.splat(eta), f0: l.splat_vector(f0), f90: l.splat(f90), tint: l.splat_vector(tint) };
            let s = glass.sample(l.splat_vector(self.1.to_array()), l.load(&self.2));
            let (probability, scale) = (s.probability.array(), s.eta_scale.array());
            let row = |i: usize| {
                let (wi, weight) = (s.wi.lane(i).into(), s.weight.lane(i).into());
                (wi, weight, probability[i], s.transmitted.bits() >> i & 1 == 1, scale[i])
            };
            (0..LANES).map(row).collect()
        }
    }

    #[test]
    fn lanes_are_glass_as_one_by_one() {
        let (mut random, mut through, mut back) = (Random(5), 0, 0);
        for k in 0..12 {
            let params = MetalRoughParams {
                base_color: Vec3::new(0.9, 0.8, 0.5),
                roughness: 0.0,
                transmission: 1.0,
                specular: [1.0, 0.6, 1.0][k % 3],
                ior: [1.5, 1.33, 2.4, 1.0][k % 4],
                entering: k % 2 == 0,
                ..plastic()
            };
            let glass = Glass::new(&params);
            for step in 0..40 {
                let wo = Vec3::new(0.4, -0.3, step as f32 * 0.05).normalize();
                let bsdf = Bsdf::metal_rough(&params, wo.z);
                let u = std::array::from_fn(|_| random.next());
                let all = AnyLanes::new(SimdTier::detect()).run(Scatter(glass, wo, u));
                for tier in SimdTier::ALL {
                    let others = AnyLanes::new(tier).run(Scatter(glass, wo, u));
                    assert_eq!(format!("{others:?}"), format!("{all:?}"), "{tier}");
                }
                for (i, (wi, weight, probability, transmitted, scale)) in all.into_iter().enumerate() {
                    let Some(one) = bsdf.sample(wo, u[i], [0.5; 2]) else {
                        assert_eq!(probability, 0.0);
                        continue;
                    };
                    (through, back) = (through + u32::from(transmitted), back + u32::from(!transmitted));
                    assert_eq!((one.delta, one.transmitted), (true, transmitted));
                    assert!((one.wi - wi).length() < 1e-6, "{} {wi}", one.wi);
                    assert!((one.pdf - probability).abs() < 1e-5, "{} {probability}", one.pdf);
                    assert!((one.weight - weight).length() < 1e-5 * weight.length(), "{} {weight}", one.weight);
                    assert!((one.eta_scale - scale).abs() < 1e-6 * scale);
                }
            }
        }
        assert!(through > 3000 && back > 500, "{through} {back}");
    }
}
