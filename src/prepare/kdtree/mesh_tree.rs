//! The tree over the triangles of one mesh, or of a whole scene, in all its forms.

use super::bounds::Bounds;
use super::{BuildOptions, Statistics, Triangles, binary, block, build, leaves, validate, wide};
use crate::cpu_clock::CpuMeter;
use crate::math::simd::SimdTier;
use kiln_formats::{Control, Stopped};

/// Corners that pools may have: AVX2 takes seven instructions to pick from more than sixteen.
fn most_corners(tier: SimdTier) -> usize {
    if tier.available() == SimdTier::Avx2 { block::POOL / 2 } else { block::POOL }
}

/// A tree over triangles, with a copy of their corners in its leaves.
#[derive(Debug)]
pub struct MeshTree {
    /// The box around everything.
    pub bounds: Bounds,
    /// What the tree is like; without the times of the build.
    pub statistics: Statistics,
    thickness: f32,
    nodes: Vec<binary::Node>,
    wide: Vec<wide::node::WideNode>,
    leaves: leaves::LeafStore,
}

impl MeshTree {
    /// Builds it on the current rayon pool.
    pub fn build<T: Triangles>(
        triangles: &T,
        options: &BuildOptions,
        control: &Control,
        cpu: &CpuMeter,
    ) -> Result<Self, Stopped> {
        let options = &BuildOptions { builder: options.builder_for(triangles.len()), ..*options };
        let built = build::build(triangles, options, control, cpu)?;
        control.check()?;
        let (grouping, contents) = rayon::join(
            || cpu.measure(|| wide::grouping::Grouping::new(&built)),
            || leaves::Contents::new(&built, triangles, most_corners(options.simd), cpu),
        );
        let mut planner = leaves::Planner::new(&contents.pools);
        let wide = cpu.measure(|| wide::collapse::collapse(&built, &grouping, &mut planner));
        control.check()?;
        let (nodes, leaves) = rayon::join(
            || cpu.measure(|| binary::compile(&built, planner.leaves())),
            || leaves::LeafStore::new(&contents, &planner, triangles, cpu),
        );
        let bounds = built.cells.first().map_or(Bounds::EMPTY, |root| root.bounds);
        let largest = (0..3).map(|axis| bounds.lo(axis).abs().max(bounds.hi(axis).abs())).fold(0.0, f32::max);
        // Sums with planes may round by half an ulp of the coordinates.
        let thickness = 2.0 * built.thickness + largest * f32::EPSILON;
        let mut tree = Self { bounds, thickness, nodes, wide, leaves, statistics: Statistics::default() };
        tree.statistics = Statistics {
            triangles: triangles.len() as u64,
            nodes: tree.nodes.len() as u64,
            leaves: planner.leaves().len() as u64,
            references: built.triangles.len() as u64,
            depth: built.depth(),
            sah_cost: built.cost(),
            bytes: tree.bytes() as u64,
            ..Statistics::default()
        };
        Ok(tree)
    }

    /// See [`super::KdTree::validate`].
    pub fn validate<T: Triangles>(&self, triangles: &T) -> Result<(), String> {
        let boxes = wide::validate::check(self.wide(), self.binary())?;
        validate::check(self.binary(), &boxes, triangles)
    }

    /// See [`super::KdTree::same_as`].
    pub fn same_as(&self, other: &Self) -> bool {
        self.nodes == other.nodes && self.wide == other.wide && self.leaves.words() == other.leaves.words()
    }

    fn bytes(&self) -> usize {
        size_of_val(self.nodes.as_slice()) + size_of_val(self.wide.as_slice()) + self.leaves.bytes()
    }

    /// Its compiled form.
    #[inline(always)]
    pub fn wide(&self) -> wide::WideTree<'_> {
        wide::WideTree { nodes: &self.wide, leaves: &self.leaves, thickness: self.thickness }
    }

    /// Its binary form.
    pub fn binary(&self) -> binary::Tree<'_> {
        binary::Tree { nodes: &self.nodes, bounds: &self.bounds, thickness: self.thickness, leaves: &self.leaves }
    }
}
