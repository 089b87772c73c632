//! [`Lights`] for sixteen receivers at a time. Tested, but not yet what the wavefront uses: as built now, closures in it are not
//! inlined into the code that has the instructions, and it is slower than one by one (see the record of 22 Nov 2026).

use super::area_lanes::AreaTable;
use super::clusters_lanes::ReceiverLanes;
use super::environment::Environment;
use super::lights::Lights;
use super::sample::{Group, LightReach};
use crate::geometry::Geometry;
use crate::lanes::{Floats, LANES, Lanes, Mask, V3, Words};
use kiln_formats::Scene;
use kiln_formats::scene::{AlphaMode, Surface};

/// More emissive triangles than these have no table, and are sampled one by one.
const MOST_TRIANGLES: usize = 1 << 18;
/// More lights without a place than these are sampled one by one, too.
const MOST_GLOBAL: usize = 16;
/// No triangle.
const NONE: u32 = u32::MAX;

/// Light that may arrive at sixteen points.
#[derive(Clone, Copy, Debug)]
pub struct LightSampleLanes<L: Lanes> {
    /// Where there is any.
    pub valid: L::M,
    /// Unit vectors to the light.
    pub direction: V3<L::F>,
    /// Radiance already divided by `pdf`, or the irradiance of a punctual light by the probability of its choice.
    pub weight: V3<L::F>,
    /// Solid angle density of `direction` with the choice of the light; 0 for punctual lights, which only light samples find.
    pub pdf: L::F,
    /// Where the shadow ray ends: a point, or its direction where `infinite`.
    pub target: V3<L::F>,
    /// Bound on the rounding error of a point on a triangle; zero elsewhere.
    pub error: V3<L::F>,
    /// Unit normal of the triangle.
    pub normal: V3<L::F>,
    /// The triangle that the shadow ray ends on, or `u32::MAX`.
    pub triangle: L::U,
    /// Lights at infinity.
    pub infinite: L::M,
    /// What [`Lights::pdf_triangle_lanes`] wants to know of the receiver; 0 where no triangle was chosen.
    pub total: L::F,
}

/// Tables for lanes.
#[derive(Debug, Default)]
pub(super) struct LanesTables {
    pub area: AreaTable,
    /// Emitter number of each triangle of the geometry, from the first emissive one on; `NONE` for others.
    emitter_of: Vec<u32>,
    first_triangle: u32,
    /// [`Lights::parts`] of each reach.
    parts: [Vec<[f32; 2]>; 3],
}

impl LanesTables {
    /// `None` where lights have to be sampled one by one: emission that varies over a triangle, or too many of them.
    pub fn new(scene: &Scene, geometry: &Geometry, lights: &Lights) -> Option<Self> {
        let triangles = &lights.triangles;
        let even = |triangle: &u32| {
            let material = &scene.materials[geometry.material(scene, *triangle) as usize];
            let unlit = matches!(material.surface, Surface::Unlit(_));
            !unlit && material.emission.texture.is_none() && material.alpha.mode == AlphaMode::Opaque
        };
        let many = triangles.len() > MOST_TRIANGLES || lights.global > MOST_GLOBAL;
        if many || lights.punctual.iter().any(|l| l.through_glass) || !triangles.iter().all(even) {
            return None;
        }
        let (first, last) = (triangles.first().copied().unwrap_or(0), triangles.last().copied().unwrap_or(0));
        let mut emitter_of = if triangles.is_empty() { Vec::new() } else { vec![NONE; (last - first + 1) as usize] };
        for (emitter, triangle) in triangles.iter().enumerate() {
            emitter_of[(triangle - first) as usize] = emitter as u32;
        }
        let parts = [LightReach::Punctual, LightReach::Mis, LightReach::All].map(|reach| lights.parts(reach));
        Some(Self { area: AreaTable::new(scene, geometry, triangles), emitter_of, first_triangle: first, parts })
    }

    #[inline(always)]
    fn parts(&self, reach: LightReach) -> &[[f32; 2]] {
        &self.parts[reach as usize]
    }
}

impl Lights {
    /// Whether the functions for lanes can be used. They make the same pictures in every tier.
    pub fn lanes_can(&self) -> bool {
        self.lanes.is_some()
    }

