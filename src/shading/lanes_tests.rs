use super::*;
use crate::lanes::{AnyLanes, LANES, Lanes, Mask, Work};
use crate::math::simd::SimdTier;
use crate::math::warp;
use crate::shading::test_support::{Random, plastic};
use crate::shading::{Bsdf, ClearCoatLanes, LayerParams, MetalRoughLanes, MetalRoughParams};
use glam::Vec3;

fn splat<L: Lanes>(l: L, v: Vec3) -> V3<L::F> {
    l.splat_vector(v.to_array())
}

/// Samples of a material and its clear coat, with what [`RoughLanes::eval`] says of their directions, for one viewer and sixteen
/// numbers.
struct Scatter<'a>(&'a MetalRoughParams, Option<&'a LayerParams>, Vec3, &'a [[f32; LANES]; 3]);

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
        let wo = splat(l, self.2);
        let coat = self.1.map(|layers| ClearCoatLanes {
            strength: l.splat(layers.clearcoat),
            roughness: l.splat(layers.clearcoat_roughness),
            normal: splat(l, layers.clearcoat_normal),
            layered: if *layers == LayerParams::NONE { l.mask(0) } else { l.first(LANES) },
            own: if layers.clearcoat_normal == Vec3::Z { l.mask(0) } else { l.first(LANES) },
        });
        let lobes = params.lobes(l, wo, l.first(LANES), coat.as_ref());
        let u = self.3.map(|u| l.load(&u));
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

/// What the samples of materials were.
#[derive(Debug, Default)]
struct Seen {
    scattered: u32,
    through: u32,
    peaks: u32,
    /// The largest difference in tolerances, and where.
    worst: (f32, String),
}

impl Seen {
    fn note(&mut self, off: f32, what: impl FnOnce() -> String) {
        // Not a number is the worst.
        if !(off <= self.worst.0) {
            self.worst = (off, what());
        }
    }

    /// Compares lanes, in all tiers, with the lobes one by one, whose narrowest has this roughness.
    fn compare(&mut self, (bsdf, roughness): (&Bsdf, f32), scatter: &Scatter) {
        let Scatter(params, layers, wo, u) = *scatter;
        let run = |tier| AnyLanes::new(tier).run(Scatter(params, layers, wo, u));
        let all = run(SimdTier::detect());
        for tier in SimdTier::ALL {
            assert_eq!(format!("{:?}", run(tier)), format!("{all:?}"), "{tier}");
        }
        for (i, (wi, weight, pdf, delta, value, density)) in all.into_iter().enumerate() {
            let (expected, own) = bsdf.eval(wo, wi);
            let off = (value - expected).abs().max_element() / expected.max_element().max(1e-3);
            // A narrow lobe steepens the rounding of the half vector.
            let tolerance = 1e-5 + 4e-6 / (roughness * roughness).max(1e-3);
            let at = |what: &str| format!("{what}, lane {i}, at {wi} from {wo}, {params:?}, {layers:?}");
            self.note(off / tolerance, || at(&format!("value {value} {expected}")));
            self.note((density - own).abs() / (tolerance * own.max(1e-3)), || at(&format!("density {density} {own}")));
            match bsdf.sample(wo, u[2][i], [u[0][i], u[1][i]].map(warp::into_unit)) {
                Some(one) => {
                    self.scattered += 1;
                    self.through += u32::from(one.transmitted);
                    self.peaks += u32::from(one.delta);
                    assert_eq!(one.delta, delta);
                    assert!((one.wi - wi).length() < 1e-5, "{} {wi}", one.wi);
                    // Directions that differ by rounding have cosines that do, most at the horizon.
                    let tolerance = 2.0 * tolerance + (one.wi - wi).length() / wi.z.abs();
                    let off = (one.pdf - pdf).abs() / (tolerance * pdf.max(1e-3));
                    self.note(off, || at(&format!("pdf {pdf} {}", one.pdf)));
                    let off = (one.weight - weight).abs().max_element();
                    let off = off / (tolerance * weight.max_element().max(1e-3));
                    self.note(off, || at(&format!("weight {weight} {}", one.weight)));
                }
                None => assert!(pdf == 0.0 || weight == Vec3::ZERO || wi.z.abs() < 1e-5),
            }
        }
    }
}

