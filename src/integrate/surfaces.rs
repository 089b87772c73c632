//! What the first surfaces along camera rays are, for compositing.

use super::camera::RayCamera;
use super::trace::{Asker, closest};
use super::vertex::{Place, Vertex};
use super::{PassTally, View, camera_ray};
use crate::cpu_clock::CpuClock;
use crate::film::{Film, Identity, Surfaces};
use crate::geometry::textures::Reader;
use crate::prepare::PreparedScene;
use crate::sampling::{PathSampler, Purpose};
use crate::settings::RenderSettings;
use glam::Vec3;
use kiln_formats::scene::Surface;
use kiln_formats::{Control, Stopped};
use rayon::prelude::*;

/// Camera rays of a pixel behind the layers that tell of surfaces, at most on average.
const MOST_SAMPLES: u32 = 64;

/// How many camera rays of each pixel are looked at.
#[derive(Clone, Copy, Debug)]
pub enum SurfaceSamples<'a> {
    /// So many, or fewer where that is too much.
    All(u32),
    /// Those of a picture, so that mattes add up to its coverage to the sample; or the first ones, where it has too many.
    Of(&'a Film),
}

impl SurfaceSamples<'_> {
    fn at(&self, pixel: usize) -> u32 {
        match self {
            Self::All(samples) => (*samples).min(MOST_SAMPLES),
            Self::Of(film) if film.spp <= MOST_SAMPLES => film.pixels[pixel].samples(),
            Self::Of(film) => film.pixels[pixel].samples().min(MOST_SAMPLES),
        }
    }
}

/// One pixel of the layers.
struct Pixel {
    albedo: Vec3,
    normal: Vec3,
    depth: f32,
    objects: [(u32, f32); crate::film::RANKS],
    materials: [(u32, f32); crate::film::RANKS],
}

/// Looks at the surfaces of a view with the first camera rays of each pixel: those that the picture begins with, so
/// that edges lie where the picture has them. On the current rayon pool. Gives what it cost, too.
///
/// # Errors
/// [`Stopped`] when `control` asks for it.
pub fn surfaces(
    scene: &PreparedScene,
    view: &View,
    settings: &RenderSettings,
    samples: SurfaceSamples,
    control: &Control,
) -> Result<(Surfaces, PassTally), Stopped> {
    let camera = RayCamera::new(&view.camera, &scene.frame);
    let count = view.width as usize * view.height as usize;
    let clock = CpuClock::begin();
    let helpers = &clock.helpers;
    let row = |y: u32| -> Result<Vec<Pixel>, Stopped> {
        control.check()?;
        let look = |x: u32| {
            let samples = samples.at((y * view.width + x) as usize);
            pixel(scene, view, &camera, settings, [x, y], samples)
        };
        Ok(helpers.help(|| (0..view.width).map(look).collect()))
    };
    let rows = (0..view.height).into_par_iter().map(row).collect::<Result<Vec<_>, _>>()?;
    let meshes = &scene.scene.meshes;
    let placed = scene.scene.instances.iter();
    let object = placed.map(|i| if i.name.is_empty() { &meshes[i.mesh as usize].name } else { &i.name }.as_str());
    let mut all = Surfaces {
        width: view.width,
        height: view.height,
        albedo: Vec::with_capacity(count),
        normal: Vec::with_capacity(count),
        depth: Vec::with_capacity(count),
        objects: Identity::new("object", object, 0),
        materials: Identity::new("material", scene.scene.materials.iter().map(|m| m.name.as_str()), 0),
    };
    let mut tally = PassTally::default();
    tally.rays.camera = (0..count).map(|pixel| u64::from(samples.at(pixel))).sum();
    for pixel in rows.into_iter().flatten() {
        all.albedo.push(pixel.albedo.to_array());
        all.normal.push(pixel.normal.to_array());
        all.depth.push(pixel.depth);
        all.objects.ranks.push(pixel.objects);
        all.materials.ranks.push(pixel.materials);
    }
    tally.cpu_seconds = clock.seconds();
    Ok((all, tally))
}

fn pixel(
    scene: &PreparedScene,
    view: &View,
    camera: &RayCamera,
    settings: &RenderSettings,
    place: [u32; 2],
    samples: u32,
) -> Pixel {
    let (mut albedo, mut normal) = (Vec3::ZERO, Vec3::ZERO);
    let (mut depth, mut covered) = (0.0, 0u32);
    let (mut objects, mut materials) = (Vec::new(), Vec::new());
    let axis = view.camera.forward.normalize();
    for sample in 0..samples {
        let mut sampler = PathSampler::new(settings.sampler, settings.seed, place, sample);
        let ((origin, dir), cone) = camera_ray(view, camera, place, sampler.get_2d(0, Purpose::Pixel));
        let asker = Asker { sampler, vertex: 0, draw: 0, eye: true };
        let Some(hit) = closest(scene, &asker, origin, dir) else { continue };
        let Some(at) = Place::new(scene, &hit, dir) else { continue };
        let vertex = Vertex::new(scene, &hit, at, dir, 1.0, cone.at(hit.t).width);
        albedo += base_color(scene, &hit_reader(scene, &hit, cone.at(hit.t).width), at.material, &hit);
        normal += vertex.shading_normal();
        depth += axis.dot(scene.frame.world_point(at.point) - view.camera.origin);
        covered += 1;
        count(&mut objects, scene.geometry.part_index(at.triangle));
        count(&mut materials, at.material);
    }
    let share = 1.0 / samples.max(1) as f32;
    Pixel {
        albedo: albedo * share,
        normal: normal * share,
        depth: if covered > 0 { (depth / f64::from(covered)) as f32 } else { f32::INFINITY },
        objects: Identity::ranked(objects, samples),
        materials: Identity::ranked(materials, samples),
    }
}

fn count(list: &mut Vec<(u32, u32)>, thing: u32) {
    match list.iter_mut().find(|(known, _)| *known == thing) {
        Some((_, count)) => *count += 1,
        None => list.push((thing, 1)),
    }
}

fn hit_reader<'a>(scene: &'a PreparedScene, hit: &crate::math::Hit, width: f32) -> Reader<'a> {
    let b = [1.0 - hit.b1 - hit.b2, hit.b1, hit.b2];
    let uv = scene.geometry.uv(&scene.scene, hit.triangle, b);
    let footprint = match scene.asks.textured {
        false => [0.0; 2],
        true => scene.geometry.texture_density(&scene.scene, hit.triangle).map(|density| width * width * density),
    };
    Reader { scene: &scene.scene, pyramids: &scene.pyramids, uv, footprint }
}

/// The colour that a material has in white light, about: its base or diffuse colour; of glass in `.ray` files what it lets through.
fn base_color(scene: &PreparedScene, read: &Reader, material: u32, hit: &crate::math::Hit) -> Vec3 {
    let b = [1.0 - hit.b1 - hit.b2, hit.b1, hit.b2];
    let vertex = scene.geometry.attributes(&scene.scene, hit.triangle, b).color.truncate();
    let color = match &scene.scene.materials[material as usize].surface {
        Surface::MetalRough(m) => read.color(&m.base_color),
        Surface::Unlit(color) => read.color(color),
        Surface::Phong(p) => read.color(&p.diffuse).max(read.color(&p.transmission)),
    };
    (color * vertex).max(Vec3::ZERO).min(Vec3::ONE)
}
