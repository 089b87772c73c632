//! One tree for each mesh, under a tree over the placements of the meshes.
//!
//! What is found is what a tree over all placed triangles would find, bit for bit: [`place`] has triangles met where they are
//! placed, [`space`] has the cells that hold them found in the coordinates of the mesh. A ray goes through the instances whose
//! boxes it enters ([`walk`]); many rays at once, each in an instance of its own ([`stream`]). The definition takes the trees one
//! after the other, each by its planes.

pub mod place;
mod space;
mod stream;
mod top;
mod walk;

use super::batch::RayBatch;
use super::bounds::Bounds;
use super::mesh_tree::MeshTree;
use super::slab::{RELATIVE_ERROR, SlabRay};
use super::wide::AnyKernel;
use super::wide::node::WideNode;
use super::{BuildOptions, Statistics, Triangles, binary};
use crate::cpu_clock::CpuMeter;
use crate::math::triangle::{Nearest, ShearedRay};
use crate::math::{Hit, Placement, Ray};
use glam::{DVec3, Vec3};
use kiln_formats::{Control, Stopped};
use place::Placing;
use space::Space;

/// What a tree of instances is built over.
#[derive(Debug)]
pub struct Instanced<'a, M, O> {
    /// Triangles of meshes, each in coordinates of its own. Their magnitudes lie within 1e-6 and 1e6; each mesh has some.
    pub meshes: &'a [M],
    /// Where they are placed.
    pub placed: &'a [Placed],
    /// Triangles in the common frame that nobody shares, with numbers of their own.
    pub own: &'a O,
}

/// A placement of a mesh.
#[derive(Clone, Copy, Debug)]
pub struct Placed {
    /// Which of the meshes.
    pub mesh: u32,
    /// From its coordinates to the common frame; invertible.
    pub placement: Placement,
    /// What hits call its first triangle; the others follow.
    pub first: u32,
    /// The box around its placed triangles: lower and upper corner.
    pub bounds: (Vec3, Vec3),
}

/// A tree somewhere.
#[derive(Clone, Debug)]
struct Member {
    tree: u32,
    first: u32,
    /// Its coordinates, where they are not the common ones.
    space: Option<Space>,
}

impl Member {
    #[inline(always)]
    fn placement(&self) -> Option<&Placement> {
        self.space.as_ref().map(|space| &space.placement)
    }
}

/// Trees of meshes, where they are placed, and a tree over these places.
#[derive(Debug)]
pub struct Instances {
    trees: Vec<MeshTree>,
    members: Vec<Member>,
    top: Vec<WideNode>,
    boxes: Vec<Bounds>,
}

impl Instances {
    /// Builds the trees on the current rayon pool.
    pub fn build<M: Triangles, O: Triangles>(
        scene: &Instanced<M, O>,
        options: &BuildOptions,
        control: &Control,
        cpu: &CpuMeter,
    ) -> Result<Self, Stopped> {
        let build = |mesh: &M| MeshTree::build(mesh, options, control, cpu);
        let mut trees = scene.meshes.iter().map(build).collect::<Result<Vec<_>, _>>()?;
        let own_reach: Vec<DVec3> = trees.iter().map(|tree| reach(&tree.bounds)).collect();
        let member = |placed: &Placed| Member {
            tree: placed.mesh,
            first: placed.first,
            space: Some(Space::new(&placed.placement, own_reach[placed.mesh as usize], placed.bounds)),
        };
        let mut members: Vec<Member> = scene.placed.iter().map(member).collect();
        let mut boxes: Vec<Bounds> = scene.placed.iter().map(|placed| around(placed.bounds)).collect();
        if !scene.own.is_empty() {
            trees.push(MeshTree::build(scene.own, options, control, cpu)?);
            members.push(Member { tree: trees.len() as u32 - 1, first: 0, space: None });
            boxes.extend(trees.last().map(|tree| tree.bounds));
        }
        control.check()?;
        let top = cpu.measure(|| top::build(&boxes));
        Ok(Self { trees, members, top, boxes })
    }

    /// The nearest accepted hit, or with `ANY` whichever accepted hit is found first.
    pub fn nearest<const ANY: bool>(
        &self,
        kernel: AnyKernel,
        ray: &Ray,
        accept: impl FnMut(&Hit) -> bool,
    ) -> Option<Hit> {
        if self.top.is_empty() { None } else { kernel.run(walk::Single::<ANY, _> { all: self, ray, accept }) }
    }

