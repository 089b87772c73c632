use super::{Lower, Result};
use crate::ray::source::At;
use crate::ray::tree::{LightBlock, LightWord};
use crate::scene::{Extent, Falloff, Light, LightKind};
use glam::DVec3;
use std::f64::consts::PI;

/// What the seed program takes for an `area_light` that does not say.
const DEFAULT_RADIUS: f64 = 1.0;

impl Lower<'_, '_> {
    /// Adds a light. The course tracers reflect `k_d · color · cos · f` where a Lambert surface reflects
    /// `k_d/π · E`, so intensities and irradiances are π times the file's colours.
    pub(super) fn light(&mut self, At { at, value: light }: At<LightBlock>) -> Result<()> {
        let position = light.position.as_ref().map_or(DVec3::ZERO, |p| p.value);
        let file_color = light.color.as_ref().map_or([0.0; 3], |c| c.value.to_array());
        let file_color = file_color.map(|c| self.not_negative(c, "the light's colour", at));
        let mut direction = DVec3::NEG_Z;
        let mut shift = DVec3::ZERO;
        let kind = match light.word {
            LightWord::Ambient => {
                for (sum, color) in self.scene.ambient.iter_mut().zip(file_color) {
                    *sum += color as f32;
                }
                if self.scene.ambient.iter().all(|x| x.is_finite()) {
                    return Ok(());
                }
                return Err(self.invalid(at, "the ambient light is out of range"));
            }
            LightWord::Directional => {
                direction = match &light.direction {
                    Some(At { at, value }) => self.unit(*value, *at)?,
                    None => direction,
                };
                LightKind::Directional
            }
            LightWord::Point => LightKind::Point { falloff: self.falloff(&light), extent: Extent::Point },
            LightWord::Area => {
                let (extent, to_centre) = self.extent(&light)?;
                shift = to_centre;
                LightKind::Point { falloff: self.falloff(&light), extent }
            }
        };
        let color = file_color.map(|c| (PI * c) as f32);
        let position = position + shift;
        if !color.iter().all(|c| c.is_finite()) || !position.is_finite() {
            return Err(self.invalid(at, "this light is out of range"));
        }
        let through_glass = !self.options.opaque_glass;
        self.scene.lights.push(Light { name: light.name, kind, color, position, direction, through_glass });
        Ok(())
    }

    fn unit(&self, direction: DVec3, at: usize) -> Result<DVec3> {
        let unit = (direction / direction.abs().max_element()).normalize();
        if unit.is_finite() { Ok(unit) } else { Err(self.invalid(at, "a direction of length 0 points nowhere")) }
    }

    fn falloff(&mut self, light: &LightBlock) -> Falloff {
        let [constant, linear, quadratic] =
            [0, 1, 2].map(|i| self.not_negative(light.attenuation[i].value, "attenuation", light.attenuation[i].at));
        Falloff::Clamped { constant, linear, quadratic }
    }

    /// The shape of an `area_light`, and the way from its `position` to its centre. The forks have a field each:
    /// a disc's radius, a square's side, or the edges of a parallelogram of which `position` is a corner.
    fn extent(&mut self, light: &LightBlock) -> Result<(Extent, DVec3)> {
        if let (Some(u), Some(v)) = (&light.u, &light.v) {
            let (u, v) = (u.value * 0.5, v.value * 0.5);
            if !u.is_finite() || !v.is_finite() {
                return Err(self.invalid(light.u.as_ref().map_or(0, |u| u.at), "the light's edges are out of range"));
            }
            return Ok((Extent::Parallelogram { u, v }, u + v));
        }
        if let (None, Some(At { at, value })) = (&light.radius, &light.side) {
            if *value <= 0.0 {
                return Err(self.invalid(*at, "the side of an area light must be positive"));
            }
            let half = 0.5 * value;
            return Ok((Extent::Parallelogram { u: DVec3::X * half, v: DVec3::Z * half }, DVec3::ZERO));
        }
        let extent = match &light.radius {
            None => Extent::Disc { radius: DEFAULT_RADIUS },
            Some(At { at, value }) if *value < 0.0 => {
                return Err(self.invalid(*at, "the radius of an area light must not be negative"));
            }
            Some(At { value: 0.0, .. }) => Extent::Point,
            Some(At { value, .. }) => Extent::Disc { radius: *value },
        };
        Ok((extent, DVec3::ZERO))
    }
}
