//! Where in a picture camera rays can meet anything at all. Most of a thumbnail is empty.

use super::View;
use super::camera::RayCamera;
use crate::prepare::PreparedScene;

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

    /// Whether a ray through a pixel may meet anything.
    pub fn at(&self, [x, y]: [u32; 2]) -> bool {
        self.blocks[(y / BLOCK) as usize * self.across + (x / BLOCK) as usize]
    }
}
