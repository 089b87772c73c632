//! How surfaces scatter light: one lobe a file, each with `eval`, `pdf` and `sample`, and the models made of them.
//!
//! Directions are unit vectors in the shading frame (+z the shading normal). `wo` points to the viewer, `wi` to the
//! light. What is computed is for paths that start at the camera, so refracted values carry the (η_i/η_t)² of radiance:
//! it cancels on paths that leave the body again.

mod albedo;
mod anisotropic;
mod coat;
mod coat_lanes;
mod colour;
mod dielectric;
mod fresnel;
mod ggx_reflection;
mod glass_albedo;
mod glass_lanes;
mod lambert;
mod lanes;
mod layered;
mod lobe;
mod metal_rough;
mod metal_rough_lanes;
mod microfacet;
mod mirror;
mod phong;
mod rough_dielectric;
mod rough_diffuse;
mod sheen;
mod thin_film;
mod thin_wall;

#[cfg(test)]
mod chi2_tests;
#[cfg(test)]
mod double_tests;
#[cfg(test)]
mod furnace_tests;
#[cfg(test)]
mod hostile_tests;
#[cfg(test)]
mod model_tests;
#[cfg(test)]
mod test_support;

pub use coat_lanes::ClearCoatLanes;
pub use glass_lanes::{Glass, GlassLanes, GlassSample};
pub use lanes::{RoughLanes, RoughSample};
pub use layered::LayerParams;
pub use metal_rough::{MetalRoughParams, is_smooth};
pub use metal_rough_lanes::MetalRoughLanes;
pub use phong::PhongParams;

use crate::math::warp;
use glam::Vec3;
use lobe::{Lobe, Sampled};

/// The most lobes a model has: coat, sheen, reflection, that of a film, diffuse, diffuse through, through.
const MAX_LOBES: usize = 7;

/// Directions nearer to the surface than this cosine scatter nothing: there, f32 cosines are rounding errors.
const GRAZING: f32 = 1e-6;

/// The scattering at one surface point: a few weighted lobes. Built per hit; some weights hold for one `wo` only.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bsdf {
    lobes: [Lobe; MAX_LOBES],
    /// Of choosing each lobe; they add up to 1.
    probability: [f32; MAX_LOBES],
    count: usize,
}

/// A sampled direction.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BsdfSample {
    /// Towards the light.
    pub wi: Vec3,
    /// f·|cos θi| / pdf over all lobes: what the radiance from `wi` is multiplied by.
    pub weight: Vec3,
    /// Density over solid angle (1/sr), selection of the lobe included; for delta lobes the probability.
    pub pdf: f32,
    /// A delta lobe made it.
    pub delta: bool,
    /// `wi` is on the other side of the surface than `wo`.
    pub transmitted: bool,
    /// A delta lobe that passes straight on, unrefracted (thin wall, index 1).
    pub straight: bool,
    /// The (η_i/η_t)² of radiance in `weight`, 1 without refraction. Russian roulette should go by weights without it,
    /// or it kills paths inside bodies that get it back on leaving.
    pub eta_scale: f32,
}

/// Ways of sampling the smooth lobes that know nothing of them.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Baseline {
    /// Uniform over the hemisphere.
    Uniform,
    /// By the cosine.
    Cosine,
}

impl Bsdf {
    /// Scatters nothing.
    pub const BLACK: Self =
        Self { lobes: [Lobe::Lambert { albedo: Vec3::ZERO }; MAX_LOBES], probability: [0.0; MAX_LOBES], count: 0 };

    /// Adds a lobe, unless it is black; its importance is kept until [`Self::normalised`] makes probabilities of them.
    fn push(&mut self, lobe: Lobe, cos_o: f32) {
        self.push_known(lobe, lobe.importance(cos_o));
    }

    /// As [`Self::push`] for a lobe whose importance is known.
    fn push_known(&mut self, lobe: Lobe, importance: f32) {
        if importance > 0.0 && self.count < MAX_LOBES {
            self.lobes[self.count] = lobe;
            self.probability[self.count] = importance;
            self.count += 1;
        }
    }

    fn normalised(mut self) -> Self {
        let total: f32 = self.probability.iter().sum();
        if total > 0.0 {
            self.probability = self.probability.map(|p| p / total);
        }
        self
    }

    fn lobes(&self) -> impl Iterator<Item = (&Lobe, f32)> {
        self.lobes.iter().zip(self.probability).take(self.count)
    }

    /// Names of the lobes with the probability of sampling each.
    pub fn describe(&self) -> Vec<(&'static str, f32)> {
        self.lobes().map(|(lobe, probability)| (lobe.name(), probability)).collect()
    }

    /// Whether nothing scatters.
    pub fn is_black(&self) -> bool {
        self.count == 0
    }

    /// Whether some lobe is not a delta distribution, so that sampling lights makes sense.
    pub fn has_smooth(&self) -> bool {
        self.lobes().any(|(lobe, _)| lobe.is_smooth())
    }

    /// The share of light that goes straight on through a wall without inside: the mean of what [`Self::sample`] lets through so.
    pub fn straight(&self, wo: Vec3) -> Vec3 {
        let tint = |lobe: &Lobe| if let Lobe::Straight { tint } = lobe { *tint } else { Vec3::ZERO };
        if sees(wo) { self.lobes().map(|(lobe, _)| tint(lobe)).sum() } else { Vec3::ZERO }
    }

