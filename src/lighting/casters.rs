//! Bodies that cast caustics, as something to aim at.
//!
//! Light that reaches a diffuse surface by way of glass or metal is met by chance alone: a path has to hit the body, and the body has to
//! send it on to a lamp. The second chance is the body's, but the first can be improved on: part of the directions from a diffuse surface
//! are uniform in the cones around such bodies, as photon maps send their photons to them (Jensen 1996, "Global Illumination using Photon
//! Maps", projection maps). The rest are the surface's own. The density of a direction ω is that of the mixture,
//!
//! p(ω) = (p_bsdf(ω) + Σ e_i [ω in cone i]) / (1 + Σ e_i Ω_i),
//!
//! whichever way it was made (Veach 1997, 9.2.4, one-sample model with the balance heuristic), so that no sample weighs more than
//! 1 + Σ e_i Ω_i ≤ 1 + [`MOST_AIMED`] times what it would weigh without.

use crate::math::Frame;
use crate::math::warp::uniform_cone;
use glam::Vec3;
use std::f32::consts::{FRAC_1_PI, TAU};

/// More bodies than this are not aimed at.
pub const MOST_CASTERS: usize = 8;

/// The most of what is aimed, over what is not. Beside a large body nearly all directions are within its cone anyway.
pub(super) const MOST_AIMED: f32 = 0.5;

/// How far outside a body's sphere a point has to be, in squares of its radius: from nearer its cone is a hemisphere or more.
pub(super) const OUTSIDE: f32 = 1.02;

/// A body to aim at.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Caster {
    /// Centre of a sphere around it.
    pub centre: Vec3,
    /// Radius of that.
    pub radius: f32,
    /// How many times as many directions go to it as a diffuse surface would send, about.
    pub boost: f32,
}

/// All bodies of a scene that are aimed at.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Casters {
    all: Vec<Caster>,
}

/// A caster as seen from a point.
#[derive(Clone, Copy, Debug, Default)]
struct Cone {
    /// Towards the centre.
    axis: Vec3,
    /// Cosine of half of the opening angle.
    cos: f32,
    /// 1 − `cos`, without cancellation.
    narrow: f32,
    /// What is aimed there, over what is not.
    amount: f32,
    /// That over the solid angle.
    density: f32,
}

/// The casters as seen from a point on a surface.
#[derive(Clone, Copy, Debug)]
pub struct Cones {
    cones: [Cone; MOST_CASTERS],
    count: usize,
    /// All that is aimed, over what is not; greater than 0.
    aimed: f32,
}

impl Casters {
    /// The first [`MOST_CASTERS`] of these.
    pub fn new(mut all: Vec<Caster>) -> Self {
        all.truncate(MOST_CASTERS);
        Self { all }
    }

    /// Whether there is nothing to aim at.
    pub fn is_empty(&self) -> bool {
        self.all.is_empty()
    }

    /// The casters.
    pub fn all(&self) -> &[Caster] {
        &self.all
    }

    /// The cones as seen from `point` on a surface with this unit normal, whose diffuse lobe is chosen with the probability `share`; `None`
    /// where nothing is aimed.
    pub fn seen(&self, point: Vec3, normal: Vec3, share: f32) -> Option<Cones> {
        let mut cones = Cones { cones: [Cone::default(); MOST_CASTERS], count: self.all.len(), aimed: 0.0 };
        for (cone, caster) in cones.cones.iter_mut().zip(&self.all) {
            let to = caster.centre - point;
            let (distance2, radius2) = (to.length_squared(), caster.radius * caster.radius);
            if !(distance2 > radius2 * OUTSIDE) {
                continue;
            }
            let axis = to * (1.0 / distance2.sqrt());
            let sin2 = radius2 / distance2;
            let (sin, cos) = (sin2.sqrt(), (1.0 - sin2).max(0.0).sqrt());
            let narrow = sin2 / (cos + 1.0);
            // About the mean cosine over the part above the surface.
            let facing = (axis.dot(normal) + sin).max(0.0) / (sin + 1.0);
            let density = facing * share * (caster.boost * FRAC_1_PI);
            *cone = Cone { axis, cos, narrow, amount: density * narrow * TAU, density };
            cones.aimed += cone.amount;
        }
        if !(cones.aimed > 0.0) {
            return None;
        }
        if cones.aimed > MOST_AIMED {
            let scale = MOST_AIMED / cones.aimed;
            for cone in &mut cones.cones[..cones.count] {
                cone.amount *= scale;
                cone.density *= scale;
            }
            cones.aimed *= scale;
        }
        Some(cones)
    }
}

impl Cones {
    /// A unit vector in one of the cones, for `u` in [0, 1); or the numbers that the surface's own direction is made of. The first number
    /// chooses and is stretched over what it has chosen: directions stay as well distributed as the numbers are.
    pub fn sample(&self, u: [f32; 2]) -> Result<Vec3, [f32; 2]> {
        let mut left = u[0] * self.whole();
        if left < 1.0 {
            return Err([left, u[1]]);
        }
        left -= 1.0;
        let mut chosen = (&self.cones[0], 0.0);
        for cone in &self.cones[..self.count] {
            if left >= 0.0 && cone.amount > 0.0 {
                chosen = (cone, left);
            }
            left -= cone.amount;
        }
        let (Cone { axis, narrow, amount, .. }, left) = chosen;
        Ok(Frame::from_normal(*axis).to_world(uniform_cone([(left / amount).min(1.0), u[1]], *narrow)))
    }

    /// What a direction's weight is multiplied by that the surface's own lobes make with the density `pdf` over solid angle: `pdf` over the
    /// density of the mixture. For a delta lobe, which no cone can make, that of the choice: [`Self::whole`].
    pub fn ratio(&self, direction: Vec3, pdf: f32) -> f32 {
        let within = |cone: &&Cone| direction.dot(cone.axis) >= cone.cos;
        let aimed: f32 = self.cones[..self.count].iter().filter(within).map(|cone| cone.density).sum();
        pdf * self.whole() / (pdf + aimed)
    }

    /// One over the probability that a direction is the surface's own.
    pub fn whole(&self) -> f32 {
        1.0 + self.aimed
    }
}

#[cfg(test)]
#[path = "casters_tests.rs"]
mod tests;
