//! Shared by the tests of this module.

use super::fresnel::{Interface, Schlick};
use super::lobe::Lobe;
use super::sheen::Charlie;
use super::thin_film::ThinFilm;
use super::{Bsdf, LayerParams, MetalRoughParams, PhongParams};
use glam::{Vec2, Vec3};

/// Numbers for tests: SplitMix64 (Steele et al. 2014).
pub struct Random(pub u64);

impl Random {
    /// Uniform over the multiples of 2⁻²⁴ in [0, 1).
    pub fn next(&mut self) -> f32 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) >> 40) as f32 / 16_777_216.0
    }

    /// A point of the unit square.
    pub fn square(&mut self) -> [f32; 2] {
        [self.next(), self.next()]
    }
}

/// A white dielectric of index 1.5.
pub fn plastic() -> MetalRoughParams {
    MetalRoughParams {
        base_color: Vec3::ONE,
        metallic: 0.0,
        roughness: 0.5,
        specular: 1.0,
        specular_color: Vec3::ONE,
        ior: 1.5,
        transmission: 0.0,
        thin_walled: false,
        entering: true,
    }
}

/// A black `.ray` material of index 1.5.
pub fn black_phong() -> PhongParams {
    PhongParams {
        diffuse: Vec3::ZERO,
        specular: Vec3::ZERO,
        exponent: 20.0,
        mirror: Vec3::ZERO,
        transmission: Vec3::ZERO,
        through: Vec3::ONE,
        ior: 1.5,
        entering: true,
    }
}

/// A unit vector by its cosine and azimuth.
pub fn direction(cos: f32, phi: f32) -> Vec3 {
    let sin = (1.0 - cos * cos).max(0.0).sqrt();
    Vec3::new(sin * libm::cosf(phi), sin * libm::sinf(phi), cos)
}

/// A BSDF of one lobe.
pub fn only(lobe: Lobe) -> Bsdf {
    let mut bsdf = Bsdf::BLACK;
    bsdf.push(lobe, 1.0);
    bsdf.normalised()
}

/// Every kind of smooth lobe, white, with its name.
pub fn smooth_lobes(alpha: f32) -> Vec<(String, Lobe)> {
    let fresnel = Schlick::constant(Vec3::ONE);
    vec![
        ("lambert".into(), Lobe::Lambert { albedo: Vec3::ONE }),
        (format!("GGX reflection, α {alpha}"), Lobe::GgxReflection { alpha, fresnel }),
        (format!("rough thin wall, α {alpha}"), Lobe::RoughThinWall { alpha, tint: Vec3::ONE }),
        (
            format!("rough dielectric from outside, α {alpha}"),
            Lobe::RoughDielectric { alpha, interface: Interface::clear(1.5) },
        ),
        (
            format!("rough dielectric from inside, α {alpha}"),
            Lobe::RoughDielectric { alpha, interface: Interface::clear(1.0 / 1.5) },
        ),
    ]
}

/// Materials that mix lobes of every kind, with their names.
pub fn mixed_materials(cos_o: f32) -> Vec<(&'static str, Bsdf)> {
    let tint = Vec3::new(0.9, 0.6, 0.3);
    let metal_rough = |p: MetalRoughParams| Bsdf::metal_rough(&p, cos_o);
    let phong = |p: PhongParams| Bsdf::phong(&p, cos_o);
    let base = MetalRoughParams { base_color: tint, ..plastic() };
    vec![
        ("plastic", metal_rough(base)),
        ("half metal", metal_rough(MetalRoughParams { metallic: 0.5, roughness: 0.4, ..base })),
        ("polished plastic", metal_rough(MetalRoughParams { roughness: 0.0, ..base })),
        ("frosted glass", metal_rough(MetalRoughParams { transmission: 1.0, roughness: 0.6, ..base })),
        ("frosted glass from inside", {
            metal_rough(MetalRoughParams { transmission: 1.0, roughness: 0.6, entering: false, ..base })
        }),
        ("half transmissive", metal_rough(MetalRoughParams { transmission: 0.5, metallic: 0.2, ..base })),
        ("clear half transmissive", metal_rough(MetalRoughParams { transmission: 0.5, roughness: 0.0, ..base })),
        ("thin frosted wall", metal_rough(MetalRoughParams { transmission: 0.7, thin_walled: true, ..base })),
        ("thin clear wall", {
            metal_rough(MetalRoughParams { transmission: 0.7, thin_walled: true, roughness: 0.0, ..base })
        }),
        ("weak glass reflection", {
            metal_rough(MetalRoughParams { transmission: 1.0, roughness: 0.5, specular: 0.3, ..base })
        }),
        ("index 0", metal_rough(MetalRoughParams { ior: 0.0, transmission: 0.5, ..base })),
        ("Phong with mirror", {
            phong(PhongParams { diffuse: tint, specular: Vec3::ONE, mirror: Vec3::splat(0.2), ..black_phong() })
        }),
        ("Phong body", {
            phong(PhongParams { diffuse: tint * 0.2, transmission: Vec3::ONE, mirror: tint, ..black_phong() })
        }),
        ("Phong body from inside", {
            let p = PhongParams { diffuse: tint * 0.2, transmission: Vec3::ONE, ..black_phong() };
            phong(PhongParams { entering: false, ..p })
        }),
    ]
}

