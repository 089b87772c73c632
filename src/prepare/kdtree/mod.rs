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
mod deal;
mod instances;
mod judge;
mod leaves;
#[cfg(test)]
mod leaves_tests;
mod median;
mod mesh_tree;
mod references;
mod sah;
mod sah_simd;
mod sampled;
mod slab;
mod snap;
mod split;
mod validate;
mod wide;

use crate::cpu_clock::CpuMeter;
use crate::lanes::AnyLanes;
use crate::math::simd::SimdTier;
use crate::math::{Hit, Ray};
use crate::settings::KdTreeBuilder;
pub use batch::{Coherence, HitBatch, NO_TRIANGLE, RayBatch};
use glam::Vec3;
use instances::Instances;
pub use instances::{Instanced, Placed};
use kiln_formats::{Control, Stopped};
use mesh_tree::MeshTree;
use std::time::Instant;
use wide::packet::BlockLines;
use wide::packet_kept::TreeNumber;

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

    /// What hits on a triangle call it; numbers grow with the triangles.
    fn number(&self, triangle: u32) -> u32 {
        triangle
    }
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
    /// Placements of trees that are shared; 0 where there is one tree over everything.
    pub instances: u64,
    /// Wall seconds of the build.
    pub build_seconds: f64,
    /// CPU seconds of the build over all threads.
    pub build_cpu_seconds: f64,
}

/// A kd-tree over triangles, with a copy of their corners in its leaves; or several, placed in a common frame.
#[derive(Debug)]
pub struct KdTree {
    form: Form,
    kernel: wide::AnyKernel,
    lanes: AnyLanes,
    /// For packets.
    lines: BlockLines,
    statistics: Statistics,
}

#[derive(Debug)]
enum Form {
    One(MeshTree),
    Instances(Instances),
}

impl KdTree {
    /// Builds a tree on the current rayon pool; it is the same on any number of threads.
    ///
    /// # Errors
    /// [`Stopped`] when `control` asks for it.
    pub fn build(triangles: &impl Triangles, options: &BuildOptions, control: &Control) -> Result<Self, Stopped> {
        let begin = Instant::now();
        let cpu = CpuMeter::default();
        let tree = MeshTree::build(triangles, options, control, &cpu)?;
        let mut statistics = tree.statistics;
        statistics.build_seconds = begin.elapsed().as_secs_f64();
        statistics.build_cpu_seconds = cpu.seconds();
        Ok(Self::new(Form::One(tree), options, statistics))
    }

    /// Builds a tree of instances: one tree for each mesh, and one over their placements. It finds what a tree over all placed
    /// triangles finds, bit for bit.
    ///
    /// # Errors
    /// [`Stopped`] when `control` asks for it.
    pub fn build_instances<M: Triangles, O: Triangles>(
        scene: &Instanced<M, O>,
        options: &BuildOptions,
        control: &Control,
    ) -> Result<Self, Stopped> {
        let begin = Instant::now();
        let cpu = CpuMeter::default();
        let instances = Instances::build(scene, options, control, &cpu)?;
        let mut statistics = instances.statistics(scene);
        statistics.build_seconds = begin.elapsed().as_secs_f64();
        statistics.build_cpu_seconds = cpu.seconds();
        Ok(Self::new(Form::Instances(instances), options, statistics))
    }

    fn new(form: Form, options: &BuildOptions, statistics: Statistics) -> Self {
        let (kernel, lanes) = (wide::AnyKernel::new(options.simd), AnyLanes::new(options.simd));
        let table = match &form {
            Form::One(tree) => lanes.run(wide::packet_table::MakeTable(tree.wide())),
            Form::Instances(_) => None,
        };
        let lines = table.map_or_else(|| BlockLines::Lately(TreeNumber::next()), BlockLines::All);
        Self { form, kernel, lanes, lines, statistics }
    }

    /// The nearest hit with `0 < t < ray.t_max` among those that `accept` lets through; of several at the same distance
    /// the triangle of the lowest number. `accept` must answer alike when it is asked twice about a triangle and a ray.
    pub fn closest(&self, ray: &Ray, accept: impl FnMut(&Hit) -> bool) -> Option<Hit> {
        match &self.form {
            Form::One(tree) => self.kernel.nearest::<false>(tree.wide(), ray, accept),
            Form::Instances(all) => all.nearest::<false>(self.kernel, ray, accept),
        }
    }

    /// Whether any accepted hit lies on the ray.
    pub fn occluded(&self, ray: &Ray, accept: impl FnMut(&Hit) -> bool) -> bool {
        match &self.form {
            Form::One(tree) => self.kernel.nearest::<true>(tree.wide(), ray, accept).is_some(),
            Form::Instances(all) => all.nearest::<true>(self.kernel, ray, accept).is_some(),
        }
    }

    /// [`KdTree::closest`] by the planes of the binary tree, in plain code: the definition. Of instances, one after the other.
    pub fn closest_by_planes(&self, ray: &Ray, accept: impl FnMut(&Hit) -> bool) -> Option<Hit> {
        self.nearest_by_planes(ray, false, accept)
    }

    /// [`KdTree::occluded`] by the planes of the binary tree, in plain code: the definition.
    pub fn occluded_by_planes(&self, ray: &Ray, accept: impl FnMut(&Hit) -> bool) -> bool {
        self.nearest_by_planes(ray, true, accept).is_some()
    }

    fn nearest_by_planes(&self, ray: &Ray, any: bool, accept: impl FnMut(&Hit) -> bool) -> Option<Hit> {
        match &self.form {
            Form::One(tree) => binary::nearest(tree.binary(), ray, any, accept),
            Form::Instances(all) => all.nearest_by_planes(ray, any, accept),
        }
    }

    /// What the tree is like.
    pub fn statistics(&self) -> Statistics {
        self.statistics
    }

    /// Checks a tree of one mesh against the triangles that it was built over: cells are disjoint and cover the root, every
    /// triangle is in every cell that it touches, every reference is to a triangle of that place.
    ///
    /// # Errors
    /// What is wrong, in a sentence.
    pub fn validate(&self, triangles: &impl Triangles) -> Result<(), String> {
        match &self.form {
            Form::One(tree) => tree.validate(triangles),
            Form::Instances(_) => Err("a tree of instances is built over other triangles".into()),
        }
    }

    /// Checks a tree of instances: the trees of all meshes, and that the boxes of the placements hold their triangles.
    ///
    /// # Errors
    /// What is wrong, in a sentence.
    pub fn validate_instances<M: Triangles, O: Triangles>(&self, scene: &Instanced<M, O>) -> Result<(), String> {
        match &self.form {
            Form::One(_) => Err("no tree of instances".into()),
            Form::Instances(all) => all.validate(scene),
        }
    }

    /// Whether two trees have the same cells and the same leaves, word for word.
    pub fn same_as(&self, other: &Self) -> bool {
        match (&self.form, &other.form) {
            (Form::One(tree), Form::One(other)) => tree.same_as(other),
            (Form::Instances(all), Form::Instances(other)) => all.same_as(other),
            _ => false,
        }
    }
}
