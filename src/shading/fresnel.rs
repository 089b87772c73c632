//! How much of the light an interface reflects.

use super::colour::luminance;
use glam::Vec3;

/// Schlick's approximation F0 + (F90 − F0)(1 − cos θ)⁵, with F90 free as in KHR_materials_specular.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Schlick {
    /// Reflectance at normal incidence, in [0, 1].
    pub f0: Vec3,
    /// Reflectance at grazing incidence, in [0, 1].
    pub f90: Vec3,
}

impl Schlick {
    /// The same reflectance at every angle.
    pub fn constant(colour: Vec3) -> Self {
        Self { f0: colour, f90: colour }
    }

    /// Reflectance for the cosine between direction and (micro)normal.
    #[inline]
    pub fn at(&self, cos: f32) -> Vec3 {
        self.f0 + (self.f90 - self.f0) * schlick_weight(cos)
    }

    /// Importance of a lobe with this term that scatters `estimate` in all. Where the term is 0 at one angle (F0 = 0) the
    /// lobe may still scatter at others.
    pub fn importance(&self, estimate: Vec3) -> f32 {
        luminance(estimate).max(0.01 * luminance(self.f0.max(self.f90)))
    }
}

/// (1 − cos)⁵.
#[inline]
pub fn schlick_weight(cos: f32) -> f32 {
    let m = (1.0 - cos).clamp(0.0, 1.0);
    let m2 = m * m;
    m2 * m2 * m
}

/// Fresnel's equations for unpolarised light that meets a dielectric at `cos` ∈ [0, 1] to the normal, `eta` = index on
/// the far side over index on the near side. Gives the reflectance and the cosine on the far side; `None` for total
/// reflection (pbr-book 4ed, 9.3.5).
#[inline]
pub fn dielectric(cos: f32, eta: f32) -> Option<(f32, f32)> {
    let cos = cos.clamp(0.0, 1.0);
    if eta == 1.0 {
        return Some((0.0, cos));
    }
    let cos2_t = 1.0 - (1.0 - cos * cos) / (eta * eta);
    if cos2_t <= 0.0 {
        return None;
    }
    let cos_t = cos2_t.sqrt();
    // cos_t > 0, so neither sum is 0.
    let parallel = (eta * cos - cos_t) / (eta * cos + cos_t);
    let perpendicular = (cos - eta * cos_t) / (cos + eta * cos_t);
    Some((0.5 * (parallel * parallel + perpendicular * perpendicular), cos_t))
}

/// Reflectance at normal incidence of a dielectric of relative index `eta` ≥ 0; the same seen from either side.
#[inline]
pub fn dielectric_f0(eta: f32) -> f32 {
    let r = (eta - 1.0) / (eta + 1.0);
    r * r
}

/// An interface between two dielectrics: exact Fresnel, with the artist's weights of KHR_materials_specular on top.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Interface {
    /// Index on the far side over index on the viewer's side; positive.
    pub eta: f32,
    /// Reflectance wanted at normal incidence (`dielectric_f0(eta)` is physical), in [0, 1].
    pub f0: Vec3,
    /// Reflectance wanted where Fresnel's reaches 1 (1 is physical), in [0, 1].
    pub f90: f32,
    /// Multiplies what is reflected.
    pub reflect: Vec3,
    /// Multiplies what is transmitted.
    pub transmit: Vec3,
}

/// What an interface does with light at one angle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Split {
    /// Reflected share.
    pub reflected: Vec3,
    /// Transmitted share (of power: without the (η_i/η_t)² of radiance).
    pub transmitted: Vec3,
    /// Cosine on the far side; 0 for total reflection.
    pub cos_t: f32,
}

impl Interface {
    /// A physical interface without tints.
    #[cfg(test)]
    pub fn clear(eta: f32) -> Self {
        Self { eta, f0: Vec3::splat(dielectric_f0(eta)), f90: 1.0, reflect: Vec3::ONE, transmit: Vec3::ONE }
    }

    /// The shares at `cos` between direction and (micro)normal. `reflected + transmitted` ≤ 1 where the tints are.
    ///
    /// The exact reflectance F goes to F0' + (F90' − F0')·(F − F0)/(1 − F0), which is F itself when F0' = F0, F90' = 1.
    /// Total reflection stays total, whatever is wanted: the light has nowhere else to go.
    #[inline]
    pub fn split(&self, cos: f32) -> Split {
        let Some((f, cos_t)) = dielectric(cos, self.eta) else {
            return Split { reflected: self.reflect, transmitted: Vec3::ZERO, cos_t: 0.0 };
        };
        let exact_f0 = dielectric_f0(self.eta);
        let rise = (f - exact_f0) / (1.0 - exact_f0);
        let share = (self.f0 + (Vec3::splat(self.f90) - self.f0) * rise).clamp(Vec3::ZERO, Vec3::ONE);
        Split { reflected: share * self.reflect, transmitted: (Vec3::ONE - share) * self.transmit, cos_t }
    }

    /// Whether light passes as if nothing were there.
    pub fn is_straight(&self) -> bool {
        (self.eta - 1.0).abs() < STRAIGHT_ETA
    }
}

/// Relative indices this near to 1 bend a ray by less than f32 directions resolve well, and reflect less than 1e-11.
pub const STRAIGHT_ETA: f32 = 5e-6;
