//! The kd-tree: axis-aligned planes, disjoint cells, a triangle in every cell that it touches.
//!
//! [`build`] makes the binary tree, [`leaves`] lays out its triangles, [`binary`] traverses it by its planes: that is the
//! definition. Every other form finds the same hits, bit for bit, which are those of brute force over all triangles with
//! the test of [`crate::math::triangle`]; [`slab`] has the reason why no hit is lost.

mod aligned;
mod batch;
mod binary;
mod block;
mod bounds;
mod build;
mod built;
mod clip;
mod cpu;
mod leaves;
mod median;
mod sah;
mod sah_simd;
mod sampled;
mod slab;
mod snap;
mod split;
mod validate;
mod wide;

use crate::lanes::AnyLanes;
use crate::math::simd::SimdTier;
use crate::math::{Hit, Ray};
use crate::settings::KdTreeBuilder;
pub use batch::{Coherence, HitBatch, NO_TRIANGLE, RayBatch};
use bounds::Bounds;
use cpu::CpuMeter;
use glam::Vec3;
use kiln_formats::{Control, Stopped};
use std::time::Instant;

/// What a tree is built over. Vertices are finite and of magnitude up to 2e12; degenerate triangles do no harm.
pub trait Triangles: Sync {
    /// Number of triangles.
    fn len(&self) -> usize;

    /// Whether there are none.
    fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// The corners of a triangle.
    fn vertices(&self, triangle: u32) -> [Vec3; 3];
}

/// How a tree is built and traversed.
#[derive(Clone, Copy, Debug, Default)]
pub struct BuildOptions {
    /// How planes are chosen.
    pub builder: KdTreeBuilder,
    /// Selects the planes of [`KdTreeBuilder::Sampled`].
    pub seed: u64,
    /// The instructions that traversal may use; lowered to what the machine has.
    pub simd: SimdTier,
    /// How many rays will be traced, about, if that is known: what [`KdTreeBuilder::Auto`] goes by.
    pub planned_rays: Option<u64>,
}

/// A tree by the surface area heuristic takes up to 0.3 µs a triangle more than one by samples and saves some 0.03 µs a ray at
/// best in scenes of triangles of like size, more in others: with fewer rays a triangle it is not worth its time.
const RAYS_FOR_A_BETTER_TREE: u64 = 4;

impl BuildOptions {
    /// The builder to be used: a question of numbers of triangles and rays, never of a clock.
    fn builder_for(&self, triangles: usize) -> KdTreeBuilder {
        let few = |rays: u64| rays / RAYS_FOR_A_BETTER_TREE < triangles as u64;
        match self.builder {
            KdTreeBuilder::Auto if self.planned_rays.is_some_and(few) => KdTreeBuilder::Sampled,
            KdTreeBuilder::Auto => KdTreeBuilder::Sah,
            chosen => chosen,
        }
    }
}

/// What a tree is like.
#[derive(Clone, Copy, Debug, Default, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Statistics {
    /// Triangles.
    pub triangles: u64,
    /// Nodes of the binary tree, leaves included.
    pub nodes: u64,
    /// Leaves.
    pub leaves: u64,
    /// References from leaves to triangles.
    pub references: u64,
    /// Planes above the deepest leaf.
    pub depth: u32,
    /// Expected cost of a ray that meets the root, by the surface area heuristic.
    pub sah_cost: f64,
    /// Bytes of the tree and its leaves.
    pub bytes: u64,
    /// Wall seconds of the build.
    pub build_seconds: f64,
    /// CPU seconds of the build over all threads.
    pub build_cpu_seconds: f64,
}

/// A kd-tree over triangles, with a copy of their corners in its leaves.
#[derive(Debug)]
pub struct KdTree {
    bounds: Bounds,
    thickness: f32,
    nodes: Vec<binary::Node>,
    wide: Vec<wide::node::WideNode>,
    leaves: leaves::LeafStore,
    kernel: wide::AnyKernel,
    lanes: AnyLanes,
    statistics: Statistics,
}

