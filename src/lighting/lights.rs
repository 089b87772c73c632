use super::Environment;
use super::bounds::EmitterBounds;
use super::distribution::Discrete;
use super::punctual::PunctualLight;
use super::tree::{LightTree, Receiver};
use crate::geometry::{Geometry, WorldFrame, emission};
use crate::math::float_error::gamma;
use crate::math::luminance;
use crate::settings::PrepareSettings;
use glam::{DVec3, Vec3};
use kiln_formats::Scene;
use std::f32::consts::PI;

/// Share of the choice among groups that does not look at power, and of an emitter's power that is the mean of all, so
/// that no light starves beside one a million times brighter.
const UNIFORM_SHARE: f64 = 0.1;

/// Which lights a light sample chooses among.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LightReach {
    /// Punctual lights: what BSDF sampling can never find.
    Punctual,
    /// Those, emissive triangles, and the environment unless it is constant: BSDF sampling does a constant one
    /// better, without any noise where nothing is in the way.
    Mis,
    /// All.
    All,
}

/// All emitters of a scene, with a way to choose among them.
///
/// What has a place and falls off with the square of the distance is chosen by a [`LightTree`]; the rest, and between
/// the groups, by power alone.
#[derive(Debug, Default)]
pub struct Lights {
    /// Those without a place or a natural fall-off first, `global` of them.
    punctual: Vec<PunctualLight>,
    global: usize,
    /// Over `punctual[global..]`.
    local: LightTree,
    /// Emissive triangles in ascending order.
    triangles: Vec<u32>,
    /// Over `triangles`.
    tree: LightTree,
    /// For each part of the geometry the index of its first emitter in `triangles`, or `None`.
    first_of_part: Vec<Option<u32>>,
    /// The environment.
    pub environment: Option<Environment>,
    /// Each global punctual light, the local ones, the triangles, the environment: each [`LightReach`] is a prefix.
    choice: Discrete,
}

/// Where the shadow ray of a light sample ends.
#[derive(Clone, Copy, Debug)]
pub enum Target {
    /// At a point in the open.
    Point(Vec3),
    /// On an emissive triangle, with a bound on the point's rounding error and the geometric normal.
    Triangle {
        /// The triangle.
        triangle: u32,
        /// The point on it.
        point: Vec3,
        /// Bound on each coordinate's error.
        error: Vec3,
        /// Unit normal of the triangle.
        normal: Vec3,
    },
    /// At infinity.
    Infinity,
}

/// Light that may arrive at a point.
#[derive(Clone, Copy, Debug)]
pub struct LightSample {
    /// Unit vector to the light.
    pub direction: Vec3,
    /// Radiance, or the irradiance of a punctual light, already divided by `pdf`.
    pub weight: Vec3,
    /// Solid angle density of `direction` with the choice of the light; `None` for punctual lights.
    pub pdf: Option<f32>,
    /// Where the shadow ray ends.
    pub target: Target,
    /// Shadow rays take on the colour of `.ray` glass.
    pub through_glass: bool,
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
        lights.local = tree(local).0;

