//! What the models promise, at the level of pictures.

use super::test_support::*;
use super::*;

#[test]
fn without_specular_a_dielectric_is_exactly_lambert() {
    let base = Vec3::new(0.8, 0.4, 0.1);
    for roughness in [0.0, 0.3, 1.0] {
        for cos_o in [1e-3, 0.3, 1.0] {
            let p = MetalRoughParams { base_color: base, specular: 0.0, roughness, ..plastic() };
            let bsdf = Bsdf::metal_rough(&p, cos_o);
            for cos_i in [0.01f32, 0.5, 1.0] {
                let (f, pdf) = bsdf.eval(direction(cos_o, 0.3), direction(cos_i, 2.0));
                assert_eq!(f, base * (cos_i * std::f32::consts::FRAC_1_PI), "roughness {roughness}, cos {cos_o}");
                assert_eq!(pdf, cos_i * std::f32::consts::FRAC_1_PI);
            }
        }
    }
}
