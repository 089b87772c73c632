//! One lobe of a BSDF, and which functions make it.

use super::colour::luminance;
use super::fresnel::{Interface, Schlick};
use super::sheen::{self, Charlie};
use super::thin_film::ThinFilm;
use super::thin_wall::flip;
use super::{
    albedo, anisotropic, coat, dielectric, ggx_reflection, lambert, mirror, rough_dielectric, rough_diffuse, thin_wall,
};
use glam::{Vec2, Vec3};

/// A lobe with its parameters and weights.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Lobe {
    /// Diffuse reflection.
    Lambert { albedo: Vec3 },
    /// Rough reflection.
    GgxReflection { alpha: f32, fresnel: Schlick },
    /// Perfect reflection.
    Mirror { fresnel: Schlick },
    /// Smooth glass.
    Dielectric { interface: Interface },
    /// Rough glass.
    RoughDielectric { alpha: f32, interface: Interface },
    /// A smooth thin wall's transmission.
    Straight { tint: Vec3 },
    /// A rough thin wall's transmission.
    RoughThinWall { alpha: f32, tint: Vec3 },
    /// Diffuse reflection of a rough surface.
    RoughDiffuse { albedo: Vec3, roughness: f32 },
    /// Diffuse light from the other side.
    DiffuseTransmission { tint: Vec3 },
    /// Rough reflection with a grain: the roughnesses along x and y.
    GgxAnisotropic { alpha: Vec2, fresnel: Schlick },
    /// Rough reflection by a thin film on a base.
    ThinFilm { alpha: Vec2, film: ThinFilm, tint: Vec3 },
    /// A clear coat with a normal of its own.
    Coat { alpha: f32, strength: f32, normal: Vec3 },
    /// Microfibres.
    Sheen { color: Vec3, charlie: Charlie },
}

/// One direction of a delta lobe.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Delta {
    /// Towards the light.
    pub wi: Vec3,
    /// Integral of f·|cos| over the peak.
    pub value: Vec3,
    /// Probability with which this peak of the lobe was taken.
    pub probability: f32,
    /// (η_i/η_t)² in the value.
    pub eta_scale: f32,
    /// Passes straight on.
    pub straight: bool,
}

/// What sampling a lobe gives.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Sampled {
    /// A peak.
    Delta(Delta),
    /// A direction with a density.
    Smooth(Vec3),
}

