//! Which triangles have to be asked whether they stop a ray: a bit for each, so that the answer for all others, mostly most of
//! them, comes from the nearest cache.

use super::{Filters, PartWay};
use crate::geometry::Geometry;
use serde::Serialize;

/// Scenes with more triangles have no bits: 2 MiB for each question.
const MOST: usize = 1 << 24;

/// Of how many triangles something has to be asked at hits.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct Asked {
    /// All triangles.
    pub triangles: u64,
    /// Those that may let any ray pass by their coverage.
    pub coverage: u64,
    /// Those that let camera rays pass from behind.
    pub culling: u64,
    /// Whether rays ask on their way; otherwise only where the nearest surface of all lets a ray pass.
    pub on_the_way: bool,
}

/// Triangles that may let a ray pass.
#[derive(Debug, Default)]
pub(crate) struct Questions {
    /// By their coverage, any ray. Empty where none does, or in a scene without bits.
    coverage: Vec<u64>,
    /// As single-sided backs, camera rays; likewise.
    culling: Vec<u64>,
    /// As smooth walls, light samples; likewise.
    walls: Vec<u64>,
    /// Everything has to be asked.
    every: bool,
    /// Of how many triangles coverage is asked, and culling.
    asked: [u64; 2],
    triangles: u64,
    /// Of how many triangles in the tree coverage is asked, and how many there are.
    in_tree: [u64; 2],
}

impl Questions {
    /// By what is asked of parts, and what is known of triangles; `met`: those that are in the tree, where they are not all.
    pub fn new(geometry: &Geometry, ways: &[PartWay], met: Option<&[u32]>) -> Self {
        let any = |of: fn(&Filters) -> bool| ways.iter().any(|way| of(&way.filters));
        let (covers, culls) = (any(|filters| filters.coverage), any(|filters| filters.culled));
        if geometry.len() > MOST {
            let triangles = geometry.len() as u64;
            let asked = [covers, culls].map(|asked| if asked { triangles } else { 0 });
            return Self { every: covers || culls, asked, triangles, ..Self::default() };
        }
        let filters = |triangle: u32| ways[geometry.part_index(triangle) as usize].filters;
        let bits = |asked: bool, of: &dyn Fn(u32) -> bool| match asked {
            true => marked(geometry.len() as u32, of),
            false => Vec::new(),
        };
        let coverage =
            bits(covers, &|triangle| filters(triangle).coverage && geometry.known_coverage(triangle) != Some(true));
        let culling = bits(culls, &|triangle| filters(triangle).culled);
        let walls = bits(any(|filters| filters.walls), &|triangle| filters(triangle).walls);
        let asked = [&coverage, &culling].map(|bits| bits.iter().map(|word| u64::from(word.count_ones())).sum());
        let triangles = geometry.len() as u64;
        let mut questions =
            Self { coverage, culling, walls, every: false, asked, triangles, in_tree: [asked[0], triangles] };
        if let Some(met) = met {
            let uncertain = met.iter().filter(|triangle| questions.asks(**triangle, false)).count();
            questions.in_tree = [uncertain as u64, met.len() as u64];
        }
        questions
    }

    /// Whether any ray has to ask most triangles of the tree: then it is best to ask on the way. Otherwise most rays meet one first that
    /// stops them.
    pub fn mostly(&self) -> bool {
        self.every || 2 * self.in_tree[0] > self.in_tree[1]
    }

    /// Numbers for people.
    pub fn asked(&self) -> Asked {
        let [coverage, culling] = self.asked;
        Asked { triangles: self.triangles, coverage, culling, on_the_way: self.mostly() && coverage + culling > 0 }
    }

    /// Whether a triangle is a smooth wall; `None` in a scene without bits.
    #[inline]
    pub fn wall(&self, triangle: u32) -> Option<bool> {
        self.walls.get(triangle as usize / 64).map(|word| word >> (triangle % 64) & 1 != 0)
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
