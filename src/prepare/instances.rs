//! Which triangles are kept once for several placements, and the kd-tree of a scene that does so.

use super::kdtree::{BuildOptions, Instanced, KdTree, Placed, Triangles};
use crate::geometry::{Geometry, Shape, Sharing};
use crate::settings::Instances;
use glam::Vec3;
use kiln_formats::{Control, Stopped};

/// Shapes of so many triangles are worth a tree of their own.
const LEAST_TRIANGLES: u64 = 1000;
/// Copies of fewer triangles than these are no burden.
const LEAST_SAVED: u64 = 200_000;
/// Copies of so many triangles, some 130 bytes each and twice as much while their tree is built, are too many for any gain of speed.
const MOST_COPIED: u64 = 1_000_000;
/// A copy of a triangle takes as long to be built into a tree as so many rays gain by meeting copies.
const RAYS_FOR_A_COPY: u64 = 10;

/// From when on triangles are shared: a question of numbers of triangles and rays, never of a clock.
pub fn sharing(asked: Instances, planned_rays: Option<u64>) -> Sharing {
    let worth = planned_rays.map_or(0, |rays| rays / RAYS_FOR_A_COPY);
    match asked {
        Instances::Auto => {
            Sharing { least_triangles: LEAST_TRIANGLES, least_saved: worth.clamp(LEAST_SAVED, MOST_COPIED) }
        }
        Instances::Always => Sharing::ALWAYS,
        Instances::Never => Sharing::NEVER,
    }
}

impl Triangles for Geometry {
    fn len(&self) -> usize {
        Geometry::len(self)
    }

    fn vertices(&self, triangle: u32) -> [Vec3; 3] {
        self.corners(triangle)
    }
}

impl Triangles for Shape {
    fn len(&self) -> usize {
        Shape::len(self)
    }

    fn vertices(&self, triangle: u32) -> [Vec3; 3] {
        self.corners(triangle)
    }
}

/// Some triangles alone: those that no placement shares with another, or that a ray may stop at.
struct Own<'a> {
    geometry: &'a Geometry,
    numbers: Vec<u32>,
}

impl Triangles for Own<'_> {
    fn len(&self) -> usize {
        self.numbers.len()
    }

    fn vertices(&self, triangle: u32) -> [Vec3; 3] {
        self.geometry.corners(self.number(triangle))
    }

    fn number(&self, triangle: u32) -> u32 {
        self.numbers[triangle as usize]
    }
}

/// The kd-tree of a scene; where no triangle is shared, of those that are `met`, or of all.
///
/// # Errors
/// [`Stopped`] when `control` asks for it.
pub fn build(
    geometry: &Geometry,
    met: Option<Vec<u32>>,
    options: &BuildOptions,
    control: &Control,
) -> Result<KdTree, Stopped> {
    match met {
        _ if !geometry.shapes().is_empty() => {}
        Some(numbers) => return KdTree::build(&Own { geometry, numbers }, options, control),
        None => return KdTree::build(geometry, options, control),
    }
    let placed: Vec<Placed> = geometry
        .shared_parts()
        .map(|(part, shape, bounds)| Placed {
            mesh: shape,
            placement: part.placement,
            first: part.first_triangle,
            bounds,
        })
        .collect();
    let own = Own { geometry, numbers: geometry.own_triangles() };
    KdTree::build_instances(&Instanced { meshes: geometry.shapes(), placed: &placed, own: &own }, options, control)
}