    /// As [`Lights::sample`], where `active`.
    #[inline(always)]
    pub fn sample_lanes<L: Lanes>(
        &self,
        l: L,
        receiver: &ReceiverLanes<L>,
        active: L::M,
        reach: LightReach,
        choice: L::F,
        u: [L::F; 2],
    ) -> LightSampleLanes<L> {
        let zero = l.splat(0.0);
        let nothing = V3::splat(zero);
        let mut out = LightSampleLanes {
            valid: l.first(0),
            direction: nothing,
            weight: nothing,
            pdf: zero,
            target: nothing,
            error: nothing,
            normal: nothing,
            triangle: l.word(NONE),
            infinite: l.first(0),
            total: zero,
        };
        let Some(tables) = &self.lanes else { return out };
        let start = if self.few { u[0] } else { choice };
        for (group, [low, high]) in tables.parts(reach).iter().copied().enumerate() {
            let share = high - low;
            if share <= 0.0 {
                continue;
            }
            // Alone, a group takes all numbers as they are.
            let alone = share >= 1.0;
            let here = if alone { active } else { active & start.ge(l.splat(low)) & start.lt(l.splat(high)) };
            if here.none() {
                continue;
            }
            let again = if alone { start } else { ((start - low) / share).min(l.splat(1.0 - f32::EPSILON)) };
            match self.kind(group) {
                kind @ (Group::Global(_) | Group::Local) => {
                    self.punctual_lanes(l, kind, share, receiver, here, again, u, &mut out);
                }
                Group::Triangles => {
                    let chosen = self.clusters.sample_lanes(l, receiver, here, again);
                    out.total = L::F::select(here, chosen.total, out.total);
                    let first = if self.few { chosen.again } else { u[0] };
                    let s = tables.area.sample(l, chosen.emitter, receiver.point, [first, u[1]], here);
                    let pdf = s.pdf * (chosen.probability * share);
                    let usable =
                        here & chosen.probability.gt(zero) & s.radiance.is_not_zero() & pdf.gt(zero) & pdf.is_finite();
                    let weight = s.radiance.map(|x| x / pdf);
                    out.take(usable, s.direction, weight, pdf, s.point);
                    out.error = V3::select(usable, s.error, out.error);
                    out.normal = V3::select(usable, s.normal, out.normal);
                    out.triangle = L::U::select(usable, s.triangle, out.triangle);
                }
                Group::Environment => {
                    let first = if self.few { again } else { u[0] };
                    let (direction, radiance, pdf) = self.environment_sample(l, [first, u[1]]);
                    let pdf = pdf * share;
                    let usable = here & pdf.gt(zero) & pdf.is_finite() & radiance.is_not_zero();
                    out.take(usable, direction, radiance.map(|x| x / pdf), pdf, direction);
                    out.infinite = out.infinite | usable;
                }
            }
        }
        out
    }

    /// Directions to the environment, radiance and solid angle density, without the choice.
    #[inline(always)]
    fn environment_sample<L: Lanes>(&self, l: L, u: [L::F; 2]) -> (V3<L::F>, V3<L::F>, L::F) {
        if let Some(Environment::Map(map)) = &self.environment {
            let map = map.table();
            let (direction, uv) = map.sample(l, u);
            return (direction, map.radiance(l, uv), map.pdf(l, uv));
        }
        let constant = self.environment.as_ref().map_or(glam::Vec3::ZERO, Environment::mean);
        let z = l.splat(1.0) - u[0] * 2.0;
        let r = (l.splat(1.0) - z * z).max(l.splat(0.0)).sqrt();
        let (sin, cos) = crate::lanes::functions::sin_cos_turns(u[1]);
        let radiance = V3::from_fn(|k| l.splat(constant[k]));
        (V3::new(r * cos, r * sin, z), radiance, l.splat(0.25 * std::f32::consts::FRAC_1_PI))
    }

