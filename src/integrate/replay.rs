//! One path by itself: to look at it, and to tell why it had no finite radiance.

use super::camera::RayCamera;
use super::path::{PathResult, trace_path};
use super::record::{PathEvent, Recorder, cause_of};
use super::walk::Course;
use super::{Cause, RayCounts, View, camera_ray};
use crate::prepare::PreparedScene;
use crate::sampling::{PathSampler, Purpose};
use crate::settings::RenderSettings;
use glam::Vec3;
use serde::Serialize;

/// A path that was followed again.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct PathTrace {
    /// Column and row from the upper left.
    pub pixel: [u32; 2],
    /// Number of the sample.
    pub sample: u32,
    /// Selects the random numbers.
    pub seed: u64,
    /// What happened, in order.
    pub events: Vec<PathEvent>,
    /// What the sample adds to its pixel; in JSON, numbers that are not finite are null.
    pub radiance: Vec3,
    /// Whether it met anything.
    pub covered: bool,
    /// Why the sample is dropped, if it is.
    pub cause: Option<Cause>,
}

/// Follows the path of one sample again, as the plain integrator does: the same bits as in its picture, and but for rounding
/// those of the wavefront. `settings.spp` does not matter.
pub fn replay(
    scene: &PreparedScene,
    view: &View,
    settings: &RenderSettings,
    pixel: [u32; 2],
    sample: u32,
) -> PathTrace {
    let camera = RayCamera::new(&view.camera, &scene.frame);
    let mut events = Vec::new();
    let course = Course::new(scene, settings, view);
    let path = follow(&course, view, &camera, (pixel, sample), &mut RayCounts::default(), &mut events);
    let cause = (!path.radiance.is_finite()).then(|| cause_of(&events));
    PathTrace { pixel, sample, seed: settings.seed, events, radiance: path.radiance, covered: path.covered, cause }
}

/// The path of a pixel's sample.
pub(super) fn follow(
    course: &Course,
    view: &View,
    camera: &RayCamera,
    (pixel, sample): ([u32; 2], u32),
    rays: &mut RayCounts,
    recorder: &mut impl Recorder,
) -> PathResult {
    let settings = course.settings;
    let mut sampler = PathSampler::new(settings.sampler, settings.seed, pixel, sample);
    let ray = camera_ray(view, camera, pixel, sampler.get_2d(0, Purpose::Pixel));
    trace_path(course, &mut sampler, ray, rays, recorder)
}
