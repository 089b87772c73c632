//! [`super::casters`] for sixteen surface points at once.

use super::casters::{Casters, MOST_AIMED, MOST_CASTERS, OUTSIDE};
use crate::lanes::functions::sin_cos_turns;
use crate::lanes::{Floats, FrameLanes, Lanes, V3};
use std::f32::consts::{FRAC_1_PI, TAU};

/// The casters as seen from sixteen points: see [`super::casters::Cones`].
#[derive(Clone, Copy, Debug)]
pub struct ConesLanes<L: Lanes> {
    count: usize,
    axis: [V3<L::F>; MOST_CASTERS],
    cos: [L::F; MOST_CASTERS],
    narrow: [L::F; MOST_CASTERS],
    amount: [L::F; MOST_CASTERS],
    density: [L::F; MOST_CASTERS],
    aimed: L::F,
}

impl Casters {
    /// See [`Self::seen`]; nothing is aimed where `share` is 0.
    #[inline(always)]
    pub fn seen_lanes<L: Lanes>(&self, l: L, point: V3<L::F>, normal: V3<L::F>, share: L::F) -> ConesLanes<L> {
        let (zero, one): (L::F, L::F) = (l.splat(0.0), l.splat(1.0));
        let (nothing, ones) = ([zero; MOST_CASTERS], [one; MOST_CASTERS]);
        let (mut axes, mut cosines, mut narrows) = ([V3::splat(zero); MOST_CASTERS], ones, nothing);
        let (mut amounts, mut densities, mut aimed) = (nothing, nothing, zero);
        for (i, caster) in self.all().iter().enumerate() {
            let centre = V3::new(l.splat(caster.centre.x), l.splat(caster.centre.y), l.splat(caster.centre.z));
            let to = centre - point;
            let (distance2, radius2) = (to.length_squared(), caster.radius * caster.radius);
            let outside = distance2.gt(l.splat(radius2 * OUTSIDE));
            let axis = to * (one / distance2.sqrt());
            let sin2 = l.splat(radius2) / distance2;
            let (sin, cos) = (sin2.sqrt(), (one - sin2).max(zero).sqrt());
            let narrow = sin2 / (cos + 1.0);
            let facing = ((axis.dot(normal) + sin).max(zero) / (sin + 1.0)).only(outside);
            let density = facing * share * (caster.boost * FRAC_1_PI);
            (axes[i], cosines[i], narrows[i]) = (axis, cos, narrow);
            (amounts[i], densities[i]) = (density * narrow.only(outside) * TAU, density);
            aimed = aimed + amounts[i];
        }
        let most: L::F = l.splat(MOST_AIMED);
        let scale = L::F::select(aimed.gt(most), most / aimed, one);
        for i in 0..self.all().len() {
            amounts[i] = amounts[i] * scale;
            densities[i] = densities[i] * scale;
        }
        ConesLanes {
            count: self.all().len(),
            axis: axes,
            cos: cosines,
            narrow: narrows,
            amount: amounts,
            density: densities,
            aimed: aimed * scale,
        }
    }
}

impl<L: Lanes> ConesLanes<L> {
    /// Where anything is aimed.
    #[inline(always)]
    pub fn there(&self, l: L) -> L::M {
        self.aimed.gt(l.splat(0.0))
    }

    /// See [`super::casters::Cones::sample`]: where a cone is chosen, the unit vectors there, and the numbers for the others.
    #[inline(always)]
    pub fn sample(&self, l: L, u: [L::F; 2]) -> (L::M, V3<L::F>, [L::F; 2]) {
        let (zero, one): (L::F, L::F) = (l.splat(0.0), l.splat(1.0));
        let stretched = u[0] * self.whole();
        let mut left = stretched - 1.0;
        let (mut axis, mut narrow, mut part) = (V3::new(zero, zero, one), zero, zero);
        let mut chosen = zero.gt(one);
        for i in 0..self.count {
            let here = left.ge(zero) & self.amount[i].gt(zero);
            axis = V3::select(here, self.axis[i], axis);
            narrow = L::F::select(here, self.narrow[i], narrow);
            part = L::F::select(here, left / self.amount[i], part);
            chosen = chosen | here;
            left = left - self.amount[i];
        }
        // `uniform_cone`.
        let t = part.min(one) * narrow;
        let radius = (t * (l.splat(2.0) - t)).max(zero).sqrt();
        let (sin, cos) = sin_cos_turns(u[1]);
        let aimed = FrameLanes::from_normal(axis).to_world(V3::new(radius * cos, radius * sin, one - t));
        (chosen, aimed, [L::F::select(chosen, u[0], stretched), u[1]])
    }

    /// See [`super::casters::Cones::ratio`].
    #[inline(always)]
    pub fn ratio(&self, l: L, direction: V3<L::F>, pdf: L::F) -> L::F {
        let mut aimed: L::F = l.splat(0.0);
        for i in 0..self.count {
            aimed = aimed + self.density[i].only(direction.dot(self.axis[i]).ge(self.cos[i]));
        }
        pdf * self.whole() / (pdf + aimed)
    }

    /// See [`super::casters::Cones::whole`].
    #[inline(always)]
    pub fn whole(&self) -> L::F {
        self.aimed + 1.0
    }
}