fn viewers() -> impl Iterator<Item = Vec3> {
    (1..40u32).map(|step| Vec3::new(0.3, -0.2, step as f32 * 0.05).normalize())
}

#[test]
fn lanes_scatter_as_the_lobes_one_by_one() {
    let (mut seen, mut random) = (Seen::default(), Random(7));
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
        for wo in viewers() {
            let u: [[f32; LANES]; 3] = std::array::from_fn(|_| std::array::from_fn(|_| random.next()));
            let bsdf = Bsdf::metal_rough(&params, wo.z);
            seen.compare((&bsdf, roughness), &Scatter(&params, None, wo, &u));
        }
    }
    assert!(seen.worst.0 < 1.0, "{:?}", seen.worst);
    assert!(seen.scattered > 5000 && seen.through > 500 && seen.peaks > 500, "{seen:?}");
}

#[test]
fn coats_in_lanes_scatter_as_the_lobes_one_by_one() {
    let (mut seen, mut random) = (Seen::default(), Random(8));
    let tilted = Vec3::new(0.3, -0.4, 0.9).normalize();
    // Coats that are mirrors, rough, weak, none, and with normals of their own; on what is rough, smooth, and on what lets through.
    let coats = [
        (1.0, 0.0, Vec3::Z),
        (1.0, 0.3, Vec3::Z),
        (0.2, 0.7, Vec3::Z),
        (0.0, 0.3, Vec3::Z),
        (1.0, 0.0, tilted),
        (0.6, 0.4, tilted),
    ];
    for (k, (clearcoat, clearcoat_roughness, clearcoat_normal)) in coats.into_iter().enumerate() {
        for (j, roughness) in [0.5f32, 0.0, 0.25].into_iter().enumerate() {
            let params = MetalRoughParams {
                base_color: Vec3::new(0.8, 0.5, 0.1),
                metallic: [0.0, 1.0, 0.3][(k + j) % 3],
                roughness,
                specular: if k == 2 { 0.0 } else { 1.0 },
                transmission: if j == 2 { 0.7 } else { 0.0 },
                thin_walled: true,
                ..plastic()
            };
            let layers = LayerParams { clearcoat, clearcoat_roughness, clearcoat_normal, ..LayerParams::NONE };
            let narrowest = if clearcoat > 0.0 && clearcoat_roughness > 0.0 {
                roughness.min(clearcoat_roughness)
            } else {
                roughness
            };
            let narrowest = if clearcoat_normal == tilted { narrowest.min(0.03) } else { narrowest };
            for wo in viewers() {
                let u: [[f32; LANES]; 3] = std::array::from_fn(|_| std::array::from_fn(|_| random.next()));
                let bsdf = Bsdf::layered(&params, &layers, wo);
                seen.compare((&bsdf, narrowest), &Scatter(&params, Some(&layers), wo, &u));
            }
        }
    }
    assert!(seen.worst.0 < 1.0, "{:?}", seen.worst);
    assert!(seen.scattered > 8000 && seen.through > 500 && seen.peaks > 1000, "{seen:?}");
}

#[test]
fn a_coat_of_no_strength_is_none_bit_for_bit() {
    let params = MetalRoughParams { metallic: 0.3, transmission: 0.4, thin_walled: true, ..plastic() };
    let mut random = Random(9);
    for wo in viewers() {
        let u: [[f32; LANES]; 3] = std::array::from_fn(|_| std::array::from_fn(|_| random.next()));
        let run = |layers| AnyLanes::new(SimdTier::detect()).run(Scatter(&params, layers, wo, &u));
        assert_eq!(format!("{:?}", run(Some(&LayerParams::NONE))), format!("{:?}", run(None)));
    }
}
