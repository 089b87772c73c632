//! Light transport: from a prepared scene and a view to a film.

mod aim;
mod bend;
mod camera;
mod cone;
#[cfg(test)]
mod cutouts_tests;
mod direct;
mod dropped;
#[cfg(test)]
mod leaving_tests;
mod material;
mod medium;
mod occupied;
mod path;
#[cfg(test)]
mod pruning_tests;
mod record;
mod replay;
mod surfaces;
mod tile;
mod touching;
mod trace;
mod vertex;
mod walk;
mod wave;
mod whitted;

use crate::cpu_clock::CpuClock;
use crate::film::{Film, Picture};
use crate::prepare::PreparedScene;
use crate::settings::{Integrator, RenderSettings};
use camera::RayCamera;
use cone::Cone;
pub use dropped::{Dropped, DroppedSample};
use glam::Vec3;
use kiln_formats::scene::Camera;
use kiln_formats::{Control, Stopped};
use occupied::Occupied;
use rayon::prelude::*;
pub use record::{Cause, PathEvent};
pub use replay::{PathTrace, replay};
use std::ops::Range;
pub use surfaces::{SurfaceSamples, surfaces};
use tile::Tile;
pub use tile::{Aim, PassTally};
use walk::Course;
pub use walk::shares_paths;

/// What a picture shows.
#[derive(Clone, Debug, PartialEq)]
pub struct View {
    /// The camera; its image plane already has the picture's aspect ratio.
    pub camera: Camera,
    /// Width in pixels, ≥ 1.
    pub width: u32,
    /// Height in pixels, ≥ 1.
    pub height: u32,
    /// Whether camera rays that hit nothing show the environment (alpha 1) or nothing (alpha 0).
    pub show_environment: bool,
}

/// Rays traced.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
pub struct RayCounts {
    /// From the camera.
    pub camera: u64,
    /// From surfaces, by BSDF sampling.
    pub bounce: u64,
    /// To lights, and between the paths of pixels that use each other's.
    pub shadow: u64,
}

impl std::ops::AddAssign for RayCounts {
    fn add_assign(&mut self, other: Self) {
        self.camera += other.camera;
        self.bounce += other.bounce;
        self.shadow += other.shadow;
    }
}

/// What a render gives.
#[derive(Clone, Debug)]
pub struct Rendered {
    /// The sums behind the picture, with their replicates.
    pub film: Film,
    /// The picture.
    pub picture: Picture,
    /// Samples per pixel in it.
    pub spp: u32,
    /// Rays traced for it.
    pub rays: RayCounts,
    /// Samples dropped because they were not finite.
    pub nonfinite: u64,
    /// Why, and where to look.
    pub dropped: Dropped,
    /// CPU seconds over all threads.
    pub cpu_seconds: f64,
}

impl Rendered {
    /// What it cost.
    pub fn tally(&self) -> PassTally {
        let Self { rays, nonfinite, dropped, cpu_seconds, .. } = *self;
        PassTally { rays, nonfinite, dropped, cpu_seconds, clamped: 0.0 }
    }
}

/// Renders all samples of a view in one pass, on the current rayon pool. The progress counts camera paths.
///
/// # Errors
/// [`Stopped`] when `control` asks for it.
pub fn render(
    scene: &PreparedScene,
    view: &View,
    settings: &RenderSettings,
    control: &Control,
) -> Result<Rendered, Stopped> {
    control.begin(u64::from(view.width) * u64::from(view.height) * u64::from(settings.spp));
    let mut film = Film::new(view.width, view.height, view.show_environment);
    let PassTally { rays, nonfinite, dropped, cpu_seconds, .. } =
        render_pass(scene, view, settings, &mut film, 0..settings.spp, control)?;
    let picture = film.picture();
    Ok(Rendered { film, picture, spp: settings.spp, rays, nonfinite, dropped, cpu_seconds })
}

/// Adds the samples numbered `samples` of every pixel to a film, on the current rayon pool; `settings.spp` does not
/// matter. `samples` begins where the film ends. However a range is cut into passes, the film comes out the same, bit for
/// bit. The progress advances by one for each camera path; the caller begins it.
///
/// # Errors
/// [`Stopped`] when `control` asks for it: then the film is as it was.
pub fn render_pass(
    scene: &PreparedScene,
    view: &View,
    settings: &RenderSettings,
    film: &mut Film,
    samples: Range<u32>,
    control: &Control,
) -> Result<PassTally, Stopped> {
    debug_assert_eq!(film.spp, samples.start);
    render_until(scene, view, settings, film, (samples.end, Aim::All(samples.end)), control)
}

