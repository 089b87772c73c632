//! glTF's metal-rough model as lobes.

use super::albedo::GgxAlbedo;
use super::colour::{luminance, unit, unit_colour};
use super::fresnel::{Interface, Schlick, dielectric_f0};
use super::lobe::Lobe;
use super::{Bsdf, glass_albedo};
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

/// Whether a surface of this perceptual roughness is perfectly smooth.
pub fn is_smooth(roughness: f32) -> bool {
    let roughness = unit(roughness);
    roughness * roughness < SMALLEST_ALPHA
}

/// Relative indices nearer to 1 than this are smooth whatever the roughness: refraction by microfacets spreads light
/// by about α·|η − 1|, and |wo + η wi| would cancel.
const SMALLEST_ROUGH_ETA_STEP: f32 = 1e-3;

/// What the model says at one angle, before it becomes lobes. Layers on top of it build on this as well.
pub(super) struct Base {
    /// Base colour in [0, 1].
    pub colour: Vec3,
    /// GGX α.
    pub alpha: f32,
    pub metallic: f32,
    pub transmission: f32,
    /// In [0.01, 100], or 0: everything is reflected.
    pub ior: f32,
    /// Fresnel's term of the dielectric.
    pub dielectric: Schlick,
    /// `None` for surfaces so smooth that their reflection is a delta distribution.
    pub albedo: Option<GgxAlbedo>,
    cos_o: f32,
}

impl Base {
    pub fn new(p: &MetalRoughParams, cos_o: f32) -> Self {
        let roughness = unit(p.roughness);
        let alpha = roughness * roughness;
        let specular = unit(p.specular);
        let ior = if p.ior.is_finite() && p.ior > 0.0 { p.ior.clamp(1e-2, 1e2) } else { 0.0 };
        let f0 = unit_colour(p.specular_color * dielectric_f0(ior)) * specular;
        Self {
            colour: unit_colour(p.base_color),
            alpha,
            metallic: unit(p.metallic),
            transmission: unit(p.transmission),
            ior,
            dielectric: Schlick { f0, f90: Vec3::splat(specular) },
            albedo: (alpha >= SMALLEST_ALPHA).then(|| GgxAlbedo::at(cos_o, alpha)),
            cos_o,
        }
    }

    /// What bounds a solid goes through an interface of its own; index 0 reflects everything and lets nothing in.
    pub fn solid(&self, thin_walled: bool) -> f32 {
        if thin_walled || self.ior == 0.0 { 0.0 } else { (1.0 - self.metallic) * self.transmission }
    }

    /// A Fresnel term scaled up by what multiple scattering adds, and the albedo that it gives.
    pub fn compensated(&self, fresnel: &Schlick) -> (Schlick, Vec3) {
        match &self.albedo {
            None => (*fresnel, fresnel.at(self.cos_o)),
            Some(albedo) => {
                let scale = albedo.compensation(fresnel);
                let scaled = Schlick { f0: fresnel.f0 * scale, f90: fresnel.f90 * scale };
                (scaled, albedo.single(&scaled))
            }
        }
    }

    /// The reflection of metal and of the `coat` share of the dielectric as one Fresnel term (Schlick's form is linear
    /// in F0 and F90), and its albedo; what is left of white light below the dielectric's.
    pub fn reflection(&self, coat: f32) -> (Schlick, Vec3, f32) {
        let (dielectric, below) = self.compensated(&self.dielectric);
        let (mut f0, mut f90, mut albedo) = (dielectric.f0 * coat, dielectric.f90 * coat, below * coat);
        if self.metallic > 0.0 {
            let (metal, own) = self.compensated(&Schlick { f0: self.colour, f90: Vec3::ONE });
            f0 += metal.f0 * self.metallic;
            f90 += metal.f90 * self.metallic;
            albedo += own * self.metallic;
        }
        // The largest channel, so that a tinted coat does not tint what is below with the complement.
        (Schlick { f0, f90 }, albedo, (1.0 - below.max_element()).max(0.0))
    }

    /// By how much a rough interface has to be scaled to make up for light that meets it more than once. The table is for
    /// Fresnel's own reflectance: the further the material is from that, the less is added.
    fn glass_compensation(&self, eta: f32) -> f32 {
        let physical = dielectric_f0(eta).max(1e-6);
        let (f0, f90) = (self.dielectric.f0 / physical, self.dielectric.f90.x);
        let trust = unit(f0.min_element()).min(unit(1.0 / f0.max_element())).min(f90);
        1.0 + trust * (1.0 / glass_albedo::at(self.cos_o, self.alpha, eta) - 1.0)
    }

    /// The interface of the solid share, which absorbs `1 − weight`.
    pub fn interface_lobe(&self, p: &MetalRoughParams, weight: f32) -> Lobe {
        let eta = if p.entering { self.ior } else { 1.0 / self.ior };
        let smooth = self.alpha < SMALLEST_ALPHA || (eta - 1.0).abs() < SMALLEST_ROUGH_ETA_STEP;
        let scale = if smooth { weight } else { weight * self.glass_compensation(eta) };
        let interface = Interface {
            eta,
            f0: self.dielectric.f0,
            f90: unit(p.specular),
            reflect: Vec3::splat(scale),
            transmit: self.colour * scale,
        };
        if smooth { Lobe::Dielectric { interface } } else { Lobe::RoughDielectric { alpha: self.alpha, interface } }
    }

    /// Transmission through a wall without inside, with what multiple scattering adds.
    pub fn wall_lobe(&self, tint: Vec3) -> Lobe {
        match &self.albedo {
            None => Lobe::Straight { tint },
            Some(albedo) => Lobe::RoughThinWall { alpha: self.alpha, tint: tint / albedo.white() },
        }
    }
}

impl Bsdf {
    /// The metal-rough model; `cos_o` is |wo.z|, on which the weights of the lobes under the coat depend.
    pub fn metal_rough(p: &MetalRoughParams, cos_o: f32) -> Self {
        let cos_o = unit(cos_o);
        let base = Base::new(p, cos_o);
        let not_metal = 1.0 - base.metallic;
        let solid = base.solid(p.thin_walled);
        let (reflection, albedo, below) = base.reflection(not_metal - solid);
        // Energy-conserving albedo scaling: what the coat reflects does not get below it.
        let diffuse = base.colour * (not_metal * (1.0 - base.transmission) * below);

        let mut bsdf = Self::BLACK;
        bsdf.push(Lobe::Lambert { albedo: diffuse }, cos_o);
        bsdf.push_known(reflection_lobe(base.alpha, reflection), reflection.importance(albedo));
        if p.thin_walled {
            let tint = base.colour * (not_metal * base.transmission * below);
            bsdf.push_known(base.wall_lobe(tint), luminance(tint));
        } else if solid > 0.0 {
            bsdf.push(base.interface_lobe(p, solid), cos_o);
        }
        bsdf.normalised()
    }
}

/// A reflection lobe, rough or a mirror.
pub(super) fn reflection_lobe(alpha: f32, fresnel: Schlick) -> Lobe {
    if alpha < SMALLEST_ALPHA { Lobe::Mirror { fresnel } } else { Lobe::GgxReflection { alpha, fresnel } }
}
