use super::*;
use crate::lanes::{AnyLanes, LANES, Lanes, Mask, Work};
use crate::math::simd::SimdTier;
use crate::math::warp;
use crate::shading::test_support::{Random, plastic};
use crate::shading::{Bsdf, MetalRoughLanes, MetalRoughParams};
use glam::Vec3;

fn splat<L: Lanes>(l: L, v: Vec3) -> V3<L::F> {
    l.splat_vector(v.to_array())
}

/// Samples of a material, with what [`RoughLanes::eval`] says of their directions, for one viewer and sixteen numbers.
struct Scatter<'a>(&'a MetalRoughParams, Vec3, &'a [[f32; LANES]; 3]);

/// Direction, weight, density, delta, value and density of `eval`.
type Row = (Vec3, Vec3, f32, bool, Vec3, f32);

impl Work for Scatter<'_> {
    type Output = Vec<Row>;

    #[inline(always)]
    fn run<L: Lanes>(self, l: L) -> Self::Output {
        let p = self.0;
        let params = MetalRoughLanes {
            base_color: splat(l, p.base_color),
            metallic: l.splat(p.metallic),
            roughness: l.splat(p.roughness),
            specular: l.splat(p.specular),
            specular_color: splat(l, p.specular_color),
            ior: l.splat(p.ior),
            transmission: l.splat(p.transmission),
        };
        let wo = splat(l, self.1);
        let lobes = params.lobes(l, wo.z, l.first(LANES));
        let u = self.2.map(|u| l.load(&u));
        let s = lobes.sample(wo, u[2], [u[0], u[1]]);
        let (value, density) = lobes.eval(wo, s.wi);
        let (pdf, density, delta) = (s.pdf.array(), density.array(), s.delta.bits());
        let row = |i: usize| {
            let [wi, weight, value] = [s.wi, s.weight, value].map(|v| Vec3::from(v.lane(i)));
            (wi, weight, pdf[i], delta >> i & 1 == 1, value, density[i])
        };
        (0..LANES).map(row).collect()
    }
}

#[test]
fn lanes_scatter_as_the_lobes_one_by_one() {
    let (mut scattered, mut through, mut peaks, mut random) = (0, 0, 0, Random(7));
    for (k, roughness) in [0.05f32, 0.2, 0.5, 1.0, 0.4, 0.9, 0.0, 0.3, 0.0, 0.02, 0.6].into_iter().enumerate() {
        let params = MetalRoughParams {
            base_color: Vec3::new(0.8, 0.5, 0.1),
            metallic: [0.0, 1.0, 0.3][k % 3],
            roughness,
            specular: if k == 5 { 0.0 } else { 1.0 },
            ior: if k == 10 { 0.0 } else { 1.5 },
            transmission: if k >= 6 { 0.7 } else { 0.0 },
            thin_walled: true,
            ..plastic()
        };
        for step in 1..40u32 {
            let wo = Vec3::new(0.3, -0.2, step as f32 * 0.05).normalize();
            let bsdf = Bsdf::metal_rough(&params, wo.z);
            let u: [[f32; LANES]; 3] = std::array::from_fn(|_| std::array::from_fn(|_| random.next()));
            let all = AnyLanes::new(SimdTier::detect()).run(Scatter(&params, wo, &u));
            for tier in SimdTier::ALL {
                let others = AnyLanes::new(tier).run(Scatter(&params, wo, &u));
                assert_eq!(format!("{others:?}"), format!("{all:?}"), "{tier}");
            }
            for (i, (wi, weight, pdf, delta, value, density)) in all.into_iter().enumerate() {
                let (expected, own) = bsdf.eval(wo, wi);
                let off = (value - expected).abs().max_element() / expected.max_element().max(1e-3);
                // A narrow lobe steepens the rounding of the half vector.
                let tolerance = 1e-5 + 4e-6 / (roughness * roughness).max(1e-3);
                assert!(off < tolerance, "{value} {expected} at {wi}, roughness {roughness}");
                assert!((density - own).abs() <= tolerance * own.max(1e-3), "{density} {own}");
                match bsdf.sample(wo, u[2][i], [u[0][i], u[1][i]].map(warp::into_unit)) {
                    Some(one) => {
                        scattered += 1;
                        through += u32::from(one.transmitted);
                        peaks += u32::from(one.delta);
                        assert_eq!(one.delta, delta);
                        assert!((one.wi - wi).length() < 1e-5, "{} {wi}", one.wi);
                        assert!((one.pdf - pdf).abs() <= 2.0 * tolerance * pdf.max(1e-3), "{} {pdf}", one.pdf);
                        let off = (one.weight - weight).abs().max_element();
                        assert!(off <= 2.0 * tolerance * weight.max_element().max(1e-3), "{} {weight}", one.weight);
                    }
                    None => assert!(pdf == 0.0 || weight == Vec3::ZERO || wi.z.abs() < 1e-5),
                }
            }
        }
    }
    assert!(scattered > 5000 && through > 500 && peaks > 500, "{scattered} {through} {peaks}");
}