    /// [`Instances::nearest`] for each ray of a batch.
    pub fn trace<const ANY: bool>(
        &self,
        kernel: AnyKernel,
        rays: &RayBatch,
        stops: impl FnMut(usize, &Hit) -> bool,
        mut found: impl FnMut(usize, Option<Hit>),
    ) {
        if self.top.is_empty() {
            return (0..rays.len()).for_each(|ray| found(ray, None));
        }
        kernel.run(stream::Stream::<ANY, _, _> { all: self, rays, stops, found });
    }

    /// [`Instances::nearest`] by the planes of the binary trees, in plain code: the definition.
    pub fn nearest_by_planes(&self, ray: &Ray, any: bool, mut accept: impl FnMut(&Hit) -> bool) -> Option<Hit> {
        let (sheared, mut nearest) = (ShearedRay::new(ray), Nearest::new(ray));
        let mut placing = Placing::new();
        for member in &self.members {
            let mut slab = SlabRay::default();
            match &member.space {
                Some(space) => drop(space.set(&mut slab, ray)),
                None => slab.set(ray),
            }
            placing.set(member.placement(), member.first);
            let tree = self.trees[member.tree as usize].binary();
            if binary::walk(tree, &sheared, &slab, &mut nearest, any, &mut placing, &mut accept) && any {
                break;
            }
        }
        nearest.hit
    }

    /// Whether all trees have the same cells and leaves.
    pub fn same_as(&self, other: &Self) -> bool {
        self.top == other.top
            && self.trees.len() == other.trees.len()
            && self.trees.iter().zip(&other.trees).all(|(tree, other)| tree.same_as(other))
    }

    /// Sums over the trees, each counted once; costs count as often as rays meet an instance.
    pub fn statistics<M: Triangles, O: Triangles>(&self, scene: &Instanced<M, O>) -> Statistics {
        let root = Bounds::around(&self.boxes).half_area();
        let share = |bounds: &Bounds| if root > 0.0 { f64::from(bounds.half_area() / root) } else { 0.0 };
        let trees = self.trees.iter().map(|tree| &tree.statistics);
        let mut all = Statistics::default();
        for tree in trees {
            all.nodes += tree.nodes;
            all.leaves += tree.leaves;
            all.references += tree.references;
            all.bytes += tree.bytes;
            all.depth = all.depth.max(tree.depth);
        }
        all.bytes += (size_of_val(self.top.as_slice()) + size_of_val(self.boxes.as_slice())) as u64;
        for (member, bounds) in self.members.iter().zip(&self.boxes) {
            let tree = &self.trees[member.tree as usize].statistics;
            all.triangles += tree.triangles;
            all.sah_cost += share(bounds) * tree.sah_cost;
            all.bytes += size_of::<Member>() as u64;
        }
        all.instances = scene.placed.len() as u64;
        all
    }

    /// See [`super::KdTree::validate_instances`].
    pub fn validate<M: Triangles, O: Triangles>(&self, scene: &Instanced<M, O>) -> Result<(), String> {
        for (number, (mesh, tree)) in scene.meshes.iter().zip(&self.trees).enumerate() {
            tree.validate(mesh).map_err(|e| format!("mesh {number}: {e}"))?;
        }
        for (number, (placed, bounds)) in scene.placed.iter().zip(&self.boxes).enumerate() {
            let mesh = &scene.meshes[placed.mesh as usize];
            let corners = (0..mesh.len() as u32).flat_map(|t| mesh.vertices(t));
            let leaves = |corner: Vec3| {
                let at = placed.placement.point(corner.to_array());
                !(0..3).all(|axis| bounds.lo(axis) < at[axis] && at[axis] < bounds.hi(axis))
            };
            if corners.into_iter().any(leaves) {
                return Err(format!("placement {number} leaves its box"));
            }
        }
        Ok(())
    }
}

/// The box that rays are tested against: hits may lie beside their triangles by a fraction of the triangles' sizes.
fn around((lo, hi): (Vec3, Vec3)) -> Bounds {
    let extent = (hi - lo).max_element();
    Bounds::new(lo.to_array(), hi.to_array()).widened(extent * RELATIVE_ERROR + f32::MIN_POSITIVE)
}

/// The largest magnitudes of coordinates in a box.
fn reach(bounds: &Bounds) -> DVec3 {
    let along = |axis: usize| f64::from(bounds.lo(axis).abs().max(bounds.hi(axis).abs()));
    DVec3::new(along(0), along(1), along(2))
}
