use glam::Vec3;
use std::f32::consts::PI;

/// Bounds on where emitters are, where they shine and how strongly (pbrt 4ed, 12.6.3).
#[derive(Clone, Copy, Debug)]
pub struct EmitterBounds {
    pub(super) lo: Vec3,
    pub(super) hi: Vec3,
    /// Middle of the emitters' normals.
    pub axis: Vec3,
    /// Cosine of the angle around `axis` that holds all normals; −1: every direction.
    pub cos_spread: f32,
    /// Whether backs emit too.
    pub two_sided: bool,
    /// Weight in the choice: power, as luminance, in any unit; 0 only for nothing.
    pub power: f32,
}

impl Default for EmitterBounds {
    /// Of nothing.
    fn default() -> Self {
        Self {
            lo: Vec3::INFINITY,
            hi: Vec3::NEG_INFINITY,
            axis: Vec3::Z,
            cos_spread: 1.0,
            two_sided: false,
            power: 0.0,
        }
    }
}

fn sine(cosine: f32) -> f32 {
    (1.0 - cosine * cosine).max(0.0).sqrt()
}

impl EmitterBounds {
    /// Of an emissive triangle with the unit normal `axis` on its front. Its power is 1, as of all made here.
    pub fn triangle(corners: [Vec3; 3], axis: Vec3, two_sided: bool) -> Self {
        let [a, b, c] = corners;
        Self { lo: a.min(b).min(c), hi: a.max(b).max(c), axis, cos_spread: 1.0, two_sided, power: 1.0 }
    }

    /// Of a place that shines everywhere.
    pub fn point(position: Vec3) -> Self {
        Self { lo: position, hi: position, cos_spread: -1.0, power: 1.0, ..Self::default() }
    }

    /// Of a place that shines into a cone of this half angle (radians) around `axis`, or a right angle beyond.
    pub fn cone(position: Vec3, axis: Vec3, angle: f64) -> Self {
        Self { axis, cos_spread: libm::cos(angle) as f32, ..Self::point(position) }
    }

    /// The same, with another point inside.
    pub fn with(self, point: Vec3) -> Self {
        Self { lo: self.lo.min(point), hi: self.hi.max(point), ..self }
    }

    /// Middle of the box.
    pub fn center(&self) -> Vec3 {
        (self.lo + self.hi) * 0.5
    }

    /// Of both.
    pub fn union(&self, other: &Self) -> Self {
        if self.power == 0.0 {
            return *other;
        }
        if other.power == 0.0 {
            return *self;
        }
        let (axis, cos_spread) = cone_union((self.axis, self.cos_spread), (other.axis, other.cos_spread));
        Self {
            lo: self.lo.min(other.lo),
            hi: self.hi.max(other.hi),
            axis,
            cos_spread,
            two_sided: self.two_sided || other.two_sided,
            power: self.power + other.power,
        }
    }

    /// Cost of choosing inside: power times area times the solid angle of emission (the paper's SAOH).
    pub fn cost(&self) -> f32 {
        if self.power == 0.0 {
            return 0.0;
        }
        let spread = libm::acosf(self.cos_spread.clamp(-1.0, 1.0));
        // Emission reaches a right angle beyond the spread of normals.
        let reach = (spread + 0.5 * PI).min(PI);
        let sin_spread = sine(self.cos_spread);
        let solid = 2.0 * PI * (1.0 - self.cos_spread)
            + 0.5
                * PI
                * (2.0 * reach * sin_spread - libm::cosf(spread - 2.0 * reach) - 2.0 * spread * sin_spread
                    + self.cos_spread);
        let d = self.hi - self.lo;
        let area = 2.0 * (d.x * d.y + d.y * d.z + d.z * d.x);
        self.power * solid * area.max(d.max_element() * d.max_element() * 1e-3)
    }
}

/// A cone that holds both cones (axis, cosine of the half angle).
fn cone_union((a, cos_a): (Vec3, f32), (b, cos_b): (Vec3, f32)) -> (Vec3, f32) {
    let everywhere = (a, -1.0);
    let (angle_a, angle_b) = (libm::acosf(cos_a.clamp(-1.0, 1.0)), libm::acosf(cos_b.clamp(-1.0, 1.0)));
    let between = libm::acosf(a.dot(b).clamp(-1.0, 1.0));
    if (between + angle_b).min(PI) <= angle_a {
        return (a, cos_a);
    }
    if (between + angle_a).min(PI) <= angle_b {
        return (b, cos_b);
    }
    let half = 0.5 * (angle_a + between + angle_b);
    let Some(across) = (b - a * a.dot(b)).try_normalize() else { return everywhere };
    if half >= PI {
        return everywhere;
    }
    let turn = half - angle_a;
    // A little wider than computed, against rounding.
    (a * libm::cosf(turn) + across * libm::sinf(turn), libm::cosf((half + 1e-4).min(PI)))
}
