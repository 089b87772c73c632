//! Light transport: from a prepared scene and a view to a film.

mod camera;
mod medium;
mod path;
mod trace;
mod vertex;

use crate::film::{Film, Picture, PixelSums};
use crate::prepare::PreparedScene;
use crate::sampling::{PathSampler, Purpose};
use crate::settings::RenderSettings;
use camera::RayCamera;
use cpu_time::ThreadTime;
use kiln_formats::scene::Camera;
use kiln_formats::{Control, Stopped};
use rayon::prelude::*;

/// Side of the square tiles that threads take in turn.
const TILE: u32 = 16;

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
    /// To lights.
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
    /// CPU seconds over all threads.
    pub cpu_seconds: f64,
}

/// A rendered tile: its pixels row by row, and what they cost.
struct Tile {
    x: u32,
    y: u32,
    width: u32,
    pixels: Vec<PixelSums>,
    rays: RayCounts,
    nonfinite: u64,
    cpu_seconds: f64,
}

/// Renders a view on the current rayon pool. The progress counts pixels.
///
/// # Errors
/// [`Stopped`] when `control` asks for it.
pub fn render(
    scene: &PreparedScene,
    view: &View,
    settings: &RenderSettings,
    control: &Control,
) -> Result<Rendered, Stopped> {
    let (width, height) = (view.width, view.height);
    control.begin(u64::from(width) * u64::from(height));
    let camera = RayCamera::new(&view.camera, &scene.frame);
    let corners: Vec<(u32, u32)> =
        (0..height.div_ceil(TILE)).flat_map(|y| (0..width.div_ceil(TILE)).map(move |x| (x * TILE, y * TILE))).collect();
    let tiles = corners
        .par_iter()
        .with_max_len(1)
        .map(|corner| render_tile(scene, view, &camera, settings, *corner, control))
        .collect::<Result<Vec<_>, _>>()?;
    let mut film =
        Film { width, height, spp: settings.spp, pixels: vec![PixelSums::default(); width as usize * height as usize] };
    let (mut rays, mut nonfinite, mut cpu_seconds) = (RayCounts::default(), 0, 0.0);
    for tile in tiles {
        for (row, pixels) in tile.pixels.chunks(tile.width as usize).enumerate() {
            let start = (tile.y as usize + row) * width as usize + tile.x as usize;
            film.pixels[start..start + pixels.len()].copy_from_slice(pixels);
        }
        rays += tile.rays;
        nonfinite += tile.nonfinite;
        cpu_seconds += tile.cpu_seconds;
    }
    let picture = film.picture();
    Ok(Rendered { film, picture, spp: settings.spp, rays, nonfinite, cpu_seconds })
}

fn render_tile(
    scene: &PreparedScene,
    view: &View,
    camera: &RayCamera,
    settings: &RenderSettings,
    (x0, y0): (u32, u32),
    control: &Control,
) -> Result<Tile, Stopped> {
    let clock = ThreadTime::now();
    let (x1, y1) = ((x0 + TILE).min(view.width), (y0 + TILE).min(view.height));
    let mut tile = Tile {
        x: x0,
        y: y0,
        width: x1 - x0,
        pixels: Vec::with_capacity(((x1 - x0) * (y1 - y0)) as usize),
        rays: RayCounts::default(),
        nonfinite: 0,
        cpu_seconds: 0.0,
    };
    for y in y0..y1 {
        for x in x0..x1 {
            let mut sums = PixelSums::default();
            for sample in 0..settings.spp {
                // A pixel of many samples takes long.
                if sample % 64 == 0 {
                    control.check()?;
                }
                let mut sampler = PathSampler::new(settings.sampler, settings.seed, [x, y], sample);
                let [dx, dy] = sampler.get_2d(0, Purpose::Pixel);
                let across = |at: u32, within: f32, size: u32| (f64::from(at) + f64::from(within)) / f64::from(size);
                let ray = camera.ray(across(x, dx, view.width), across(y, dy, view.height));
                let path = path::trace_path(scene, settings, &mut sampler, ray, view.show_environment, &mut tile.rays);
                if path.radiance.is_finite() {
                    sums.add(sample, path.radiance.extend(f32::from(u8::from(path.covered))).to_array());
                } else {
                    tile.nonfinite += 1;
                }
            }
            tile.pixels.push(sums);
            control.advance(1);
        }
    }
    tile.cpu_seconds = clock.elapsed().as_secs_f64();
    Ok(tile)
}
