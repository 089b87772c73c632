use super::Environment;
use super::distribution::Discrete;
use super::punctual::PunctualLight;
use crate::geometry::{Geometry, WorldFrame, emission};
use crate::math::float_error::gamma;
use crate::math::luminance;
use crate::settings::PrepareSettings;
use glam::Vec3;
use kiln_formats::Scene;
use std::f32::consts::PI;

/// Share of the choice that does not look at power, so that no light starves beside one a million times brighter.
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

/// All emitters of a scene, with a way to choose among them by power.
#[derive(Debug, Default)]
pub struct Lights {
    punctual: Vec<PunctualLight>,
    /// Emissive triangles in ascending order.
    triangles: Vec<u32>,
    /// For each part of the geometry the index of its first emitter in `triangles`, or `None`.
    first_of_part: Vec<Option<u32>>,
    /// The environment.
    pub environment: Option<Environment>,
    /// Punctual lights, then triangles, then the environment: each [`LightReach`] is a prefix.
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
        let mut powers: Vec<f64> = Vec::new();
        let mut lights = Self { environment, ..Self::default() };
        for light in &scene.lights {
            let light = PunctualLight::new(light, frame, settings);
            let power = light.power(center, radius);
            if power > 0.0 {
                powers.push(power);
                lights.punctual.push(light);
            }
        }
        let sources: Vec<_> = scene.materials.iter().map(|m| emission::Source::new(scene, m)).collect();
        let mut last_part = None;
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
            powers.push(std::f64::consts::PI * sides * area(geometry, triangle) * world2 * f64::from(radiance));
            lights.triangles.push(triangle);
        }
        if let Some(environment) = &lights.environment {
            powers.push(f64::from(4.0 * PI * PI * radius * radius * luminance(environment.mean())) * world2);
        }
        let total: f64 = powers.iter().sum();
        let floor = UNIFORM_SHARE * total / powers.len().max(1) as f64;
        lights.choice = Discrete::new(powers.iter().map(|p| (1.0 - UNIFORM_SHARE) * p + floor));
        lights
    }

    /// Emitters in all.
    pub fn count(&self) -> usize {
        self.choice.count()
    }

    fn reach(&self, reach: LightReach) -> usize {
        match reach {
            LightReach::Punctual => self.punctual.len(),
            LightReach::All => self.choice.count(),
            LightReach::Mis => {
                self.choice.count() - usize::from(matches!(self.environment, Some(Environment::Constant(_))))
            }
        }
    }

    /// Whether a sample with this reach can find any light.
    pub fn any(&self, reach: LightReach) -> bool {
        self.reach(reach) > 0
    }

    /// Chooses a light and a point on it. `None` when nothing arrives at `point` from there.
    pub fn sample(
        &self,
        scene: &Scene,
        geometry: &Geometry,
        point: Vec3,
        reach: LightReach,
        choice: f32,
        u: [f32; 2],
    ) -> Option<LightSample> {
        let count = self.reach(reach);
        let (index, _) = self.choice.sample(choice, count)?;
        let chosen = self.choice.probability(index, count);
        if index < self.punctual.len() {
            let light = &self.punctual[index];
            let s = light.sample(point, u)?;
            let target = s.target.map_or(Target::Infinity, Target::Point);
            let through_glass = light.through_glass;
            return Some(LightSample {
                direction: s.direction,
                weight: s.irradiance / chosen,
                pdf: None,
                target,
                through_glass,
            });
        }
        let (direction, radiance, pdf, target) = match self.triangles.get(index - self.punctual.len()) {
            Some(triangle) => sample_triangle(scene, geometry, *triangle, point, u)?,
            None => {
                let (direction, radiance, pdf) = self.environment.as_ref()?.sample(u)?;
                (direction, radiance, pdf, Target::Infinity)
            }
        };
        let pdf = pdf * chosen;
        let usable = pdf > 0.0 && pdf.is_finite() && radiance != Vec3::ZERO;
        usable.then(|| LightSample { direction, weight: radiance / pdf, pdf: Some(pdf), target, through_glass: false })
    }

    /// The solid angle density with which [`Lights::sample`] makes the direction from `origin` to `point` on the
    /// emissive `triangle`.
    pub fn pdf_triangle(
        &self,
        geometry: &Geometry,
        triangle: u32,
        origin: Vec3,
        point: Vec3,
        reach: LightReach,
    ) -> f32 {
        if reach == LightReach::Punctual {
            return 0.0;
        }
        let part = geometry.part_index(triangle);
        let Some(first) = self.first_of_part[part as usize] else { return 0.0 };
        let index = self.punctual.len() + (first + triangle - geometry.parts[part as usize].first_triangle) as usize;
        let to = point - origin;
        let distance2 = to.length_squared();
        // cos·A·d = |n·d| / 2 with n the cross product: no square root of the area, no unit normal.
        let cos_area = (0.5 * geometry.front_normal(triangle).dot(to.as_dvec3()).abs()) as f32;
        let pdf = distance2 * distance2.sqrt() / cos_area * self.choice.probability(index, self.reach(reach));
        if pdf.is_finite() { pdf } else { 0.0 }
    }

    /// The solid angle density with which [`Lights::sample`] makes the direction to a place of the environment's picture.
    pub fn pdf_environment(&self, uv: [f32; 2], reach: LightReach) -> f32 {
        let Some(environment) = &self.environment else { return 0.0 };
        let (count, all) = (self.reach(reach), self.choice.count());
        if count < all { 0.0 } else { environment.pdf_at(uv) * self.choice.probability(all - 1, count) }
    }
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
