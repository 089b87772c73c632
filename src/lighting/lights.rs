use super::Environment;
use super::bounds::EmitterBounds;
use super::clusters::{Clusters, Receiver};
use super::distribution::Discrete;
use super::emitter::Emitter;
use super::lights_lanes::LanesTables;
use super::punctual::PunctualLight;
use super::sample::{Group, LightReach, LightSample, Target};
use super::{area, duplicates};
use crate::geometry::{Geometry, WorldFrame, emission};
use crate::math::luminance;
use crate::settings::PrepareSettings;
use glam::{DVec3, Vec3};
use kiln_formats::Scene;
use kiln_formats::scene::AlphaMode;
use std::f32::consts::PI;

/// Share of the choice among groups that does not look at power, and of an emitter's power that is the mean of all, so
/// that no light starves beside one a million times brighter.
const UNIFORM_SHARE: f64 = 0.1;

/// Up to so many emitters are chosen by the first of the two numbers of the point on them, which is then stretched over the
/// emitter's share: numbers that are well distributed together stay so on each emitter. Among more emitters too few of a
/// number's bits would be left for the point.
const FEW: usize = 64;

/// All emitters of a scene, with a way to choose among them.
///
/// What has a place and falls off with the square of the distance is chosen by [`Clusters`]; the rest, and between
/// the groups, by power alone.
#[derive(Debug, Default)]
pub struct Lights {
    /// Those without a place or a natural fall-off first, `global` of them.
    pub(super) punctual: Vec<PunctualLight>,
    pub(super) global: usize,
    /// Over `punctual[global..]`.
    pub(super) local: Clusters,
    /// Emissive triangles in ascending order.
    pub(super) triangles: Vec<u32>,
    /// What is chosen among: all of them, some two by two.
    pub(super) emitters: Vec<Emitter>,
    /// The emitter of each of `triangles`.
    emitter_of: Vec<u32>,
    /// Over `emitters`.
    pub(super) clusters: Clusters,
    /// For each part of the geometry the index of its first one in `triangles`, or `None`.
    first_of_part: Vec<Option<u32>>,
    /// The environment.
    pub environment: Option<Environment>,
    /// Whether the first number of the point chooses the light as well, see [`FEW`].
    pub(super) few: bool,
    /// Each global punctual light, the local ones, the triangles, the environment: each [`LightReach`] is a prefix.
    choice: Discrete,
    /// What code in lanes reads; `None` where light has to be sampled one by one.
    pub(super) lanes: Option<LanesTables>,
}