        let sources: Vec<_> = scene.materials.iter().map(|m| emission::Source::new(scene, m)).collect();
        let mut last_part = None;
        let mut bounds = Vec::new();
        lights.first_of_part = vec![None; geometry.parts.len()];
        for triangle in 0..geometry.len() as u32 {
            let Some(source) = &sources[geometry.material(scene, triangle) as usize] else { continue };
            let part = geometry.part_index(triangle);
            if last_part != Some(part) {
                lights.first_of_part[part as usize] = Some(lights.triangles.len() as u32);
                last_part = Some(part);
            }
            let sides = if source.two_sided { 2.0 } else { 1.0 };
            let radiance = source.mean_radiance(scene, geometry, triangle);
            let power = std::f64::consts::PI * sides * area(geometry, triangle) * f64::from(radiance);
            let axis = geometry.front_normal(triangle).normalize_or(DVec3::Z).as_vec3();
            bounds.push((EmitterBounds::triangle(geometry.corners(triangle), axis, source.two_sided), power));
            lights.triangles.push(triangle);
        }
        let triangle_power;
        (lights.tree, triangle_power) = tree(bounds);

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
        lights
    }

    /// Emitters in all.
    pub fn count(&self) -> usize {
        self.punctual.len() + self.triangles.len() + usize::from(self.environment.is_some())
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
        let (group, again) = self.choice.sample(choice, count)?;
        let chosen = self.choice.probability(group, count);
        if group <= self.global {
            let (index, chosen) = if group < self.global {
                (group, chosen)
            } else {
                let (index, probability) = self.local.sample(receiver, again)?;
                (self.global + index, chosen * probability)
            };
            let light = &self.punctual[index];
            let s = light.sample(receiver.point, u)?;
            let target = s.target.map_or(Target::Infinity, Target::Point);
            let (weight, through_glass) = (s.irradiance / chosen, light.through_glass);
            return Some(LightSample { direction: s.direction, weight, pdf: None, target, through_glass });
        }
        let (direction, radiance, pdf, target) = if group == self.global + 1 {
            let (index, probability) = self.tree.sample(receiver, again)?;
            let (direction, radiance, pdf, target) =
                sample_triangle(scene, geometry, self.triangles[index], receiver.point, u)?;
            (direction, radiance, pdf * probability, target)
        } else {
            let (direction, radiance, pdf) = self.environment.as_ref()?.sample(u)?;
            (direction, radiance, pdf, Target::Infinity)
        };
        let pdf = pdf * chosen;
        let usable = pdf > 0.0 && pdf.is_finite() && radiance != Vec3::ZERO;
        usable.then(|| LightSample { direction, weight: radiance / pdf, pdf: Some(pdf), target, through_glass: false })
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
        let index = (first + triangle - geometry.parts[part as usize].first_triangle) as usize;
        let chosen =
            self.choice.probability(self.global + 1, self.reach(reach)) * self.tree.probability(receiver, index);
        let to = point - receiver.point;
        let distance2 = to.length_squared();
        // cos·A·d = |n·d| / 2 with n the cross product: no square root of the area, no unit normal.
        let cos_area = (0.5 * geometry.front_normal(triangle).dot(to.as_dvec3()).abs()) as f32;
        let pdf = distance2 * distance2.sqrt() / cos_area * chosen;
        if pdf.is_finite() { pdf } else { 0.0 }
    }

    /// The solid angle density with which [`Lights::sample`] makes the direction to a place of the environment's picture.
    pub fn pdf_environment(&self, uv: [f32; 2], reach: LightReach) -> f32 {
        let Some(environment) = &self.environment else { return 0.0 };
        let (count, group) = (self.reach(reach), self.global + 2);
        if count <= group { 0.0 } else { environment.pdf_at(uv) * self.choice.probability(group, count) }
    }
}

/// A tree over emitters and the sum of their powers. The tree's powers are relative to their mean, with a share of the mean
/// mixed into each one's: none overflows, none is zero.
fn tree(emitters: Vec<(EmitterBounds, f64)>) -> (LightTree, f64) {
    let total: f64 = emitters.iter().map(|(_, power)| power).sum();
    let mean = total / emitters.len().max(1) as f64;
    let relative = |power: f64| if mean > 0.0 { power / mean } else { 1.0 };
    let weighted = |(bounds, power): (EmitterBounds, f64)| EmitterBounds {
        power: ((1.0 - UNIFORM_SHARE) * relative(power) + UNIFORM_SHARE) as f32,
        ..bounds
    };
    (LightTree::new(&emitters.into_iter().map(weighted).collect::<Vec<_>>()), total)
}

fn area(geometry: &Geometry, triangle: u32) -> f64 {
    0.5 * geometry.front_normal(triangle).length()
}

/// Direction, radiance, solid angle density and place of a uniformly chosen point on a triangle.
fn sample_triangle(
    scene: &Scene,
    geometry: &Geometry,
    triangle: u32,
    point: Vec3,
    u: [f32; 2],
) -> Option<(Vec3, Vec3, f32, Target)> {
    let [a, b, c] = geometry.corners(triangle);
    // Heitz 2019, "A Low-Distortion Map Between Triangle and Square".
    let [mut b0, mut b1] = u;
    if b1 > b0 {
        b0 *= 0.5;
        b1 -= b0;
    } else {
        b1 *= 0.5;
        b0 -= b1;
    }
    let weights = [b0, b1, 1.0 - b0 - b1];
    let on_light = a * weights[0] + b * weights[1] + c * weights[2];
    let cross = geometry.front_normal(triangle);
    let normal = cross.try_normalize()?.as_vec3();
    let to = on_light - point;
    let distance2 = to.length_squared();
    let distance = distance2.sqrt();
    let direction = to / distance;
    let cosine = -direction.dot(normal);
    let radiance = emission::radiance(scene, geometry, triangle, weights, cosine > 0.0);
    if radiance == Vec3::ZERO || cosine == 0.0 || !direction.is_finite() {
        return None;
    }
    let pdf = distance2 / (cosine.abs() * (0.5 * cross.length()) as f32);
    let error = ((a * weights[0]).abs() + (b * weights[1]).abs() + (c * weights[2]).abs()) * gamma(7);
    Some((direction, radiance, pdf, Target::Triangle { triangle, point: on_light, error, normal }))
}
