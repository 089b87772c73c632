//! Which triangles have to be asked whether they stop a ray: a bit for each, so that the answer for all others, mostly most of
//! them, comes from the nearest cache.

use super::{Filters, PartWay};
use crate::geometry::Geometry;

/// Scenes with more triangles have no bits: 2 MiB for each question.
const MOST: usize = 1 << 24;

/// Triangles that may let a ray pass.
#[derive(Debug, Default)]
pub(crate) struct Questions {
    /// By their coverage, any ray. Empty where none does, or in a scene without bits.
    coverage: Vec<u64>,
    /// As single-sided backs, camera rays; likewise.
    culling: Vec<u64>,
    /// Everything has to be asked.
    every: bool,
}

impl Questions {
    /// By what is asked of parts, and what is known of triangles.
    pub fn new(geometry: &Geometry, ways: &[PartWay]) -> Self {
        let any = |of: fn(&Filters) -> bool| ways.iter().any(|way| of(&way.filters));
        let (covers, culls) = (any(|filters| filters.coverage), any(|filters| filters.culled));
        if geometry.len() > MOST {
            return Self { every: covers || culls, ..Self::default() };
        }
        let filters = |triangle: u32| ways[geometry.part_index(triangle) as usize].filters;
        let bits = |asked: bool, of: &dyn Fn(u32) -> bool| match asked {
            true => marked(geometry.len() as u32, of),
            false => Vec::new(),
        };
        Self {
            coverage: bits(covers, &|triangle| {
                filters(triangle).coverage && geometry.known_coverage(triangle) != Some(true)
            }),
            culling: bits(culls, &|triangle| filters(triangle).culled),
            every: false,
        }
    }

    /// Whether a triangle may let a ray pass, one from the camera where `eye`.
    #[inline]
    pub fn asks(&self, triangle: u32, eye: bool) -> bool {
        let holds =
            |bits: &[u64]| bits.get(triangle as usize / 64).is_some_and(|word| word >> (triangle % 64) & 1 != 0);
        self.every || holds(&self.coverage) || eye && holds(&self.culling)
    }
}

/// A bit for each of so many triangles.
fn marked(count: u32, of: &dyn Fn(u32) -> bool) -> Vec<u64> {
    let word = |first: u32| (first..count.min(first + 64)).fold(0, |word, t| word | u64::from(of(t)) << (t % 64));
    (0..count).step_by(64).map(word).collect()
}