impl Lights {
    /// Gathers all emitters.
    pub fn new(
        scene: &Scene,
        geometry: &Geometry,
        frame: &WorldFrame,
        environment: Option<Environment>,
        settings: &PrepareSettings,
    ) -> Self {
        // The frame puts the scene's centre at the origin and its extent below 2.
        let (center, radius) = (Vec3::ZERO, 1.0f32);
        // Double precision: the squares of very large and very small worlds leave the range of f32.
        let world2 = (1.0 / frame.scale()) * (1.0 / frame.scale());
        let mut lights = Self { environment, ..Self::default() };
        let lit = scene.lights.iter().map(|l| PunctualLight::new(l, frame, settings));
        lights.punctual = lit.filter(|l| l.power(center, radius) > 0.0).collect();
        lights.punctual.sort_by_key(|l| l.bounds().is_some());
        let local: Vec<_> = lights.punctual.iter().filter_map(PunctualLight::bounds).collect();
        lights.global = lights.punctual.len() - local.len();
        lights.local = clusters(local).0;

        let sources: Vec<_> = scene.materials.iter().map(|m| emission::Source::new(scene, m)).collect();
        let emits = |triangle| sources[geometry.material(scene, triangle) as usize].is_some();
        let hidden = duplicates::hidden(geometry, emits, |triangle| covers(scene, geometry, triangle));
        let mut last_part = None;
        let mut bounds: Vec<(EmitterBounds, f64)> = Vec::new();
        lights.first_of_part = vec![None; geometry.parts.len()];
        for triangle in 0..geometry.len() as u32 {
            let Some(source) = &sources[geometry.material(scene, triangle) as usize] else { continue };
            let unseen = geometry.is_dark(triangle) || geometry.known_coverage(triangle) == Some(false);
            if unseen || hidden.contains(&triangle) {
                continue;
            }
            let part = geometry.part_index(triangle);
            if last_part != Some(part) {
                lights.first_of_part[part as usize] = Some(lights.triangles.len() as u32);
                last_part = Some(part);
            }
            let sides = if source.two_sided { 2.0 } else { 1.0 };
            let radiance = source.mean_radiance(scene, geometry, triangle);
            let power = std::f64::consts::PI * sides * area::of(geometry, triangle) * f64::from(radiance);
            let axis = geometry.front_normal(triangle).normalize_or(DVec3::Z).as_vec3();
            let bound = EmitterBounds::triangle(geometry.corners(triangle), axis, source.two_sided);
            match lights.last_with(scene, geometry, triangle) {
                Some(pair) => {
                    *lights.emitters.last_mut().expect("one with which it is a pair") = pair;
                    let (own, powers) = bounds.last_mut().expect("as many as emitters");
                    (*own, *powers) = (own.union(&bound), *powers + power);
                }
                None => {
                    lights.emitters.push(Emitter::triangle(triangle, lights.triangles.len() as u32));
                    bounds.push((bound, power));
                }
            }
            lights.emitter_of.push(lights.emitters.len() as u32 - 1);
            lights.triangles.push(triangle);
        }
        let triangle_power;
        (lights.clusters, triangle_power) = clusters(bounds);

        let (global, local) = lights.punctual.split_at(lights.global);
        let mut powers: Vec<f64> = global.iter().map(|l| l.power(center, radius)).collect();
        powers.push(local.iter().map(|l| l.power(center, radius)).sum());
        powers.push(triangle_power * world2);
        powers.push(lights.environment.as_ref().map_or(0.0, |environment| {
            f64::from(4.0 * PI * PI * radius * radius * luminance(environment.mean())) * world2
        }));
        let groups = powers.iter().filter(|p| **p > 0.0).count().max(1);
        let floor = UNIFORM_SHARE * powers.iter().sum::<f64>() / groups as f64;
        let weight = |p: &f64| if *p > 0.0 { (1.0 - UNIFORM_SHARE) * p + floor } else { 0.0 };
        lights.choice = Discrete::new(powers.iter().map(weight));
        lights.few = lights.count() + lights.emitters.len() - lights.triangles.len() <= FEW;
        lights.lanes = LanesTables::new(scene, geometry, &lights);
        lights
    }

    /// The last emitter and one triangle more as a quadrilateral, if both emit the same everywhere and are the halves of one.
    fn last_with(&self, scene: &Scene, geometry: &Geometry, triangle: u32) -> Option<Emitter> {
        let last = self.emitters.last().filter(|last| !last.is_pair())?.halves[0];
        let [material, other] = [triangle, last.triangle].map(|t| geometry.material(scene, t));
        let of = &scene.materials[material as usize];
        if material != other || of.alpha.mode != AlphaMode::Opaque {
            return None;
        }
        emission::everywhere(of)?;
        Emitter::quadrilateral(geometry, [(last.triangle, last.row), (triangle, self.triangles.len() as u32)])
    }

    /// Emissive triangles, punctual lights and the environment.
    pub fn count(&self) -> usize {
        self.punctual.len() + self.triangles.len() + usize::from(self.environment.is_some())
    }

    /// Whether any triangle emits.
    pub fn has_areas(&self) -> bool {
        !self.triangles.is_empty()
    }

    /// Irradiance that the punctual lights bring to the middle of the scene, about; luminance.
    pub fn punctual_irradiance(&self, frame: &WorldFrame) -> f32 {
        let power: f64 = self.punctual.iter().map(|light| light.power(Vec3::ZERO, 1.0)).sum();
        (power * frame.scale() * frame.scale()) as f32 / PI
    }