    /// f(wo, wi)·|cos θi| of the lobes that are not delta distributions, and the density over solid angle (1/sr) with
    /// which [`Self::sample`] makes `wi` by them. Zeros for `wo` below the surface: turn the frame first.
    #[inline]
    pub fn eval(&self, wo: Vec3, wi: Vec3) -> (Vec3, f32) {
        if !sees(wo) || wi.z.abs() < GRAZING {
            return (Vec3::ZERO, 0.0);
        }
        let mut value = Vec3::ZERO;
        let mut density = 0.0;
        for (lobe, probability) in self.lobes() {
            let (f, pdf) = lobe.eval(wo, wi);
            value += f;
            density += probability * pdf;
        }
        (value, density)
    }

    /// A direction for `u_lobe` and `u` in [0, 1). `None`: absorbed.
    #[inline]
    pub fn sample(&self, wo: Vec3, u_lobe: f32, u: [f32; 2]) -> Option<BsdfSample> {
        if !sees(wo) {
            return None;
        }
        let (lobe, probability, u_choice) = self.choose(warp::into_unit(u_lobe))?;
        match lobe.sample(wo, u_choice, u.map(warp::into_unit))? {
            Sampled::Delta(delta) => delta_sample(&delta, probability),
            Sampled::Smooth(wi) => {
                let (value, pdf) = self.eval(wo, wi);
                self.smooth_sample(wi, value, pdf)
            }
        }
    }

    /// As [`Self::sample`], but smooth lobes get a direction that is uniform or by the cosine over the hemisphere, or
    /// over both when some lobe transmits smoothly. The same expectation, more noise.
    pub fn sample_baseline(&self, wo: Vec3, u_lobe: f32, u: [f32; 2], baseline: Baseline) -> Option<BsdfSample> {
        if !sees(wo) {
            return None;
        }
        let (lobe, probability, u_choice) = self.choose(warp::into_unit(u_lobe))?;
        let u = u.map(warp::into_unit);
        if !lobe.is_smooth() {
            return match lobe.sample(wo, u_choice, u)? {
                Sampled::Delta(delta) => delta_sample(&delta, probability),
                Sampled::Smooth(_) => None,
            };
        }
        let mut wi = match baseline {
            Baseline::Uniform => warp::uniform_hemisphere(u),
            Baseline::Cosine => warp::cosine_hemisphere(u),
        };
        if self.transmits_smoothly() && u_choice >= 0.5 {
            wi.z = -wi.z;
        }
        let (value, _) = self.eval(wo, wi);
        self.smooth_sample(wi, value, self.baseline_pdf(wi, baseline))
    }

    /// Density over solid angle (1/sr) of [`Self::sample_baseline`] by the lobes that are not delta distributions.
    pub fn baseline_pdf(&self, wi: Vec3, baseline: Baseline) -> f32 {
        let smooth: f32 = self.lobes().filter(|(lobe, _)| lobe.is_smooth()).map(|(_, p)| p).sum();
        let both_sides = self.transmits_smoothly();
        if wi.z < 0.0 && !both_sides {
            return 0.0;
        }
        let hemisphere = match baseline {
            Baseline::Uniform => warp::UNIFORM_HEMISPHERE_PDF,
            Baseline::Cosine => warp::cosine_hemisphere_pdf(wi.z.abs()),
        };
        smooth * hemisphere * if both_sides { 0.5 } else { 1.0 }
    }

    /// The probability with which a diffuse reflection is chosen.
    pub fn diffuse_share(&self) -> f32 {
        let diffuse = |lobe: &Lobe| matches!(lobe, Lobe::Lambert { .. } | Lobe::RoughDiffuse { .. });
        self.lobes().filter(|(lobe, _)| diffuse(lobe)).map(|(_, probability)| probability).sum()
    }

    /// The sample of the smooth lobes that is `wi`, with the value and the density that [`Self::eval`] says.
    pub fn smooth_sample(&self, wi: Vec3, value: Vec3, pdf: f32) -> Option<BsdfSample> {
        let weight = value / pdf;
        let transmitted = wi.z < 0.0;
        let eta_scale = if transmitted { self.lobes().map(|(lobe, _)| lobe.rough_eta_scale()).product() } else { 1.0 };
        // Not a number is neither 0 nor absorbed: it goes on, and is counted where the path's weight is looked at.
        (!(pdf <= 0.0) && weight != Vec3::ZERO).then_some(BsdfSample {
            wi,
            weight,
            pdf,
            delta: false,
            transmitted,
            straight: false,
            eta_scale,
        })
    }

    /// Whether some lobe that is not a delta distribution sends light through the surface.
    pub fn transmits_smoothly(&self) -> bool {
        self.lobes().any(|(lobe, _)| lobe.transmits_smoothly())
    }

    /// A lobe, its probability, and what is left of `u` as a fresh number of [0, 1).
    fn choose(&self, u: f32) -> Option<(&Lobe, f32, f32)> {
        let mut below = 0.0;
        let mut chosen = None;
        for (lobe, probability) in self.lobes() {
            chosen = Some((lobe, probability, warp::into_unit((u - below) / probability)));
            below += probability;
            if u < below {
                break;
            }
        }
        chosen
    }
}

/// Whether a viewer in direction `wo` is above the surface.
fn sees(wo: Vec3) -> bool {
    wo.z >= GRAZING
}

fn delta_sample(delta: &lobe::Delta, lobe_probability: f32) -> Option<BsdfSample> {
    let pdf = lobe_probability * delta.probability;
    let weight = delta.value / pdf;
    (!(pdf <= 0.0)).then_some(BsdfSample {
        wi: delta.wi,
        weight,
        pdf,
        delta: true,
        transmitted: delta.wi.z < 0.0,
        straight: delta.straight,
        eta_scale: delta.eta_scale,
    })
}
