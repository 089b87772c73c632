//! One camera path after the other (Kajiya 1986): the plain integrator, which the wavefront is compared with.

use super::RayCounts;
use super::cone::Cone;
use super::record::{PathEvent, Recorder};
use super::trace::{Asker, closest};
use super::walk::{Company, Course, Walk};
use crate::sampling::PathSampler;
use glam::Vec3;

/// Radiance along a camera ray, and whether it met the asset (its coverage).
pub(super) struct PathResult {
    pub radiance: Vec3,
    pub covered: bool,
}

/// Follows one path from a camera ray's origin along its unit direction, textures being filtered by its cone. The radiance is not finite where the path's weight
/// was not.
pub(super) fn trace_path(
    course: &Course,
    sampler: &mut PathSampler,
    ray: ((Vec3, Vec3), Cone),
    rays: &mut RayCounts,
    recorder: &mut impl Recorder,
) -> PathResult {
    let mut result = PathResult { radiance: Vec3::ZERO, covered: false };
    let mut walk = Walk::new(ray);
    rays.camera += 1;
    let mut with = Company { sampler, radiance: &mut result.radiance, rays, recorder };
    for depth in 0..=course.settings.max_depth {
        with.recorder.note(|| {
            let origin = course.prepared.frame.world_point(walk.origin);
            PathEvent::Ray { depth, origin, direction: walk.dir }
        });
        let asker = Asker { sampler: *with.sampler, vertex: depth, draw: 0, eye: depth == 0 };
        let hit = closest(course.prepared, &asker, walk.origin, walk.dir);
        result.covered |= depth == 0 && hit.is_some();
        if !course.visit(depth, &mut walk, hit, &mut with) {
            break;
        }
    }
    result
}
