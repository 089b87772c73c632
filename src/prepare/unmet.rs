//! Triangles that no ray can ever stop at, whatever the view.

use super::parts::bounds_body;
use super::{Asks, PreparedScene};
use crate::geometry::{Geometry, coverage};
use glam::Vec3;
use kiln_formats::Scene;
use serde::Serialize;
use std::collections::HashMap;

/// How many triangles no ray stops at, and why. A triangle counts once.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct Unmet {
    /// They have no area: they are nowhere.
    pub without_area: u64,
    /// They let every ray through all over: they are not in the kd-tree.
    pub open: u64,
    /// An earlier triangle with the same corners in the same order stops every ray that would stop there: ties go to it.
    pub behind_twin: u64,
    /// As `behind_twin`, with the corners in another order, so that distances may round in another way.
    pub behind_turned_twin: u64,
}

/// The numbers of the triangles that a ray may stop at; `None` where that is all of them, as far as is known. With every effect
/// reckoned with, it is all of them.
pub(super) fn met(scene: &Scene, geometry: &Geometry, asks: &Asks) -> Option<Vec<u32>> {
    if !asks.knows_open() || !geometry.shapes().is_empty() {
        return None;
    }
    let met: Vec<u32> = (0..geometry.len() as u32).filter(|triangle| !is_open(scene, geometry, *triangle)).collect();
    (met.len() < geometry.len()).then_some(met)
}

/// Whether a triangle is known to let every ray through.
fn is_open(scene: &Scene, geometry: &Geometry, triangle: u32) -> bool {
    let (mesh, _) = geometry.source(scene, triangle);
    let material = &scene.materials[mesh.material as usize];
    // What is around bodies is asked in another way.
    if bounds_body(material) {
        return false;
    }
    let even = material.alpha.value.texture.is_none() && mesh.colors.is_empty();
    match geometry.known_coverage(triangle) {
        Some(whole) => !whole,
        None => even && coverage(scene, geometry, triangle, [1.0, 0.0, 0.0]) == 0.0,
    }
}

impl PreparedScene {
    /// Counts the triangles that no ray stops at. Looks at every triangle.
    pub fn unmet(&self) -> Unmet {
        let Self { scene, geometry, .. } = self;
        let mut unmet = Unmet { without_area: self.degenerate_triangles, ..Unmet::default() };
        let mut firsts: HashMap<[[u32; 3]; 3], u32> = HashMap::new();
        for triangle in 0..geometry.len() as u32 {
            if self.asks.knows_open() && geometry.shapes().is_empty() && is_open(scene, geometry, triangle) {
                unmet.open += 1;
                continue;
            }
            let corners = geometry.corners(triangle);
            let mut key = bits(corners);
            key.sort_unstable();
            let first = *firsts.entry(key).or_insert(triangle);
            if first == triangle {
                continue;
            }
            if !self.hides(first, triangle) {
                firsts.insert(key, triangle);
            } else if bits(geometry.corners(first)) == bits(corners) {
                unmet.behind_twin += 1;
            } else {
                unmet.behind_turned_twin += 1;
            }
        }
        unmet
    }

    /// Whether a triangle stops all rays that one behind it would.
    fn hides(&self, first: u32, behind: u32) -> bool {
        let Self { scene, geometry, ways, .. } = self;
        let [own, other] = [first, behind].map(|t| ways[geometry.part_index(t) as usize].filters);
        let body = |t| bounds_body(&scene.materials[geometry.material(scene, t) as usize]);
        let whole = !own.coverage || geometry.known_coverage(first) == Some(true);
        let culled_alike = other.culled && geometry.unit_normal(first) == geometry.unit_normal(behind);
        whole && (!own.culled || culled_alike) && !body(first) && !body(behind)
    }
}

/// Corners as numbers: a negative zero is a positive one.
fn bits(corners: [Vec3; 3]) -> [[u32; 3]; 3] {
    corners.map(|c| (c + Vec3::ZERO).to_array().map(f32::to_bits))
}

#[cfg(test)]
#[path = "unmet_tests.rs"]
mod tests;
