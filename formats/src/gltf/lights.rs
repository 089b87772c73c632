//! KHR_lights_punctual.

use super::report::Report;
use crate::scene::{Extent, Falloff, Light, LightKind};
use glam::{DAffine3, DVec3};
use gltf::json;
use gltf::json::extensions::scene::khr_lights_punctual::{Light as Source, Type};
use gltf::json::validation::Checked;
use std::f64::consts::FRAC_PI_2;

/// The light at a node, if it has one that is sound.
///
/// The extension's candela and lux are taken one to one as W/sr and W/m².
pub(super) fn at_node(root: &json::Root, index: usize, world: &DAffine3, report: &mut Report) -> Option<Light> {
    let node = root.nodes.get(index)?;
    let id = node.extensions.as_ref()?.khr_lights_punctual.as_ref()?.light.value();
    let lights = root.extensions.as_ref().and_then(|e| e.khr_lights_punctual.as_ref());
    let Some(light) = lights.and_then(|l| l.lights.get(id)) else {
        let place = format!("/nodes/{index}/extensions/KHR_lights_punctual/light");
        report.warn("invalid-light", place, format!("there is no light {id}"));
        return None;
    };
    let place = format!("/extensions/KHR_lights_punctual/lights/{id}");
    let Checked::Valid(kind) = light.type_ else {
        report.warn("invalid-light", place, "is no directional, point or spot light and is left out");
        return None;
    };
    let color = light.color.map(|c| c * light.intensity);
    // Light travels along the node's −Z, whatever its scale.
    let direction = (-world.matrix3.z_axis).try_normalize();
    let sound = color.iter().all(|c| c.is_finite() && *c >= 0.0) && world.translation.is_finite();
    let direction = match (kind, direction) {
        (Type::Point, _) => Some(DVec3::NEG_Z),
        (_, direction) => direction,
    };
    let (Some(direction), true) = (direction, sound) else {
        report.warn("invalid-light", place, "has a negative colour or no direction and is left out");
        return None;
    };
    let kind = match kind {
        Type::Directional => LightKind::Directional,
        Type::Point => LightKind::Point { falloff: falloff(light, &place, report), extent: Extent::Point },
        Type::Spot => {
            let (inner, outer) = cone(light, &place, report);
            LightKind::Spot { falloff: falloff(light, &place, report), inner, outer }
        }
    };
    let name = light.name.clone().filter(|n| !n.is_empty()).or_else(|| node.name.clone()).unwrap_or_default();
    Some(Light { name, kind, color, position: world.translation, direction, through_glass: false })
}

fn falloff(light: &Source, place: &str, report: &mut Report) -> Falloff {
    let range = light.range.map(f64::from).filter(|r| {
        let sound = *r > 0.0 && r.is_finite();
        if !sound {
            report.warn("invalid-light", format!("{place}/range"), "is not positive and is ignored");
        }
        sound
    });
    Falloff::InverseSquare { range }
}

fn cone(light: &Source, place: &str, report: &mut Report) -> (f64, f64) {
    let spot = light.spot.as_ref();
    let inner = spot.map_or(0.0, |s| f64::from(s.inner_cone_angle));
    let outer = spot.map_or(std::f64::consts::FRAC_PI_4, |s| f64::from(s.outer_cone_angle));
    // π/2 as a float is a little over π/2.
    let outer_sound = if outer > 0.0 { outer.min(FRAC_PI_2) } else { std::f64::consts::FRAC_PI_4 };
    let inner_sound = if inner >= 0.0 { inner.min(outer_sound * (1.0 - 1e-6)) } else { 0.0 };
    if outer <= 0.0 || outer > FRAC_PI_2 + 1e-6 || inner < 0.0 || inner >= outer {
        let message = format!("cone angles {inner} and {outer} are taken as {inner_sound} and {outer_sound}");
        report.warn("invalid-light", format!("{place}/spot"), message);
    }
    (inner_sound, outer_sound)
}
