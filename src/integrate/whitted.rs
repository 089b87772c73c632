//! Whitted's ray tracing (1980) as the course tracers of `.ray` scenes do it: lights, mirrors and glass, and nothing
//! between. It is here to look like them; [`super::path`] is what tells the truth.
//!
//! The rules are theirs (ray-format.md, section 10): no 1/π, highlights `k_s (R·V)ⁿ` beside the cosine, glass without
//! Fresnel reflection that takes k_t for each world unit, shadows straight through glass, colours clamped to 1.
//! Geometry is met in double precision and world space; spheres are met as spheres and not as their triangles.

mod material;
mod shapes;

use super::tile::Tile;
use super::{RayCounts, View};
use crate::lighting::Environment;
use crate::prepare::PreparedScene;
use crate::sampling::{PathSampler, Purpose};
use crate::settings::RenderSettings;
use glam::{DVec3, Vec3};
use kiln_formats::scene::{Falloff, Light, LightKind, Projection};
use kiln_formats::{Control, Stopped};
use material::Matter;
use shapes::{Met, Shapes};
use std::f64::consts::PI;

/// Rays that carry less than this share of a pixel are not followed: a thirtieth of a level of 8 bits.
const LEAST_SHARE: f64 = 1e-4;
/// Surfaces of glass that a shadow ray passes at most.
const MOST_CROSSINGS: u32 = 256;

/// A prepared scene as the course tracers see it.
pub(super) struct Tracer<'a> {
    prepared: &'a PreparedScene,
    shapes: Shapes<'a>,
    environment: Option<&'a Environment>,
}

/// A ray with what is left of the recursion.
#[derive(Clone, Copy)]
struct Beam {
    origin: DVec3,
    /// Of unit length.
    dir: DVec3,
    /// The triangle that it leaves.
    leaves: Option<u32>,
    /// How often it may still be reflected or refracted.
    depth: u32,
    /// The share of the pixel that it can make up at most.
    share: f64,
}

impl<'a> Tracer<'a> {
    pub(super) fn new(prepared: &'a PreparedScene) -> Self {
        Self { prepared, shapes: Shapes::new(prepared), environment: prepared.lights.environment.as_ref() }
    }

    /// Adds samples to a tile. The first of a pixel is taken at its lower left corner, as the course tracers do.
    pub(super) fn render_tile(
        &self,
        view: &View,
        settings: &RenderSettings,
        tile: &mut Tile,
        control: &Control,
    ) -> Result<(), Stopped> {
        for pixel in tile.pixels() {
            control.check()?;
            let place = [tile.x + pixel[0], tile.y + pixel[1]];
            let samples = tile.wanted(pixel);
            for sample in samples.clone() {
                let (radiance, covered) = self.sample(view, settings, place, sample, &mut tile.tally.rays);
                tile.add(pixel, sample, radiance, covered);
            }
            control.advance(u64::from(samples.end - samples.start));
        }
        Ok(())
    }

    fn sample(
        &self,
        view: &View,
        settings: &RenderSettings,
        [x, y]: [u32; 2],
        sample: u32,
        rays: &mut RayCounts,
    ) -> (Vec3, bool) {
        let [dx, dy] = match sample {
            0 => [0.0; 2],
            _ => PathSampler::new(settings.sampler, settings.seed, [x, y], sample).get_2d(0, Purpose::Pixel),
        };
        let across =
            |at: u32, within: f32, size: u32| 2.0 * (f64::from(at) + f64::from(within)) / f64::from(size) - 1.0;
        let (sx, sy) = (across(x, dx, view.width), across(view.height - 1 - y, dy, view.height));
        let camera = &view.camera;
        let plane = camera.right * sx + camera.up * sy;
        let (origin, dir) = match camera.projection {
            Projection::Perspective => (camera.origin, camera.forward + plane),
            Projection::Orthographic => (camera.origin + plane, camera.forward),
        };
        rays.camera += 1;
        let beam = Beam { origin, dir: dir.normalize(), leaves: None, depth: settings.max_depth, share: 1.0 };
        match self.shapes.closest(beam.origin, beam.dir, None) {
            Some(met) => (self.shade(&beam, &met, rays).as_vec3().clamp(Vec3::ZERO, Vec3::ONE), true),
            None if view.show_environment => (self.beyond(beam.dir).as_vec3(), false),
            None => (Vec3::ZERO, false),
        }
    }

    fn beyond(&self, dir: DVec3) -> DVec3 {
        self.environment.map_or(DVec3::ZERO, |e| e.radiance_at(e.locate(dir.as_vec3())).as_dvec3())
    }

    fn trace(&self, beam: Beam, rays: &mut RayCounts) -> DVec3 {
        rays.bounce += 1;
        match self.shapes.closest(beam.origin, beam.dir, beam.leaves) {
            Some(met) => self.shade(&beam, &met, rays),
            None => self.beyond(beam.dir),
        }
    }

