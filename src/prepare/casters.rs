//! Which bodies of a scene are worth aiming at: see [`crate::lighting::casters`].

use crate::geometry::{Geometry, WorldFrame, emission};
use crate::lighting::Lights;
use crate::lighting::casters::{Caster, Casters, MOST_CASTERS};
use crate::math::luminance;
use glam::Vec3;
use kiln_formats::Scene;
use kiln_formats::scene::{Material, Surface};
use std::f32::consts::PI;

/// Perceptual roughness up to which glass and metal gather light enough.
const ROUGHEST: f32 = 0.5;
/// The share of light that has to pass, or of metal.
const LEAST_SHARE: f32 = 0.5;
/// Boosts below this gain less than aiming costs.
const LEAST_BOOST: f32 = 2.0;
/// Boosts beyond this would starve what else is in a cone's directions.
const MOST_BOOST: f32 = 8.0;

/// A body that gathers light.
struct Body {
    centre: Vec3,
    radius: f32,
    /// GGX α of its surface.
    alpha: f32,
    /// How much of its sphere it fills as seen from anywhere, about: the mean shadow of a convex body is a quarter of its surface (Cauchy).
    fill: f32,
}

/// The casters of a scene.
///
/// Directions are best as dense as the root of the mean square of what comes from them (Rath et al. 2020, "Variance-Aware Path Guiding").
/// Lamps of radiance L that take up a solid angle Ω as seen from a body that sends paths anywhere are hit by Ω/4π of them, and L² Ω/4π is
/// that mean square; a diffuse surface beside it that reflects half of the light looks like L Ω/2π. The ratio of the roots is √(π/Ω): great
/// for a small lamp, and none for a bright sky. Rough surfaces see a lamp at least as large as their lobe.
pub(super) fn casters(scene: &Scene, geometry: &Geometry, frame: &WorldFrame, lights: &Lights) -> Casters {
    // Most assets have no lamps, and need not be looked through for bodies.
    if !lights.has_areas() {
        return Casters::default();
    }
    let material = |part: usize| scene.meshes[geometry.parts[part].mesh as usize].material as usize;
    let rough = (0..geometry.parts.len()).filter_map(|part| Some((part, gathers(&scene.materials[material(part)])?)));
    let mut bodies: Vec<Body> = rough.filter_map(|(part, alpha)| body(geometry, part, alpha)).collect();
    bodies.sort_by(|a, b| b.radius.total_cmp(&a.radius));
    bodies.truncate(MOST_CASTERS);
    if bodies.is_empty() {
        return Casters::default();
    }
    // Σ L Ω and Σ L² Ω as seen from each body, occluded or not. No path hits a light without extent, but surfaces look the brighter for it.
    // A sun in an environment counts as if it were spread over the sky.
    let sky = lights.environment.as_ref().map_or(0.0, |environment| luminance(environment.mean()));
    let everywhere = [4.0 * PI * sky + lights.punctual_irradiance(frame), 4.0 * PI * sky * sky];
    let mut seen = vec![everywhere; bodies.len()];
    let sources: Vec<_> = scene.materials.iter().map(|m| emission::Source::new(scene, m)).collect();
    for part in 0..geometry.parts.len() {
        let Some(source) = &sources[material(part)] else { continue };
        for triangle in triangles(geometry, part) {
            let [a, b, c] = geometry.corners(triangle);
            let (middle, across) = ((a + b + c) / 3.0, geometry.front_normal(triangle).as_vec3() * 0.5);
            let radiance = source.mean_radiance(scene, geometry, triangle);
            for (body, sums) in bodies.iter().zip(&mut seen) {
                let to = body.centre - middle;
                let towards = across.dot(to) / to.length();
                let size = if source.two_sided { towards.abs() } else { towards.max(0.0) };
                let angle = (size / to.length_squared()).min(2.0 * PI);
                if angle.is_finite() {
                    sums[0] += radiance * angle;
                    sums[1] += radiance * radiance * angle;
                }
            }
        }
    }
    // In the dark there are none.
    let lit = bodies.iter().zip(seen).filter(|(_, [_, squares])| *squares > 0.0);
    let boosted = lit.map(|(body, [light, squares])| {
        let angle = light * light / squares + 4.0 * PI * body.alpha * body.alpha;
        let boost = ((PI / angle).sqrt() * body.fill).min(MOST_BOOST);
        Caster { centre: body.centre, radius: body.radius, boost }
    });
    Casters::new(boosted.filter(|caster| caster.boost >= LEAST_BOOST).collect())
}

