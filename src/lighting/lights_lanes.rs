//! [`Lights`] for sixteen receivers at a time: what the wavefront uses.

use super::area_lanes::{AreaTable, Emission};
use super::clusters_lanes::{LightRoom, ReceiverLanes};
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
}

/// Tables for lanes.
#[derive(Debug, Default)]
pub(super) struct LanesTables {
    pub area: AreaTable,
    /// [`Lights::parts`] of each reach.
    parts: [Vec<[f32; 2]>; 3],
}

impl LanesTables {
    /// `None` where lights have to be sampled one by one: light through bodies, or too many lights.
    pub fn new(scene: &Scene, geometry: &Geometry, lights: &Lights) -> Option<Self> {
        let triangles = &lights.triangles;
        let even = |triangle: &u32| {
            let material = &scene.materials[geometry.material(scene, *triangle) as usize];
            let unlit = matches!(material.surface, Surface::Unlit(_));
            !unlit && material.emission.texture.is_none() && material.alpha.mode == AlphaMode::Opaque
        };
        let many = triangles.len() > MOST_TRIANGLES || lights.global > MOST_GLOBAL;
        if many || lights.punctual.iter().any(|l| l.through_glass) {
            return None;
        }
        let parts = [LightReach::Punctual, LightReach::Mis, LightReach::All].map(|reach| lights.parts(reach));
        Some(Self {
            area: AreaTable::new(scene, geometry, &lights.emitters, triangles, !triangles.iter().all(even)),
            parts,
        })
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
    #[expect(clippy::too_many_arguments, reason = "sixteen of everything")]
    pub fn sample_lanes<L: Lanes>(
        &self,
        l: L,
        (scene, geometry): (&Scene, &Geometry),
        receiver: &ReceiverLanes<L>,
        active: L::M,
        reach: LightReach,
        choice: L::F,
        u: [L::F; 2],
        room: &mut LightRoom,
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
                    self.punctual_lanes(l, kind, share, receiver, here, again, u, room, &mut out);
                }
                Group::Triangles => {
                    let chosen = self.clusters.sample_lanes(l, receiver, here, again, room);
                    let first = if self.few { chosen.again } else { u[0] };
                    let s = tables.area.sample(
                        l,
                        Emission { emitters: &self.emitters, scene, geometry },
                        chosen.emitter,
                        receiver.point,
                        [first, u[1]],
                        here,
                    );
                    let pdf = s.pdf * (chosen.probability * share);
                    let usable =
                        here & chosen.probability.gt(zero) & s.radiance.is_not_zero() & pdf.gt(zero) & pdf.is_finite();
                    let weight = s.radiance / pdf;
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
                    out.take(usable, direction, radiance / pdf, pdf, direction);
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
        let radiance = l.splat_vector(constant.into());
        (V3::new(r * cos, r * sin, z), radiance, l.splat(0.25 * std::f32::consts::FRAC_1_PI))
    }

    /// Punctual lights: chosen in lanes, and then one by one, since their fall-offs are computed in double precision.
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
        room: &mut LightRoom,
        out: &mut LightSampleLanes<L>,
    ) {
        let (index, chosen, again) = match group {
            Group::Global(index) => (l.word(index as u32), l.splat(share), again),
            _ => {
                let local = self.local.sample_lanes(l, receiver, here, again, room);
                (local.emitter + self.global as u32, local.probability * share, local.again)
            }
        };
        let there = here & chosen.gt(l.splat(0.0));
        let found = self.punctual_arrays(
            there.bits(),
            &index.array(),
            &chosen.array(),
            &receiver.point.arrays(),
            &[again.array(), u[0].array(), u[1].array()],
        );
        let [direction, weight, end] = &found.vectors;
        let (direction, weight, end) = (l.load_vector(direction), l.load_vector(weight), l.load_vector(end));
        out.take(l.mask(found.valid), direction, weight, l.splat(0.0), end);
        out.infinite = out.infinite | l.mask(found.infinite);
    }

    #[inline(never)]
    fn punctual_arrays(
        &self,
        lanes: u32,
        index: &[u32; LANES],
        chosen: &[f32; LANES],
        points: &[[f32; LANES]; 3],
        [again, u, v]: &[[f32; LANES]; 3],
    ) -> Punctuals {
        let mut found = Punctuals::default();
        for lane in (0..LANES).filter(|lane| lanes >> lane & 1 == 1) {
            let point = glam::Vec3::new(points[0][lane], points[1][lane], points[2][lane]);
            let u = [u[lane], v[lane]];
            let Some(sample) = self.sample_one(index[lane] as usize, chosen[lane], point, again[lane], u) else {
                continue;
            };
            found.valid |= 1 << lane;
            let end = match sample.target {
                super::Target::Point(point) => point,
                _ => {
                    found.infinite |= 1 << lane;
                    sample.direction
                }
            };
            for (row, value) in found.vectors.iter_mut().zip([sample.direction, sample.weight, end]) {
                for (to, x) in row.iter_mut().zip(value.to_array()) {
                    to[lane] = x;
                }
            }
        }
        found
    }

    /// Radiance of the environment along unit vectors, and the density with which light samples make them.
    #[inline(always)]
    pub fn environment_lanes<L: Lanes>(&self, l: L, dir: V3<L::F>, reach: LightReach) -> (V3<L::F>, L::F) {
        // Scenes whose lights are sampled one by one come here as well.
        let share = self.environment_share(reach);
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
                (l.splat_vector(constant.into()), l.splat(pdf))
            }
            None => (V3::splat(l.splat(0.0)), l.splat(0.0)),
        }
    }
}

/// Samples of punctual lights: direction, weight, end.
#[derive(Default)]
struct Punctuals {
    vectors: [[[f32; LANES]; 3]; 3],
    valid: u32,
    infinite: u32,
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