    /// What a beam brings from the surface that it met.
    fn shade(&self, beam: &Beam, met: &Met, rays: &mut RayCounts) -> DVec3 {
        let matter = Matter::at(self.prepared, met);
        let (normal, viewer) = (matter.bent.unwrap_or(met.normal), -beam.dir);
        let mut sum = matter.emission + matter.ambient * Vec3::from(self.prepared.scene.ambient).as_dvec3();
        for light in &self.prepared.scene.lights {
            let Some((towards, distance, color)) = arriving(light, met.point) else { continue };
            let facing = normal.dot(towards);
            let mirrored = normal * (2.0 * facing) - towards;
            let highlight = libm::pow(mirrored.dot(viewer).max(0.0), matter.exponent);
            let share = matter.diffuse * facing.max(0.0) + matter.specular * highlight;
            if share == DVec3::ZERO || color == DVec3::ZERO {
                continue;
            }
            rays.shadow += 1;
            sum += color * share * self.shadow(met, towards, distance);
        }
        let follow = |dir: DVec3, weight: DVec3| {
            let share = beam.share * weight.max_element();
            let beam =
                Beam { origin: met.point, dir, leaves: met.leaves(), depth: beam.depth.saturating_sub(1), share };
            (beam.share >= LEAST_SHARE).then_some(beam)
        };
        if beam.depth > 0 && matter.mirror != DVec3::ZERO {
            let reflected = reflect(beam.dir, normal);
            if let Some(next) = follow(reflected, matter.mirror) {
                sum += matter.mirror * self.trace(next, rays);
            }
        }
        if beam.depth > 0 && matter.transmission != DVec3::ZERO {
            let (normal, eta) = if met.inside { (-normal, matter.ior) } else { (normal, 1.0 / matter.ior) };
            let dir = refract(beam.dir, normal, eta).unwrap_or_else(|| reflect(beam.dir, normal));
            let kept = matter.kept_across();
            if let Some(next) = follow(dir, kept) {
                sum += kept * self.trace(next, rays);
            }
        }
        if met.inside { sum * matter.kept_along(met.distance) } else { sum }
    }

    /// The share of light that arrives at a place from `distance` away: glass on the way colours it.
    fn shadow(&self, from: &Met, towards: DVec3, distance: f64) -> DVec3 {
        let mut kept = DVec3::ONE;
        let (mut origin, mut leaves, mut left) = (from.point, from.leaves(), distance);
        for _ in 0..MOST_CROSSINGS {
            let Some(met) = self.shapes.closest(origin, towards, leaves).filter(|met| met.distance < left) else {
                return kept;
            };
            let matter = Matter::at(self.prepared, &met);
            if matter.transmission == DVec3::ZERO {
                return DVec3::ZERO;
            }
            if met.inside {
                kept *= matter.kept_along(met.distance);
            }
            kept *= matter.kept_across();
            (origin, leaves, left) = (met.point, met.leaves(), left - met.distance);
        }
        DVec3::ZERO
    }
}

fn reflect(dir: DVec3, normal: DVec3) -> DVec3 {
    (dir - normal * (2.0 * dir.dot(normal))).normalize()
}

/// The direction behind a surface whose normal is on the side that `dir` comes from; `None`: all is reflected.
fn refract(dir: DVec3, normal: DVec3, eta: f64) -> Option<DVec3> {
    let cosine = -dir.dot(normal);
    let squared = 1.0 - eta * eta * (1.0 - cosine * cosine);
    (squared >= 0.0).then(|| (dir * eta + normal * (eta * cosine - squared.sqrt())).normalize())
}

/// Unit direction to a light, its distance, and the colour that arrives, in the file's units. Soft lights are points.
fn arriving(light: &Light, point: DVec3) -> Option<(DVec3, f64, DVec3)> {
    // The importer multiplied by π, for physically based reflection divides by it.
    let color = Vec3::from(light.color).as_dvec3() / PI;
    let (falloff, share): (&Falloff, fn(&Light, DVec3) -> f64) = match &light.kind {
        LightKind::Directional => return Some((-light.direction, f64::INFINITY, color)),
        LightKind::Point { falloff, .. } => (falloff, |_, _| 1.0),
        LightKind::Spot { falloff, .. } => (falloff, cone),
    };
    let way = light.position - point;
    let distance = way.length();
    let towards = way.try_normalize()?;
    let fallen = match falloff {
        Falloff::Clamped { constant, linear, quadratic } => {
            let divisor = constant + linear * distance + quadratic * distance * distance;
            if divisor > 1.0 { 1.0 / divisor } else { 1.0 }
        }
        Falloff::InverseSquare { range } => {
            let window = range.map_or(1.0, |r| (1.0 - libm::pow(distance / r, 4.0)).clamp(0.0, 1.0));
            window / (distance * distance)
        }
    };
    Some((towards, distance, color * (fallen * share(light, towards))))
}

/// The share of a spot light's intensity towards a place (KHR_lights_punctual).
fn cone(light: &Light, towards: DVec3) -> f64 {
    let LightKind::Spot { inner, outer, .. } = light.kind else { return 1.0 };
    let (inner, outer) = (libm::cos(inner), libm::cos(outer));
    let t = ((-towards.dot(light.direction) - outer) / (inner - outer)).clamp(0.0, 1.0);
    t * t
}