impl Lobe {
    /// What it is called.
    pub fn name(&self) -> &'static str {
        match self {
            Self::Lambert { .. } => "lambert",
            Self::GgxReflection { .. } => "ggx-reflection",
            Self::Mirror { .. } => "mirror",
            Self::Dielectric { .. } => "dielectric",
            Self::RoughDielectric { .. } => "rough-dielectric",
            Self::Straight { .. } => "thin-wall",
            Self::RoughThinWall { .. } => "rough-thin-wall",
            Self::RoughDiffuse { .. } => "rough-diffuse",
            Self::DiffuseTransmission { .. } => "diffuse-transmission",
            Self::GgxAnisotropic { .. } => "anisotropic-reflection",
            Self::ThinFilm { .. } => "thin-film",
            Self::Coat { .. } => "coat",
            Self::Sheen { .. } => "sheen",
        }
    }

    /// Whether it has a density over solid angle.
    pub fn is_smooth(&self) -> bool {
        !matches!(self, Self::Mirror { .. } | Self::Dielectric { .. } | Self::Straight { .. })
    }

    /// Whether it scatters smoothly to the other side.
    pub fn transmits_smoothly(&self) -> bool {
        matches!(self, Self::RoughDielectric { .. } | Self::RoughThinWall { .. } | Self::DiffuseTransmission { .. })
    }

    /// (η_i/η_t)² in smoothly transmitted values. A model has no more than one lobe that refracts.
    pub fn rough_eta_scale(&self) -> f32 {
        match self {
            Self::RoughDielectric { interface, .. } => 1.0 / (interface.eta * interface.eta),
            _ => 1.0,
        }
    }

    /// f·|cos θi| and the density of [`Self::sample`]; zeros for delta lobes. `wo.z` > 0, `wi.z` ≠ 0.
    #[inline]
    pub fn eval(&self, wo: Vec3, wi: Vec3) -> (Vec3, f32) {
        match self {
            Self::Lambert { albedo } => (lambert::eval(*albedo, wi), lambert::pdf(wi)),
            Self::GgxReflection { alpha, fresnel } => {
                (ggx_reflection::eval(*alpha, fresnel, wo, wi), ggx_reflection::pdf(*alpha, wo, wi))
            }
            Self::RoughDielectric { alpha, interface } => {
                (rough_dielectric::eval(*alpha, interface, wo, wi), rough_dielectric::pdf(*alpha, interface, wo, wi))
            }
            Self::RoughThinWall { alpha, tint } => {
                (thin_wall::eval(*alpha, *tint, wo, wi), thin_wall::pdf(*alpha, wo, wi))
            }
            Self::Mirror { .. } | Self::Dielectric { .. } | Self::Straight { .. } => (Vec3::ZERO, 0.0),
            Self::RoughDiffuse { albedo, roughness } => {
                (rough_diffuse::eval(*albedo, *roughness, wo, wi), lambert::pdf(wi))
            }
            Self::DiffuseTransmission { tint } => (lambert::eval(*tint, flip(wi)), lambert::pdf(flip(wi))),
            Self::GgxAnisotropic { alpha, fresnel } => anisotropic::eval(*alpha, wo, wi)
                .map_or((Vec3::ZERO, 0.0), |(f, cos)| (fresnel.at(cos) * f, anisotropic::pdf(*alpha, wo, wi))),
            Self::ThinFilm { alpha, film, tint } => anisotropic::eval(*alpha, wo, wi)
                .map_or((Vec3::ZERO, 0.0), |(f, cos)| (film.at(cos) * *tint * f, anisotropic::pdf(*alpha, wo, wi))),
            Self::Coat { alpha, strength, normal } => coat::eval(*alpha, *strength, *normal, wo, wi),
            Self::Sheen { color, charlie } => (*color * charlie.eval(wo, wi), sheen::pdf(wi)),
        }
    }

    /// A direction; `None` when the light is absorbed. `wo.z` > 0.
    #[inline]
    pub fn sample(&self, wo: Vec3, u_choice: f32, u: [f32; 2]) -> Option<Sampled> {
        match self {
            Self::Lambert { .. } => Some(Sampled::Smooth(lambert::sample(u))),
            Self::GgxReflection { alpha, .. } => ggx_reflection::sample(*alpha, wo, u).map(Sampled::Smooth),
            Self::RoughDielectric { alpha, interface } => {
                rough_dielectric::sample(*alpha, interface, wo, u_choice, u).map(Sampled::Smooth)
            }
            Self::RoughThinWall { alpha, .. } => thin_wall::sample(*alpha, wo, u).map(Sampled::Smooth),
            Self::RoughDiffuse { .. } => Some(Sampled::Smooth(lambert::sample(u))),
            Self::DiffuseTransmission { .. } => Some(Sampled::Smooth(flip(lambert::sample(u)))),
            Self::GgxAnisotropic { alpha, .. } | Self::ThinFilm { alpha, .. } => {
                anisotropic::sample(*alpha, wo, u).map(Sampled::Smooth)
            }
            Self::Coat { alpha, normal, .. } => coat::sample(*alpha, *normal, wo, u).map(Sampled::Smooth),
            Self::Sheen { .. } => Some(Sampled::Smooth(sheen::sample(u))),
            Self::Mirror { fresnel } => Some(Sampled::Delta(mirror::sample(fresnel, wo))),
            Self::Dielectric { interface } => dielectric::sample(interface, wo, u_choice).map(Sampled::Delta),
            Self::Straight { tint } => Some(Sampled::Delta(thin_wall::sample_straight(*tint, wo))),
        }
    }

    /// About how much light it scatters in all, for choosing among lobes: never 0 for a lobe that scatters.
    pub fn importance(&self, cos_o: f32) -> f32 {
        match self {
            Self::Lambert { albedo } => luminance(*albedo),
            Self::GgxReflection { alpha, fresnel } => fresnel.importance(albedo::ggx(fresnel, cos_o, *alpha)),
            Self::Mirror { fresnel } => fresnel.importance(fresnel.at(cos_o)),
            Self::Dielectric { interface } | Self::RoughDielectric { interface, .. } => {
                let split = interface.split(cos_o);
                luminance(split.reflected + split.transmitted)
                    .max(0.01 * luminance(interface.reflect + interface.transmit))
            }
            Self::Straight { tint } | Self::RoughThinWall { tint, .. } | Self::DiffuseTransmission { tint } => {
                luminance(*tint)
            }
            Self::RoughDiffuse { albedo, .. } => luminance(*albedo),
            Self::GgxAnisotropic { fresnel, .. } => fresnel.importance(fresnel.at(cos_o)),
            Self::ThinFilm { film, tint, .. } => luminance(film.at(cos_o) * *tint).max(0.01 * luminance(*tint)),
            Self::Coat { strength, .. } => strength * coat::fresnel(cos_o),
            Self::Sheen { color, .. } => luminance(*color),
        }
    }
}