    /// Punctual lights one by one: their fall-offs are computed in double precision.
    #[inline(always)]
    #[expect(clippy::too_many_arguments, reason = "a piece of sample_lanes")]
    fn punctual_lanes<L: Lanes>(
        &self,
        l: L,
        group: Group,
        share: f32,
        receiver: &ReceiverLanes<L>,
        here: L::M,
        again: L::F,
        u: [L::F; 2],
        out: &mut LightSampleLanes<L>,
    ) {
        let mut found = [[0.0f32; LANES]; 10];
        let (mut valid, mut infinite) = (0, 0);
        let (again, u) = (again.array(), [u[0].array(), u[1].array()]);
        let arrays = |v: V3<L::F>| v.components().map(Floats::array);
        let (points, normals) = (arrays(receiver.point), arrays(receiver.normal));
        let bits = here.bits();
        for lane in (0..LANES).filter(|lane| bits >> lane & 1 == 1) {
            let at = |v: &[[f32; LANES]; 3]| glam::Vec3::new(v[0][lane], v[1][lane], v[2][lane]);
            let place = super::Receiver { point: at(&points), normal: at(&normals), both_sides: false };
            let Some(sample) = self.sample_punctual(group, share, &place, again[lane], [u[0][lane], u[1][lane]]) else {
                continue;
            };
            valid |= 1 << lane;
            let end = match sample.target {
                super::Target::Point(point) => point,
                _ => {
                    infinite |= 1 << lane;
                    sample.direction
                }
            };
            let values = [sample.direction, sample.weight, end];
            for (k, value) in values.iter().flat_map(|v| v.to_array()).enumerate() {
                found[k][lane] = value;
            }
        }
        let vector = |k: usize| V3::new(l.load(&found[k]), l.load(&found[k + 1]), l.load(&found[k + 2]));
        out.take(l.mask(valid), vector(0), vector(3), l.splat(0.0), vector(6));
        out.infinite = out.infinite | l.mask(infinite);
    }

    /// As [`Lights::pdf_triangle`], where `active`. `total` is that of the receiver's [`LightSampleLanes`], or 0.
    #[inline(always)]
    #[expect(clippy::too_many_arguments, reason = "sixteen of everything")]
    pub fn pdf_triangle_lanes<L: Lanes>(
        &self,
        l: L,
        triangle: L::U,
        receiver: &ReceiverLanes<L>,
        point: V3<L::F>,
        total: L::F,
        active: L::M,
        reach: LightReach,
    ) -> L::F {
        let zero = l.splat(0.0);
        let (Some(tables), true) = (&self.lanes, reach != LightReach::Punctual) else { return zero };
        let place = triangle - l.word(tables.first_triangle);
        let inside = place.lt(l.word(tables.emitter_of.len() as u32));
        let emitter = l.gather_words(&tables.emitter_of, place);
        let active = active & inside & emitter.lt(l.word(NONE));
        if active.none() {
            return zero;
        }
        let emitter = L::U::select(active, emitter, l.word(0));
        let [low, high] = tables.parts(reach)[self.global + 1];
        let share = high - low;
        let chosen = self.clusters.probability_lanes(l, receiver, active, emitter, total);
        let pdf = tables.area.pdf(l, emitter, receiver.point, point, active) * (chosen * share);
        pdf.only(active & pdf.is_finite())
    }

    /// Radiance of the environment along unit vectors, and the density with which light samples make them.
    #[inline(always)]
    pub fn environment_lanes<L: Lanes>(&self, l: L, dir: V3<L::F>, reach: LightReach) -> (V3<L::F>, L::F) {
        let part = self.lanes.as_ref().and_then(|t| t.parts(reach).get(self.global + 2));
        let share = part.map_or(0.0, |[low, high]| high - low);
        match &self.environment {
            Some(Environment::Map(map)) => {
                let map = map.table();
                let uv = map.locate(l, dir);
                let pdf = if share > 0.0 { map.pdf(l, uv) * share } else { l.splat(0.0) };
                (map.radiance(l, uv), pdf)
            }
            Some(environment @ Environment::Constant(_)) => {
                let constant = environment.mean();
                let pdf = 0.25 * std::f32::consts::FRAC_1_PI * share;
                (V3::from_fn(|k| l.splat(constant[k])), l.splat(pdf))
            }
            None => (V3::splat(l.splat(0.0)), l.splat(0.0)),
        }
    }
}

impl<L: Lanes> LightSampleLanes<L> {
    #[inline(always)]
    fn take(&mut self, here: L::M, direction: V3<L::F>, weight: V3<L::F>, pdf: L::F, target: V3<L::F>) {
        self.valid = self.valid | here;
        self.direction = V3::select(here, direction, self.direction);
        self.weight = V3::select(here, weight, self.weight);
        self.pdf = L::F::select(here, pdf, self.pdf);
        self.target = V3::select(here, target, self.target);
    }
}