/// The same, with a number of samples for each pixel: from as many as it has to as many as `aim` says. `spp` is what the film
/// then says that it has on average.
///
/// # Errors
/// [`Stopped`] when `control` asks for it: then the film is as it was.
pub fn render_until(
    scene: &PreparedScene,
    view: &View,
    settings: &RenderSettings,
    film: &mut Film,
    (spp, aim): (u32, Aim),
    control: &Control,
) -> Result<PassTally, Stopped> {
    debug_assert_eq!((film.width, film.height), (view.width, view.height));
    let camera = RayCamera::new(&view.camera, &scene.frame);
    let course = Course::new(scene, settings, view);
    let memories = wave::Memories::default();
    let clock = CpuClock::begin();
    let helpers = &clock.helpers;
    let hidden = !view.show_environment || scene.lights.environment.is_none();
    // Where triangles lie is asked only if that costs less than the rays do.
    let paths = u64::from(view.width) * u64::from(view.height) * u64::from(spp.saturating_sub(film.spp).max(1));
    let pays = settings.integrator == Integrator::Path && hidden && scene.triangles <= paths;
    let occupied = pays.then(|| Occupied::new(scene, view, &camera)).flatten();
    let mut tally = PassTally::default();
    let sight = wave::Sight { view, camera: &camera, occupied: occupied.as_ref() };
    let whitted = (settings.integrator == Integrator::Whitted).then(|| whitted::Tracer::new(scene));
    let begun = film.spp > 0;
    let mut tiles = Tile::all(&mut film.pixels, film.width, settings.clamp, aim);
    let ended = tiles.par_iter_mut().with_max_len(1).try_for_each(|tile| {
        helpers.help(|| {
            if begun {
                tile.keep();
            }
            match (&whitted, settings.integrator) {
                (Some(tracer), _) => return tracer.render_tile(view, settings, tile, control),
                (None, Integrator::Plain) => render_tile(&course, view, &camera, tile, control)?,
                (None, _) => wave::render_tile(&course, &sight, &memories, tile, control)?,
            }
            // Whitted's paths are not those that a replay follows.
            tile.explain(|pixel, sample| replay(scene, view, settings, pixel, sample).cause);
            Ok(())
        })
    });
    if let Err(stopped) = ended {
        // Those that have not begun have kept nothing, and have nothing to undo.
        tiles.iter_mut().filter(|tile| !begun || tile.is_begun()).for_each(Tile::undo);
        return Err(stopped);
    }
    for (tile, work) in tiles.into_iter().zip(&mut film.work) {
        *work += tile.work();
        tally += tile.tally;
    }
    film.spp = spp;
    film.shares |= course.shares();
    tally.cpu_seconds = clock.seconds();
    Ok(tally)
}

/// Origin and unit direction of the ray through a point within a pixel.
fn camera_ray(view: &View, camera: &RayCamera, [x, y]: [u32; 2], [dx, dy]: [f32; 2]) -> ((Vec3, Vec3), Cone) {
    let across = |at: u32, within: f32, size: u32| (f64::from(at) + f64::from(within)) / f64::from(size);
    let ray = camera.ray(across(x, dx, view.width), across(y, dy, view.height));
    (ray, camera.cone(ray.0, view.height))
}

fn render_tile(
    course: &Course,
    view: &View,
    camera: &RayCamera,
    tile: &mut Tile,
    control: &Control,
) -> Result<(), Stopped> {
    for pixel in tile.pixels() {
        let [x, y] = [tile.x + pixel[0], tile.y + pixel[1]];
        let samples = tile.wanted(pixel);
        for sample in samples.clone() {
            // A pixel of many samples takes long.
            if sample % 64 == 0 || sample == samples.start {
                control.check()?;
            }
            let rays = &mut tile.tally.rays;
            let path = replay::follow(course, view, camera, ([x, y], sample), rays, &mut ());
            tile.add(pixel, sample, path.radiance, path.covered);
        }
        control.advance(u64::from(samples.end - samples.start));
    }
    Ok(())
}
