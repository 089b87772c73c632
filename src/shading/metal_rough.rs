//! glTF's metal-rough model as lobes.

use super::colour::{unit, unit_colour};
use super::fresnel::{Interface, Schlick, dielectric_f0};
use super::lobe::Lobe;
use super::{Bsdf, albedo};
use glam::Vec3;

/// Parameters of the metal-rough model at a point, textures already looked up: glTF 2.0 with KHR_materials_specular,
/// _ior and _transmission.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MetalRoughParams {
    /// Albedo of the dielectric part, F0 of the metallic part, linear, in [0, 1].
    pub base_color: Vec3,
    /// 0 dielectric … 1 metal.
    pub metallic: f32,
    /// Perceptual roughness, in [0, 1]; GGX α is its square.
    pub roughness: f32,
    /// Strength of the dielectric reflection, in [0, 1]. 0 leaves pure Lambert.
    pub specular: f32,
    /// Tints F0 of the dielectric; may exceed 1.
    pub specular_color: Vec3,
    /// Index of refraction of the dielectric; 0 is glTF's word for "F0 = 1".
    pub ior: f32,
    /// Share of the diffuse part that is transmitted instead, in [0, 1].
    pub transmission: f32,
    /// Whether the surface is a wall without inside: transmission is not refracted.
    pub thin_walled: bool,
    /// Whether wo is on the outside (the geometric front).
    pub entering: bool,
}

/// Lobes of GGX α below this are delta distributions. Such a lobe turns light by ±2α = 0.1°, less than a pixel of a
/// 512-pixel picture with 50° field of view, and f32 half vectors (±1e-7) still resolve D to 1e-3 above it.
pub(super) const SMALLEST_ALPHA: f32 = 1e-3;

/// Relative indices nearer to 1 than this are smooth whatever the roughness: refraction by microfacets spreads light
/// by about α·|η − 1|, and |wo + η wi| would cancel.
const SMALLEST_ROUGH_ETA_STEP: f32 = 1e-3;

impl Bsdf {
    /// The metal-rough model; `cos_o` is |wo.z|, on which the weights of the lobes under the coat depend.
    pub fn metal_rough(p: &MetalRoughParams, cos_o: f32) -> Self {
        let cos_o = unit(cos_o);
        let base = unit_colour(p.base_color);
        let metallic = unit(p.metallic);
        let specular = unit(p.specular);
        let transmission = unit(p.transmission);
        let roughness = unit(p.roughness);
        let alpha = roughness * roughness;
        let ior = if p.ior.is_finite() && p.ior > 0.0 { p.ior.clamp(1e-2, 1e2) } else { 0.0 };

        let dielectric =
            Schlick { f0: unit_colour(p.specular_color * dielectric_f0(ior)) * specular, f90: Vec3::splat(specular) };
        let not_metal = 1.0 - metallic;
        // What bounds a solid goes through an interface of its own; index 0 reflects everything and lets nothing in.
        let solid = if p.thin_walled || ior == 0.0 { 0.0 } else { not_metal * transmission };
        let coat = not_metal - solid;
        // Schlick's form is linear in (F0, F90), so the metal's and the dielectric's reflection are one lobe.
        let reflection =
            Schlick { f0: base * metallic + dielectric.f0 * coat, f90: Vec3::splat(metallic) + dielectric.f90 * coat };
        // Energy-conserving albedo scaling: what the coat reflects does not get below it. The largest channel, so that
        // a tinted coat does not tint what is below with the complement.
        let under_coat = (1.0 - reflection_albedo(alpha, &dielectric, cos_o).max_element()).max(0.0);
        let diffuse = base * (not_metal * (1.0 - transmission) * under_coat);

        let mut bsdf = Self::BLACK;
        bsdf.push(Lobe::Lambert { albedo: diffuse }, cos_o);
        bsdf.push(reflection_lobe(alpha, reflection), cos_o);
        if p.thin_walled {
            let tint = base * (not_metal * transmission * under_coat);
            let smooth = alpha < SMALLEST_ALPHA;
            bsdf.push(if smooth { Lobe::Straight { tint } } else { Lobe::RoughThinWall { alpha, tint } }, cos_o);
        } else if solid > 0.0 {
            let interface = Interface {
                eta: if p.entering { ior } else { 1.0 / ior },
                f0: dielectric.f0,
                f90: specular,
                reflect: Vec3::splat(solid),
                transmit: base * solid,
            };
            let smooth = alpha < SMALLEST_ALPHA || (interface.eta - 1.0).abs() < SMALLEST_ROUGH_ETA_STEP;
            bsdf.push(
                if smooth { Lobe::Dielectric { interface } } else { Lobe::RoughDielectric { alpha, interface } },
                cos_o,
            );
        }
        bsdf.normalised()
    }
}

/// A reflection lobe, rough or a mirror.
pub(super) fn reflection_lobe(alpha: f32, fresnel: Schlick) -> Lobe {
    if alpha < SMALLEST_ALPHA { Lobe::Mirror { fresnel } } else { Lobe::GgxReflection { alpha, fresnel } }
}

fn reflection_albedo(alpha: f32, fresnel: &Schlick, cos_o: f32) -> Vec3 {
    if alpha < SMALLEST_ALPHA { fresnel.at(cos_o) } else { albedo::ggx(fresnel, cos_o, alpha) }
}
