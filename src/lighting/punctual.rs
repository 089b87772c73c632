use super::bounds::EmitterBounds;
use crate::geometry::WorldFrame;
use crate::math::Frame;
use crate::settings::PrepareSettings;
use glam::Vec3;
use kiln_formats::scene::{Extent, Falloff, Light, LightKind};
use std::f32::consts::PI;

/// A light that is not a surface, in the rays' frame.
#[derive(Clone, Debug)]
pub struct PunctualLight {
    kind: LightKind,
    color: Vec3,
    position: Vec3,
    /// The way the light travels.
    direction: Vec3,
    /// World units per unit of the rays' frame.
    world: f64,
    /// Shadow rays take on the colour of `.ray` glass instead of being blocked.
    pub through_glass: bool,
}

/// How a punctual light reaches a point.
#[derive(Clone, Copy, Debug)]
pub struct PunctualSample {
    /// Irradiance on a surface that faces `direction`.
    pub irradiance: Vec3,
    /// Unit vector from the point to the light, for cosines.
    pub direction: Vec3,
    /// Where the shadow ray ends; `None`: at infinity along `direction`.
    pub target: Option<Vec3>,
}

impl PunctualLight {
    /// The light in the rays' frame, with point lights softened where the settings ask for it.
    pub fn new(light: &Light, frame: &WorldFrame, settings: &PrepareSettings) -> Self {
        let mut kind = light.kind;
        if let (LightKind::Point { extent, .. }, Some(radius)) = (&mut kind, settings.point_lights)
            && *extent == Extent::Point
            && radius > 0.0
        {
            *extent = Extent::Disc { radius };
        }
        Self {
            kind,
            color: Vec3::from(light.color),
            position: frame.point(light.position),
            direction: light.direction.as_vec3(),
            world: 1.0 / frame.scale(),
            through_glass: light.through_glass,
        }
    }

    /// Irradiance factor at a distance in world units.
    fn falloff(falloff: &Falloff, d: f64) -> f64 {
        let value = match *falloff {
            Falloff::InverseSquare { range } => {
                let window = range.map_or(1.0, |r| {
                    let q = d / r;
                    (1.0 - q * q * q * q).clamp(0.0, 1.0)
                });
                window / (d * d)
            }
            Falloff::Clamped { constant, linear, quadratic } => {
                let below = constant + linear * d + quadratic * d * d;
                if below > 1.0 { 1.0 / below } else { 1.0 }
            }
        };
        // At the light itself 1/d² is infinite: a set of measure zero, left out.
        if value.is_finite() { value } else { 0.0 }
    }

    /// Whether light comes from more than a point or a direction.
    pub fn is_wide(&self) -> bool {
        matches!(self.kind, LightKind::Point { extent: Extent::Disc { .. } | Extent::Parallelogram { .. }, .. })
    }

    /// How the light reaches `point`. `u` chooses among the points of lights with an extent.
    pub fn sample(&self, point: Vec3, u: [f32; 2]) -> Option<PunctualSample> {
        let from = |position: Vec3| {
            let to = position - point;
            let distance = to.length();
            (distance > 0.0 && distance.is_finite()).then(|| (to / distance, f64::from(distance) * self.world))
        };
        let sample = |direction, factor: f64, target| {
            let irradiance = (self.color.as_dvec3() * factor).as_vec3();
            (irradiance != Vec3::ZERO && irradiance.is_finite()).then_some(PunctualSample {
                irradiance,
                direction,
                target,
            })
        };
        match &self.kind {
            LightKind::Directional => sample(-self.direction, 1.0, None),
            LightKind::Point { falloff, extent } => {
                let offset = match *extent {
                    Extent::Point => Vec3::ZERO,
                    Extent::Disc { radius } => {
                        let (direction, _) = from(self.position)?;
                        let Frame { x: a, y: b, .. } = Frame::from_normal(direction);
                        let (r, phi) = (u[0].sqrt() * (radius / self.world) as f32, 2.0 * PI * u[1]);
                        a * (r * libm::cosf(phi)) + b * (r * libm::sinf(phi))
                    }
                    Extent::Parallelogram { u: a, v: b } => {
                        ((a * f64::from(2.0 * u[0] - 1.0) + b * f64::from(2.0 * u[1] - 1.0)) / self.world).as_vec3()
                    }
                };
                let target = self.position + offset;
                // A disc shades as from its centre: "point shading × visible fraction".
                let (direction, d) = from(if matches!(extent, Extent::Disc { .. }) { self.position } else { target })?;
                sample(direction, Self::falloff(falloff, d), Some(target))
            }
            LightKind::Spot { falloff, inner, outer } => {
                let (direction, d) = from(self.position)?;
                let cosine = f64::from(-direction.dot(self.direction));
                let (full, none) = (libm::cos(*inner), libm::cos(*outer));
                // The cosines of very narrow cones are the same number.
                let cone = ((cosine - none) / (full - none).max(f64::MIN_POSITIVE)).clamp(0.0, 1.0);
                sample(direction, cone * cone * Self::falloff(falloff, d), Some(self.position))
            }
        }
    }

    /// Bounds and power for choosing among lights that have a place and fall off with the square of the distance.
    pub fn bounds(&self) -> Option<(EmitterBounds, f64)> {
        let bounds = match &self.kind {
            LightKind::Point { falloff: Falloff::InverseSquare { .. }, extent } => {
                let bounds = EmitterBounds::point(self.position);
                match *extent {
                    Extent::Point | Extent::Disc { .. } => bounds,
                    Extent::Parallelogram { u, v } => {
                        let [u, v] = [u, v].map(|e| (e / self.world).as_vec3());
                        [u + v, u - v, v - u, -u - v].into_iter().fold(bounds, |b, e| b.with(self.position + e))
                    }
                }
            }
            LightKind::Spot { falloff: Falloff::InverseSquare { .. }, outer, .. } => {
                EmitterBounds::cone(self.position, self.direction, *outer)
            }
            _ => return None,
        };
        Some((bounds, f64::from(crate::math::luminance(self.color))))
    }

    /// Roughly the power that reaches a scene of radius `radius` around `center` (both in the rays' frame): a weight
    /// for choosing among lights, not a physical quantity. Greater than zero for every light that is not black.
    pub fn power(&self, center: Vec3, radius: f32) -> f64 {
        let disc = f64::from(PI * radius * radius) * self.world * self.world;
        let irradiance = match &self.kind {
            LightKind::Directional => 1.0,
            LightKind::Point { falloff, .. } | LightKind::Spot { falloff, .. } => {
                let d = f64::from((self.position - center).length().max(radius)) * self.world;
                Self::falloff(&without_range(falloff), d)
            }
        };
        disc * irradiance * f64::from(crate::math::luminance(self.color))
    }
}

/// The range's window can be zero at the scene's centre while the light reaches other places.
fn without_range(falloff: &Falloff) -> Falloff {
    match *falloff {
        Falloff::InverseSquare { .. } => Falloff::InverseSquare { range: None },
        other => other,
    }
}