    /// Whether neighbours mostly choose the same ones.
    pub fn are_few(&self) -> bool {
        self.few
    }

    /// The part of [0, 1) that each group of a reach has.
    pub(super) fn parts(&self, reach: LightReach) -> Vec<[f32; 2]> {
        let count = self.reach(reach);
        let mut parts = Vec::with_capacity(count);
        let mut low = 0.0;
        for group in 0..count {
            let high = low + self.choice.probability(group, count);
            parts.push([low, high]);
            low = high;
        }
        // All numbers find a group, whatever the rounding.
        if let Some(last) = parts.iter_mut().rev().find(|[low, high]| high > low) {
            last[1] = 1.0;
        }
        parts
    }

    /// Groups that a reach chooses among.
    fn reach(&self, reach: LightReach) -> usize {
        let constant = matches!(self.environment, Some(Environment::Constant(_)));
        match reach {
            LightReach::Punctual => self.global + 1,
            LightReach::Mis if constant => self.global + 2,
            LightReach::Mis | LightReach::All => self.global + 3,
        }
    }

    /// Whether a sample with this reach can find any light.
    pub fn any(&self, reach: LightReach) -> bool {
        self.choice.any(self.reach(reach))
    }

    /// Whether two samples with this reach may find different light at one receiver.
    pub fn varies(&self, reach: LightReach) -> bool {
        let groups = self.reach(reach);
        let triangles = groups > self.global + 1 && !self.triangles.is_empty();
        let environment = groups > self.global + 2 && self.environment.is_some();
        triangles || environment || self.punctual.len() > 1 || self.punctual.iter().any(PunctualLight::is_wide)
    }

    /// Chooses a light and a point on it. `None` when nothing arrives at the receiver from there.
    pub fn sample(
        &self,
        scene: &Scene,
        geometry: &Geometry,
        receiver: &Receiver,
        reach: LightReach,
        choice: f32,
        u: [f32; 2],
    ) -> Option<LightSample> {
        let count = self.reach(reach);
        let (group, again) = self.choice.sample(if self.few { u[0] } else { choice }, count)?;
        let chosen = self.choice.probability(group, count);
        let first = |again: f32| if self.few { again } else { u[0] };
        let (direction, radiance, pdf, target) = match self.kind(group) {
            kind @ (Group::Global(_) | Group::Local) => return self.sample_punctual(kind, chosen, receiver, again, u),
            Group::Triangles => {
                let emitter = self.clusters.sample(receiver, again)?;
                let u = [first(emitter.again), u[1]];
                let of = &self.emitters[emitter.emitter as usize];
                let (direction, radiance, pdf, target) = area::sample(scene, geometry, of, receiver.point, u)?;
                (direction, radiance, pdf * emitter.probability, target)
            }
            Group::Environment => {
                let (direction, radiance, pdf) = self.environment.as_ref()?.sample([first(again), u[1]])?;
                (direction, radiance, pdf, Target::Infinity)
            }
        };
        let pdf = pdf * chosen;
        let usable = pdf > 0.0 && pdf.is_finite() && radiance != Vec3::ZERO;
        usable.then(|| LightSample { direction, weight: radiance / pdf, pdf: Some(pdf), target, through_glass: false })
    }

    pub(super) fn kind(&self, group: usize) -> Group {
        match group.checked_sub(self.global) {
            None => Group::Global(group),
            Some(0) => Group::Local,
            Some(1) => Group::Triangles,
            Some(_) => Group::Environment,
        }
    }

    /// A sample of a group of punctual lights that was chosen with the probability `chosen`; `again` is what is left of
    /// the number of the choice.
    fn sample_punctual(
        &self,
        group: Group,
        chosen: f32,
        receiver: &Receiver,
        again: f32,
        u: [f32; 2],
    ) -> Option<LightSample> {
        if let Group::Global(index) = group {
            return self.sample_one(index, chosen, receiver.point, again, u);
        }
        let local = self.local.sample(receiver, again)?;
        let index = self.global + local.emitter as usize;
        self.sample_one(index, chosen * local.probability, receiver.point, local.again, u)
    }