impl KdTree {
    /// Builds a tree on the current rayon pool; it is the same on any number of threads.
    ///
    /// # Errors
    /// [`Stopped`] when `control` asks for it.
    pub fn build(triangles: &impl Triangles, options: &BuildOptions, control: &Control) -> Result<Self, Stopped> {
        let begin = Instant::now();
        let cpu = CpuMeter::default();
        let options = &BuildOptions { builder: options.builder_for(triangles.len()), ..*options };
        let built = build::build(triangles, options, control, &cpu)?;
        control.check()?;
        let contents = leaves::Contents::new(&built, triangles, &cpu);
        let wide::collapse::Collapsed { nodes: wide, leaves: places, planner } =
            cpu.measure(|| wide::collapse::collapse(&built, &contents.pools));
        control.check()?;
        let leaves = leaves::LeafStore::new(&contents, &places, &planner, triangles, &cpu);
        let nodes = cpu.measure(|| binary::compile(&built, &places));
        let bounds = built.cells.first().map_or(Bounds::EMPTY, |root| root.bounds);
        let largest = (0..3).map(|axis| bounds.lo(axis).abs().max(bounds.hi(axis).abs())).fold(0.0, f32::max);
        // Sums with planes may round by half an ulp of the coordinates.
        let thickness = 2.0 * built.thickness + largest * f32::EPSILON;
        let (kernel, lanes) = (wide::AnyKernel::new(options.simd), AnyLanes::new(options.simd));
        let mut tree =
            Self { bounds, thickness, nodes, wide, leaves, kernel, lanes, statistics: Statistics::default() };
        tree.statistics = Statistics {
            triangles: triangles.len() as u64,
            nodes: tree.nodes.len() as u64,
            leaves: places.len() as u64,
            references: built.triangles.len() as u64,
            depth: built.depth(),
            sah_cost: built.cost(),
            bytes: tree.bytes() as u64,
            build_seconds: begin.elapsed().as_secs_f64(),
            build_cpu_seconds: cpu.seconds(),
        };
        Ok(tree)
    }

    /// The nearest hit with `0 < t < ray.t_max` among those that `accept` lets through; of several at the same distance
    /// the triangle of the lowest number. `accept` must answer alike when it is asked twice about a triangle and a ray.
    pub fn closest(&self, ray: &Ray, accept: impl FnMut(&Hit) -> bool) -> Option<Hit> {
        self.kernel.nearest::<false>(self.wide(), ray, accept)
    }

    /// Whether any accepted hit lies on the ray.
    pub fn occluded(&self, ray: &Ray, accept: impl FnMut(&Hit) -> bool) -> bool {
        self.kernel.nearest::<true>(self.wide(), ray, accept).is_some()
    }

    /// [`KdTree::closest`] by the planes of the binary tree, in plain code: the definition.
    pub fn closest_by_planes(&self, ray: &Ray, accept: impl FnMut(&Hit) -> bool) -> Option<Hit> {
        binary::nearest(self.binary(), ray, false, accept)
    }

    /// [`KdTree::occluded`] by the planes of the binary tree, in plain code: the definition.
    pub fn occluded_by_planes(&self, ray: &Ray, accept: impl FnMut(&Hit) -> bool) -> bool {
        binary::nearest(self.binary(), ray, true, accept).is_some()
    }

    /// What the tree is like.
    pub fn statistics(&self) -> Statistics {
        self.statistics
    }

    /// Checks the tree against the triangles that it was built over: cells are disjoint and cover the root, every
    /// triangle is in every cell that it touches, every reference is to a triangle of that place.
    ///
    /// # Errors
    /// What is wrong, in a sentence.
    pub fn validate(&self, triangles: &impl Triangles) -> Result<(), String> {
        let boxes = wide::validate::check(self.wide(), self.binary())?;
        validate::check(self.binary(), &boxes, triangles)
    }

    /// Whether two trees have the same cells and the same leaves, word for word.
    pub fn same_as(&self, other: &Self) -> bool {
        self.nodes == other.nodes && self.wide == other.wide && self.leaves.words() == other.leaves.words()
    }

    fn bytes(&self) -> usize {
        size_of_val(self.nodes.as_slice()) + size_of_val(self.wide.as_slice()) + self.leaves.bytes()
    }

    fn wide(&self) -> wide::WideTree<'_> {
        wide::WideTree { nodes: &self.wide, leaves: &self.leaves, thickness: self.thickness }
    }

    fn binary(&self) -> binary::Tree<'_> {
        binary::Tree { nodes: &self.nodes, bounds: &self.bounds, thickness: self.thickness, leaves: &self.leaves }
    }
}
