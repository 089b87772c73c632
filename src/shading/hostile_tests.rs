//! Whatever goes in, numbers come out.

use super::test_support::direction;
use super::*;
use proptest::prelude::*;

/// A parameter: mostly sane, sometimes at an edge, sometimes not a number at all.
fn parameter() -> impl Strategy<Value = f32> {
    prop_oneof![
        6 => 0f32..=1.0,
        2 => prop::sample::select(vec![0.0, 1.0, 1e-8, 1e-3, 0.031_6, 0.031_7, 0.999_999_9, 1e-38]),
        1 => prop::sample::select(vec![-1.0, 2.0, 1e30, f32::MAX, f32::NAN, f32::INFINITY, f32::NEG_INFINITY]),
    ]
}

fn index() -> impl Strategy<Value = f32> {
    prop_oneof![
        2 => 0.3f32..4.0,
        1 => prop::sample::select(vec![
            0.0, 1.0, 1.0 + 1e-7, 1.0 - 1e-7, 1.000_01, 0.999_99, 1.001, 1e-30, 1e30, -1.5, f32::NAN, f32::INFINITY
        ]),
    ]
}

fn colour() -> impl Strategy<Value = Vec3> {
    [parameter(), parameter(), parameter()].prop_map(Vec3::from_array)
}

/// Any unit vector, with poles, the horizon and its neighbourhood favoured.
fn unit_vector() -> impl Strategy<Value = Vec3> {
    let cos = prop_oneof![
        2 => -1f32..=1.0,
        1 => prop::sample::select(vec![
            1.0, -1.0, 0.0, -0.0, 1e-3, 1e-5, 1e-6, 1.1e-6, 1e-7, 1e-20, 1e-40, -1e-6, -1e-40, 0.999_999_9
        ]),
    ];
    (cos, 0f32..7.0).prop_map(|(cos, phi)| direction(cos, phi))
}

/// A random number, the ends and their neighbours favoured.
fn random_number() -> impl Strategy<Value = f32> {
    let edges = vec![0.0, warp::ONE_MINUS_EPSILON, 1.0, 0.5, 1e-8, f32::MIN_POSITIVE, 0.25, 0.75];
    prop_oneof![2 => 0f32..1.0, 1 => prop::sample::select(edges)]
}

fn metal_rough() -> impl Strategy<Value = MetalRoughParams> {
    ((colour(), parameter(), parameter(), parameter(), colour()), (index(), parameter(), any::<bool>(), any::<bool>()))
        .prop_map(|((base_color, metallic, roughness, specular, specular_color), rest)| {
            let (ior, transmission, thin_walled, entering) = rest;
            MetalRoughParams {
                base_color,
                metallic,
                roughness,
                specular,
                specular_color,
                ior,
                transmission,
                thin_walled,
                entering,
            }
        })
}

fn layers() -> impl Strategy<Value = LayerParams> {
    let coat = (parameter(), parameter(), unit_vector());
    let film = (parameter(), index(), prop_oneof![3 => 0f32..2000.0, 1 => parameter()]);
    let rest = (colour(), parameter(), parameter(), parameter(), colour(), parameter());
    (coat, film, rest).prop_map(|((clearcoat, clearcoat_roughness, clearcoat_normal), film, rest)| {
        let (iridescence, iridescence_ior, iridescence_thickness) = film;
        let (sheen_color, sheen_roughness, anisotropy, diffuse_transmission, through, diffuse_roughness) = rest;
        LayerParams {
            clearcoat,
            clearcoat_roughness,
            clearcoat_normal,
            sheen_color,
            sheen_roughness,
            iridescence,
            iridescence_ior,
            iridescence_thickness,
            anisotropy,
            diffuse_transmission,
            diffuse_transmission_color: through,
            diffuse_roughness,
        }
    })
}

fn phong() -> impl Strategy<Value = PhongParams> {
    let exponent = prop_oneof![3 => 0f32..1000.0, 1 => parameter(), 1 => 1e4f32..1e9];
    (colour(), colour(), exponent, colour(), [colour(), colour()], index(), any::<bool>()).prop_map(
        |(diffuse, specular, exponent, mirror, [transmission, through], ior, entering)| PhongParams {
            diffuse,
            specular,
            exponent,
            mirror,
            transmission,
            through,
            ior,
            entering,
        },
    )
}

fn finite_everywhere(bsdf: &Bsdf, wo: Vec3, wi: Vec3, u_lobe: f32, u: [f32; 2]) -> Result<(), TestCaseError> {
    let sane = |value: Vec3, pdf: f32| value.is_finite() && value.min_element() >= 0.0 && pdf.is_finite() && pdf >= 0.0;
    let (value, pdf) = bsdf.eval(wo, wi);
    prop_assert!(sane(value, pdf), "eval: {value}, pdf {pdf}");
    prop_assert!(bsdf.lobes().all(|(_, p)| p > 0.0 && p <= 1.0), "{bsdf:?}");
    let samples = [
        bsdf.sample(wo, u_lobe, u),
        bsdf.sample_baseline(wo, u_lobe, u, Baseline::Uniform),
        bsdf.sample_baseline(wo, u_lobe, u, Baseline::Cosine),
    ];
    for s in samples.into_iter().flatten() {
        prop_assert!(sane(s.weight, s.pdf) && s.pdf > 0.0, "{s:?}");
        prop_assert!((s.wi.length() - 1.0).abs() < 1e-5, "{s:?}");
        prop_assert!(s.eta_scale.is_finite() && s.eta_scale > 0.0, "{s:?}");
        if !s.delta {
            let (value, pdf) = bsdf.eval(wo, s.wi);
            prop_assert!(sane(value, pdf), "eval at {s:?}: {value}, pdf {pdf}");
        }
    }
    Ok(())
}

fn config() -> ProptestConfig {
    let rng_seed = proptest::test_runner::RngSeed::Fixed(1);
    ProptestConfig { cases: 50_000, failure_persistence: None, rng_seed, ..ProptestConfig::default() }
}

proptest! {
    #![proptest_config(config())]

    #[test]
    fn metal_rough_is_finite(
        p in metal_rough(),
        wo in unit_vector(),
        wi in unit_vector(),
        u_lobe in random_number(),
        u in [random_number(), random_number()],
    ) {
        finite_everywhere(&Bsdf::metal_rough(&p, wo.z.abs()), wo, wi, u_lobe, u)?;
    }

    #[test]
    fn layers_are_finite(
        p in metal_rough(),
        layers in layers(),
        wo in unit_vector(),
        wi in unit_vector(),
        u_lobe in random_number(),
        u in [random_number(), random_number()],
    ) {
        finite_everywhere(&Bsdf::layered(&p, &layers, wo), wo, wi, u_lobe, u)?;
    }

    #[test]
    fn phong_is_finite(
        p in phong(),
        wo in unit_vector(),
        wi in unit_vector(),
        u_lobe in random_number(),
        u in [random_number(), random_number()],
    ) {
        finite_everywhere(&Bsdf::phong(&p, wo.z.abs()), wo, wi, u_lobe, u)?;
    }
}