/// Every kind of smooth lobe of the layers, with its name.
pub fn layer_lobes() -> Vec<(String, Lobe)> {
    let fresnel = Schlick::constant(Vec3::ONE);
    let film = ThinFilm { ior: 1.6, thickness: 420.0, base_f0: Vec3::splat(0.3) };
    vec![
        ("rough diffuse".into(), Lobe::RoughDiffuse { albedo: Vec3::splat(0.9), roughness: 0.8 }),
        ("diffuse transmission".into(), Lobe::DiffuseTransmission { tint: Vec3::ONE }),
        ("anisotropic".into(), Lobe::GgxAnisotropic { alpha: Vec2::new(0.6, 0.1), fresnel }),
        ("across".into(), Lobe::GgxAnisotropic { alpha: Vec2::new(0.05, 1.0), fresnel }),
        ("thin film".into(), Lobe::ThinFilm { alpha: Vec2::splat(0.3), film, tint: Vec3::ONE }),
        ("coat".into(), Lobe::Coat { alpha: 0.2, strength: 1.0, normal: direction(0.95, 2.0) }),
        ("sheen".into(), Lobe::Sheen { color: Vec3::ONE, charlie: Charlie::new(0.4) }),
    ]
}

/// Materials with layers, as white as can be, with their names.
pub fn layered_materials() -> Vec<(&'static str, MetalRoughParams, LayerParams)> {
    let none = LayerParams::NONE;
    let coat = LayerParams { clearcoat: 1.0, ..none };
    let film = LayerParams { iridescence: 1.0, iridescence_ior: 1.8, iridescence_thickness: 350.0, ..none };
    let metal = MetalRoughParams { metallic: 1.0, ..plastic() };
    let glass = MetalRoughParams { transmission: 1.0, ..plastic() };
    vec![
        ("polished coat", plastic(), coat),
        ("rough coat on metal", metal, LayerParams { clearcoat_roughness: 0.6, ..coat }),
        (
            "bent coat",
            plastic(),
            LayerParams { clearcoat_normal: direction(0.9, 1.0), clearcoat_roughness: 0.3, ..coat },
        ),
        ("cloth", plastic(), LayerParams { sheen_color: Vec3::ONE, sheen_roughness: 0.4, ..none }),
        ("coated cloth", plastic(), LayerParams { sheen_color: Vec3::ONE, sheen_roughness: 0.7, ..coat }),
        ("soap film", plastic(), film),
        ("half a film on metal", metal, LayerParams { iridescence: 0.5, ..film }),
        ("film on glass", glass, film),
        ("brushed metal", metal, LayerParams { anisotropy: 0.7, ..none }),
        ("brushed plastic with a film", plastic(), LayerParams { anisotropy: 0.4, ..film }),
        ("leaf", plastic(), LayerParams { diffuse_transmission: 0.6, ..none }),
        ("sandstone", plastic(), LayerParams { diffuse_roughness: 1.0, ..none }),
        (
            "everything",
            MetalRoughParams { transmission: 0.4, metallic: 0.2, ..plastic() },
            LayerParams {
                clearcoat: 0.5,
                clearcoat_roughness: 0.2,
                clearcoat_normal: direction(0.97, 4.0),
                sheen_color: Vec3::new(0.8, 0.4, 0.1),
                sheen_roughness: 0.5,
                iridescence: 0.5,
                iridescence_ior: 1.4,
                iridescence_thickness: 500.0,
                anisotropy: 0.5,
                diffuse_transmission: 0.3,
                diffuse_transmission_color: Vec3::new(0.2, 0.9, 0.1),
                diffuse_roughness: 0.5,
            },
        ),
    ]
}
