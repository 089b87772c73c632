//! Where in a picture camera rays can meet anything at all. Most of a thumbnail is empty.

use super::View;
use super::camera::RayCamera;
use crate::geometry::Geometry;
use crate::lanes::{Floats, LANES, Lanes, Mask, V3, Words, Work};
use crate::prepare::PreparedScene;
use glam::Vec3;

/// Side of the squares of pixels that are told apart.
pub(super) const BLOCK: u32 = 4;

/// Pixels by which triangles are taken to be larger: rays in single precision stray by far less.
const MARGIN: f64 = 1.0;

/// Nearer to the camera than this, in the rays' frame, rays in single precision may stray further.
const NEAREST: f64 = 0.01;

/// For each square of a picture, whether the bounds of a triangle reach into it.
#[derive(Debug)]
pub(super) struct Occupied {
    /// Squares in a row.
    across: usize,
    blocks: Vec<bool>,
}

impl Occupied {
    /// `None` where nothing is known: triangles beside or behind the camera, or a camera without depth.
    pub fn new(prepared: &PreparedScene, view: &View, camera: &RayCamera) -> Option<Self> {
        let (across, down) = (view.width.div_ceil(BLOCK) as usize, view.height.div_ceil(BLOCK) as usize);
        let mut occupied = Self { across, blocks: vec![false; across * down] };
        if let Some((origin, axes)) = camera.near_axes() {
            let size = [view.width as f32, view.height as f32];
            let marking = Marking { geometry: &prepared.geometry, origin, axes, size, occupied: &mut occupied };
            return prepared.lanes.run(marking).then_some(occupied);
        }
        let project = camera.projector()?;
        let scale = [f64::from(view.width), f64::from(view.height)];
        let cell = |x: f64, count: usize| (x / f64::from(BLOCK)).clamp(0.0, count as f64) as usize;
        for triangle in 0..prepared.geometry.len() as u32 {
            let (mut low, mut high) = ([f64::INFINITY; 2], [f64::NEG_INFINITY; 2]);
            for corner in prepared.geometry.corners(triangle) {
                let (depth, point) = project(corner.as_dvec3());
                // What is not a number is near as well.
                if !(depth >= NEAREST) {
                    return None;
                }
                for axis in 0..2 {
                    low[axis] = low[axis].min(point[axis] * scale[axis] - MARGIN);
                    high[axis] = high[axis].max(point[axis] * scale[axis] + MARGIN);
                }
            }
            if high[0] < 0.0 || high[1] < 0.0 {
                continue;
            }
            for y in cell(low[1], down)..down.min(cell(high[1], down) + 1) {
                let row = &mut occupied.blocks[y * across..(y + 1) * across];
                let columns = cell(low[0], across)..across.min(cell(high[0], across) + 1);
                row[columns].fill(true);
            }
        }
        Some(occupied)
    }

    /// Marks the squares from one column and row to others, these included.
    #[inline(always)]
    fn mark(&mut self, [left, right]: [u32; 2], [top, bottom]: [u32; 2]) {
        for y in top..=bottom {
            let row = &mut self.blocks[y as usize * self.across..][..self.across];
            row[left as usize] = true;
            if left < right {
                row[left as usize + 1..=right as usize].fill(true);
            }
        }
    }

    /// Whether a ray through a pixel may meet anything.
    pub fn at(&self, [x, y]: [u32; 2]) -> bool {
        self.blocks[(y / BLOCK) as usize * self.across + (x / BLOCK) as usize]
    }
}

/// Sixteen triangles at a time, before a camera for which single precision is fine enough.
struct Marking<'a> {
    geometry: &'a Geometry,
    /// The camera, and what takes points to how far away they are, and how far to the right and above (times that).
    origin: Vec3,
    axes: [Vec3; 3],
    /// Of the picture, pixels.
    size: [f32; 2],
    occupied: &'a mut Occupied,
}

impl Work for Marking<'_> {
    /// Whether all triangles are before the camera.
    type Output = bool;

    #[inline(always)]
    fn run<L: Lanes>(self, l: L) -> bool {
        let Self { geometry, origin, axes, size, occupied } = self;
        let count = geometry.len();
        let last = [occupied.across, occupied.blocks.len() / occupied.across].map(|n| n as f32 - 1.0);
        let depth_axis = l.splat_vector(axes[0].to_array());
        let (right, up) = (l.splat_vector(axes[1].to_array()), l.splat_vector(axes[2].to_array()));
        let origin_lanes = l.splat_vector(origin.to_array());
        // By how many pixels a point at distance 1 may be rounded: eight roundings of what is as large as a coordinate seen from the camera.
        let rounding =
            |axis: Vec3| 8.0 * f32::EPSILON * (origin.length() + 2.0) * (axis.length() + 2.0 * axes[0].length());
        let strays = size[0].max(size[1]) * rounding(axes[1]).max(rounding(axes[2]));
        let mut corners = [[0.0f32; LANES]; 9];
        for first in (0..count).step_by(LANES) {
            for lane in 0..LANES {
                // What is left over shows the last one again.
                let triangle = (first + lane).min(count - 1) as u32;
                let numbers = geometry.corners(triangle).into_iter().flat_map(|corner| corner.to_array());
                for (row, x) in corners.iter_mut().zip(numbers) {
                    row[lane] = x;
                }
            }
            let (far, near) = (l.splat(f32::INFINITY), l.splat(f32::NEG_INFINITY));
            let (mut low, mut high, mut nearest) = ([far; 2], [near; 2], far);
            for k in 0..3 {
                let corner = V3::new(l.load(&corners[3 * k]), l.load(&corners[3 * k + 1]), l.load(&corners[3 * k + 2]));
                let from = corner - origin_lanes;
                let depth = from.dot(depth_axis);
                nearest = nearest.min(depth);
                let place = [from.dot(right) / depth + 1.0, l.splat(1.0) - from.dot(up) / depth];
                for axis in 0..2 {
                    let pixel = place[axis] * (0.5 * size[axis]);
                    (low[axis], high[axis]) = (low[axis].min(pixel), high[axis].max(pixel));
                }
            }
            if !nearest.ge(l.splat(NEAREST as f32)).all() {
                return false;
            }
            let margin = l.splat(strays) / nearest + MARGIN as f32;
            let (across, left, right) = cells(l, low[0] - margin, high[0] + margin, last[0]);
            let (down, top, bottom) = cells(l, low[1] - margin, high[1] + margin, last[1]);
            for lane in (0..LANES).filter(|lane| (across & down) >> lane & 1 != 0) {
                occupied.mark([left[lane], right[lane]], [top[lane], bottom[lane]]);
            }
        }
        true
    }
}

