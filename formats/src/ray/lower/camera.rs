use super::{Lower, Result};
use crate::ray::options::{Basis, Dialect};
use crate::ray::source::At;
use crate::ray::tree::CameraBlock;
use crate::scene::{Camera, Projection, UpAxis};
use glam::DVec3;

/// All `camera` blocks so far: later fields overwrite earlier ones.
#[derive(Default)]
pub(super) struct CameraState {
    at: usize,
    fields: CameraBlock,
    /// Whether the last word on the orientation is `look_at`.
    aimed: bool,
}

impl CameraState {
    pub fn update(&mut self, At { at, value: new }: At<CameraBlock>) {
        self.at = at;
        let old = &mut self.fields;
        // Within a block `viewdir` wins over the others, wherever it stands.
        if new.viewdir.is_some() {
            self.aimed = false;
        } else if new.look_at.is_some() {
            self.aimed = true;
        } else if new.quaternion.is_some() {
            self.aimed = false;
            old.viewdir = None;
            old.updir = None;
        }
        old.position = new.position.or(old.position);
        old.viewdir = new.viewdir.or(old.viewdir.take());
        old.updir = new.updir.or(old.updir.take());
        old.look_at = new.look_at.or(old.look_at.take());
        old.fov = new.fov.or(old.fov.take());
        old.aspect_ratio = new.aspect_ratio.or(old.aspect_ratio.take());
        old.quaternion = new.quaternion.or(old.quaternion);
        old.focal_distance = new.focal_distance.or(old.focal_distance);
    }
}

/// Rotation by a quaternion x, y, z, w as the course tracers have it, which do not normalise it: right, up, back.
fn quaternion_basis([x, y, z, w]: [f64; 4]) -> [DVec3; 3] {
    [
        DVec3::new(1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y + z * w), 2.0 * (z * x - y * w)),
        DVec3::new(2.0 * (x * y - z * w), 1.0 - 2.0 * (z * z + x * x), 2.0 * (y * z + x * w)),
        DVec3::new(2.0 * (z * x + y * w), 2.0 * (y * z - x * w), 1.0 - 2.0 * (y * y + x * x)),
    ]
}

impl Lower<'_, '_> {
    /// Adds the file's camera, or the default one at the origin that looks down −z.
    ///
    /// The basis is neither normalised nor made orthogonal: an updir that leans against viewdir shears the picture,
    /// and the course's reference pictures depend on that.
    pub(super) fn camera(&mut self, state: &CameraState) -> Result<()> {
        let fields = &state.fields;
        if let Some(at) = fields.focal_distance {
            self.notes.warn("ignored-field", at, || "`focaldistance` is ignored: no depth of field".into());
        }
        // Height of the image plane at distance 1. Without `fov` it is 1, which is 53.13°.
        let height = match &fields.fov {
            None => 1.0,
            Some(At { at, value }) if !(*value > 0.0 && *value < 180.0) => {
                return Err(self.invalid(*at, format!("a field of view of {value}° is not between 0° and 180°")));
            }
            Some(At { value, .. }) => 2.0 * libm::tan(0.5 * value.to_radians()),
        };
        let aspect = match &fields.aspect_ratio {
            None => 1.0,
            Some(At { at, value }) if *value <= 0.0 => {
                return Err(self.invalid(*at, format!("an aspect ratio of {value} is not positive")));
            }
            Some(At { value, .. }) => *value,
        };
        let origin = fields.position.unwrap_or(DVec3::ZERO);
        let updir = fields.updir.as_ref().map_or(DVec3::Y, |updir| updir.value);
        let unit = |v: DVec3| if self.options.dialect == Dialect::Hk { v.normalize_or_zero() } else { v };
        let (right, up, forward) = match (&fields.look_at, &fields.viewdir, fields.quaternion) {
            (Some(target), _, _) if state.aimed => {
                let forward = (target.value - origin).normalize();
                let right = forward.cross(updir).normalize();
                (right, right.cross(forward), forward)
            }
            (_, Some(viewdir), _) => {
                let (updir, viewdir) = (unit(updir), unit(viewdir.value));
                (updir.cross(-viewdir), updir, viewdir)
            }
            (_, _, Some(quaternion)) => {
                let [right, up, back] = quaternion_basis(quaternion);
                (right, up, -back)
            }
            _ => (DVec3::X, DVec3::Y, DVec3::NEG_Z),
        };
        let (right, up, forward) = match self.options.basis {
            Basis::Raw => (right, up, forward),
            Basis::Orthonormal => {
                let right = forward.cross(up).normalize_or_zero();
                let forward = forward.normalize_or_zero();
                (right, right.cross(forward), forward)
            }
        };
        let camera = Camera {
            name: String::new(),
            projection: Projection::Perspective,
            origin,
            forward,
            right: right * (0.5 * height * aspect),
            up: up * (0.5 * height),
            aspect: Some(aspect),
        };
        let volume = camera.forward.dot(camera.right.cross(camera.up));
        let finite = camera.forward.is_finite() && camera.right.is_finite() && camera.up.is_finite();
        if volume == 0.0 || !volume.is_finite() || !finite {
            let message = "the camera's view and up directions are parallel, zero or out of range";
            return Err(self.invalid(state.at, message));
        }
        // Nothing in the file names an up axis; the camera's is the best witness.
        self.scene.up = if up.z.abs() > up.y.abs() { UpAxis::Z } else { UpAxis::Y };
        self.scene.cameras.push(camera);
        Ok(())
    }
}