    /// A sample of a punctual light that was chosen with the probability `chosen`, by what is left of the number of the choice.
    pub(super) fn sample_one(
        &self,
        index: usize,
        chosen: f32,
        point: Vec3,
        again: f32,
        u: [f32; 2],
    ) -> Option<LightSample> {
        let light = &self.punctual[index];
        let s = light.sample(point, [if self.few { again } else { u[0] }, u[1]])?;
        let target = s.target.map_or(Target::Infinity, Target::Point);
        let (weight, through_glass) = (s.irradiance / chosen, light.through_glass);
        Some(LightSample { direction: s.direction, weight, pdf: None, target, through_glass })
    }

    /// The solid angle density with which [`Lights::sample`] makes the direction from the receiver to `point` on the
    /// emissive `triangle`.
    pub fn pdf_triangle(
        &self,
        geometry: &Geometry,
        triangle: u32,
        receiver: &Receiver,
        point: Vec3,
        reach: LightReach,
    ) -> f32 {
        if reach == LightReach::Punctual {
            return 0.0;
        }
        let part = geometry.part_index(triangle);
        let Some(first) = self.first_of_part[part as usize] else { return 0.0 };
        // Triangles of a part emit all or none, but for those that are dark or hidden by others in the same place.
        let guess = (first + triangle - geometry.parts[part as usize].first_triangle) as usize;
        let row = if self.triangles.get(guess) == Some(&triangle) {
            guess
        } else {
            match self.triangles.binary_search(&triangle) {
                Ok(row) => row,
                Err(_) => return 0.0,
            }
        };
        let emitter = self.emitter_of[row];
        let group = self.choice.probability(self.global + 1, self.reach(reach));
        let pdf = area::pdf(geometry, &self.emitters[emitter as usize], triangle, receiver.point, point);
        let pdf = pdf * (group * self.clusters.probability(receiver, emitter));
        if pdf.is_finite() { pdf } else { 0.0 }
    }

    /// The solid angle density with which [`Lights::sample`] makes the direction to a place of the environment's picture.
    pub fn pdf_environment(&self, uv: [f32; 2], reach: LightReach) -> f32 {
        let Some(environment) = &self.environment else { return 0.0 };
        let share = self.environment_share(reach);
        if share > 0.0 { environment.pdf_at(uv) * share } else { 0.0 }
    }

    /// The probability with which [`Lights::sample`] chooses the environment.
    pub(super) fn environment_share(&self, reach: LightReach) -> f32 {
        let (count, group) = (self.reach(reach), self.global + 2);
        if count <= group { 0.0 } else { self.choice.probability(group, count) }
    }
}

/// Clusters of emitters and the sum of their powers. Their powers are relative to their mean, with a share of the mean
/// mixed into each one's: none overflows, none is zero.
fn clusters(emitters: Vec<(EmitterBounds, f64)>) -> (Clusters, f64) {
    let total: f64 = emitters.iter().map(|(_, power)| power).sum();
    let mean = total / emitters.len().max(1) as f64;
    let relative = |power: f64| if mean > 0.0 { power / mean } else { 1.0 };
    let weighted = |(bounds, power): (EmitterBounds, f64)| EmitterBounds {
        power: ((1.0 - UNIFORM_SHARE) * relative(power) + UNIFORM_SHARE) as f32,
        ..bounds
    };
    (Clusters::new(&emitters.into_iter().map(weighted).collect::<Vec<_>>()), total)
}

/// Whether nothing is seen through a triangle.
fn covers(scene: &Scene, geometry: &Geometry, triangle: u32) -> bool {
    scene.materials[geometry.material(scene, triangle) as usize].alpha.mode == AlphaMode::Opaque
}

#[cfg(test)]
#[path = "lights_tests.rs"]
mod tests;