/// From which block to which of a row, whose last one is given, sixteen stretches of pixels reach; as bits, those that reach any. (Written
/// out: closures are not inlined where the instructions are.)
#[inline(always)]
fn cells<L: Lanes>(l: L, low: L::F, high: L::F, last: f32) -> (u32, [u32; LANES], [u32; LANES]) {
    let (zero, end) = (l.splat(0.0), l.splat(last));
    let (low_block, high_block) = (low / BLOCK as f32, high / BLOCK as f32);
    let inside = high.ge(zero) & low_block.lt(l.splat(last + 1.0));
    let (from, to) = (low_block.max(zero).min(end).truncate(), high_block.max(zero).min(end).truncate());
    (inside.bits(), from.array(), to.array())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::integrate::camera_ray;
    use crate::math::Ray;
    use crate::prepare::{EnvironmentSource, prepare};
    use crate::sampling::{hash_combine, unit_float};
    use crate::settings::PrepareSettings;
    use glam::{DAffine3, DVec3, Vec3};
    use kiln_formats::scene::{Camera, Instance, Material, Mesh, Projection};
    use kiln_formats::{Control, Scene};

    /// Needles and specks.
    fn heap() -> PreparedScene {
        let number = |i: u32, k: u32| unit_float(hash_combine(i, k)) * 2.0 - 1.0;
        let vector = |i: u32, k: u32| Vec3::new(number(i, k), number(i, k + 1), number(i, k + 2));
        let mut mesh = Mesh::default();
        for i in 0..60 {
            let (middle, size) = (vector(i, 0), [0.5, 0.05, 0.002][i as usize % 3]);
            let corners = [middle, middle + vector(i, 3) * size, middle + vector(i, 6) * (size * 0.02)];
            mesh.positions.extend(corners.map(|p| p.to_array()));
            mesh.triangles.push([3 * i, 3 * i + 1, 3 * i + 2]);
        }
        let mut scene = Scene { meshes: vec![mesh], materials: vec![Material::default()], ..Scene::default() };
        scene.instances.push(Instance { name: String::new(), mesh: 0, transform: DAffine3::IDENTITY });
        prepare(scene, &EnvironmentSource::None, &PrepareSettings::default(), &Control::default()).expect("not stopped")
    }

    #[test]
    fn whatever_a_ray_meets_is_in_an_occupied_square() {
        let prepared = heap();
        let (mut met, mut free) = (0, 0);
        for (round, projection) in
            [Projection::Perspective, Projection::Orthographic].into_iter().cycle().take(8).enumerate()
        {
            let from = |k: u32| f64::from(unit_float(hash_combine(round as u32, 90 + k))) - 0.5;
            let origin = DVec3::new(from(0), from(1), from(2)).normalize() * 4.0;
            let forward = -origin.normalize();
            let right = forward.any_orthonormal_vector();
            let (width, height) = (150, 70);
            let camera = Camera {
                name: String::new(),
                projection,
                origin,
                forward,
                right: right * 0.6,
                up: right.cross(forward) * 0.3,
                aspect: None,
            };
            let view = View { camera, width, height, show_environment: false };
            let camera = RayCamera::new(&view.camera, &prepared.frame);
            let occupied = Occupied::new(&prepared, &view, &camera).expect("all is before the camera");
            for pixel in (0..width * height).map(|k| [k % width, k / width]) {
                free += u32::from(!occupied.at(pixel));
                for sample in 0..4 {
                    let number = |k: u32| unit_float(hash_combine(hash_combine(pixel[0], pixel[1]), 2 * sample + k));
                    let ((origin, dir), _) = camera_ray(&view, &camera, pixel, [number(0), number(1)]);
                    let hit = prepared.tree.closest(&Ray { origin, dir, t_max: f32::INFINITY }, |_| true);
                    met += u32::from(hit.is_some());
                    assert!(hit.is_none() || occupied.at(pixel), "{pixel:?}");
                }
            }
        }
        assert!(met > 800 && free > 40_000, "{met} rays met something, {free} pixels are free");
    }

    #[test]
    fn a_camera_among_triangles_knows_nothing() {
        let prepared = heap();
        let camera = Camera {
            name: String::new(),
            projection: Projection::Perspective,
            origin: DVec3::ZERO,
            forward: DVec3::X,
            right: DVec3::Y,
            up: DVec3::Z,
            aspect: None,
        };
        let view = View { camera, width: 8, height: 8, show_environment: false };
        assert!(Occupied::new(&prepared, &view, &RayCamera::new(&view.camera, &prepared.frame)).is_none());
    }
}