/// GGX α of a material that gathers light.
fn gathers(material: &Material) -> Option<f32> {
    let Surface::MetalRough(m) = &material.surface else { return None };
    let through = m.volume.is_some() && m.transmission.most() >= LEAST_SHARE;
    let roughness = m.roughness.most();
    let shiny = through || m.metallic.most() >= LEAST_SHARE;
    (shiny && roughness <= ROUGHEST).then_some(roughness * roughness)
}

fn triangles(geometry: &Geometry, part: usize) -> std::ops::Range<u32> {
    let end = geometry.parts.get(part + 1).map_or(geometry.len() as u32, |next| next.first_triangle);
    geometry.parts[part].first_triangle..end
}

/// `None` of a part without extent.
fn body(geometry: &Geometry, part: usize, alpha: f32) -> Option<Body> {
    let (mut low, mut high, mut area) = (Vec3::INFINITY, Vec3::NEG_INFINITY, 0.0);
    for triangle in triangles(geometry, part) {
        for corner in geometry.corners(triangle) {
            (low, high) = (low.min(corner), high.max(corner));
        }
        area += 0.5 * geometry.front_normal(triangle).length();
    }
    let centre = (low + high) * 0.5;
    let distance2 = |triangle| geometry.corners(triangle).map(|corner| corner.distance_squared(centre));
    let radius = triangles(geometry, part).flat_map(distance2).fold(0.0f32, f32::max).sqrt();
    let fill = (area as f32 / (4.0 * PI * radius * radius)).min(1.0);
    (radius > 0.0 && radius.is_finite()).then_some(Body { centre, radius, alpha, fill })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lighting::EnvironmentSource;
    use crate::prepare::prepare;
    use crate::settings::PrepareSettings;
    use kiln_formats::scene::{Extent, Falloff, Light, LightKind};
    use kiln_formats::{Control, ImportOptions, import};
    use std::path::Path;

    /// The scene of a check: a floor, a small lamp one unit above it, and between them a ball of glass with a radius of a quarter.
    fn scene() -> Scene {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/checks/scenes/caster_before-the-lamp.gltf");
        import(&path, &ImportOptions::default(), &Control::default()).expect("a scene").scene
    }

    fn boosts(scene: Scene, environment: &EnvironmentSource) -> Vec<f32> {
        let prepared =
            prepare(scene, environment, &PrepareSettings::default(), &Control::default()).expect("not stopped");
        prepared.casters.all().iter().map(|caster| caster.boost).collect()
    }

    #[test]
    fn a_small_lamp_makes_a_caster_of_glass() {
        // Ω = 0.09 / 0.4² as seen from the ball's centre, roughly, and nearly all of a sphere.
        let [boost] = boosts(scene(), &EnvironmentSource::None)[..] else { panic!("one ball") };
        let expected = (PI / (0.09f32 / 0.16)).sqrt();
        assert!((0.95..1.05).contains(&(boost / expected)), "{boost} {expected}");
    }

    #[test]
    fn what_lights_surfaces_and_is_not_met_makes_it_none() {
        assert_eq!(boosts(scene(), &EnvironmentSource::Constant([30.0; 3])), [0.0; 0]);
        let mut lit = scene();
        lit.lights.push(Light {
            name: String::new(),
            kind: LightKind::Point { falloff: Falloff::InverseSquare { range: None }, extent: Extent::Point },
            color: [1000.0; 3],
            position: glam::DVec3::new(0.0, 0.0, 2.0),
            direction: glam::DVec3::NEG_Z,
            through_glass: false,
        });
        assert_eq!(boosts(lit, &EnvironmentSource::None), [0.0; 0]);
    }

    #[test]
    fn without_light_or_with_a_rough_surface_there_is_none() {
        let mut dark = scene();
        dark.materials.iter_mut().for_each(|material| material.emission.factor = [0.0; 3]);
        assert_eq!(boosts(dark, &EnvironmentSource::None), [0.0; 0]);
        let mut rough = scene();
        for material in &mut rough.materials {
            if let Surface::MetalRough(m) = &mut material.surface {
                m.roughness = kiln_formats::scene::ScalarInput::constant(0.8);
            }
        }
        assert_eq!(boosts(rough, &EnvironmentSource::None), [0.0; 0]);
    }
}
