//! Bodies that touch: surfaces of others in the very place where a path goes through one.
//!
//! A ray that goes on begins beyond where rounding could have put the surface, and so beyond any other surface there: it would
//! leave one body and never enter the next, whose glass then looks like air, or the other way round.

use super::medium::bounds_body;
use super::vertex::Place;
use crate::math::Ray;
use crate::prepare::PreparedScene;
use kiln_formats::scene::MaterialId;

/// Surfaces in one place that are told apart; further ones are passed over.
const MOST: usize = 3;

/// Surfaces of bodies at a place beside that of the place itself, each kind once: material, and whether it is met from the front.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Touching {
    surfaces: [(MaterialId, bool); MOST],
    count: usize,
}

impl Touching {
    /// Those between where a ray would begin on one side of the surface and where it would begin on the other. Nothing, at no
    /// cost, where no other body's box touches that of the body.
    pub(super) fn at(prepared: &PreparedScene, place: &Place) -> Self {
        let mut found = Self::default();
        let geometry = &prepared.geometry;
        if !prepared.ways[geometry.part_index(place.triangle) as usize].touches {
            return found;
        }
        let (origin, end) = place.sides();
        let ray = Ray { origin, dir: end - origin, t_max: 1.0 };
        prepared.tree.occluded(&ray, |hit| {
            let material = geometry.material(&prepared.scene, hit.triangle);
            let front = ray.dir.dot(geometry.unit_normal(hit.triangle)) < 0.0;
            if (material, front) != (place.material, place.front) && bounds_body(prepared, material) {
                found.add((material, front));
            }
            false
        });
        found
    }

    /// Adds a surface at its place in the order, which does not depend on how the tree is traversed.
    fn add(&mut self, surface: (MaterialId, bool)) {
        let key = |(material, front): (MaterialId, bool)| (front, material);
        let at = self.surfaces[..self.count].partition_point(|s| key(*s) < key(surface));
        if at == MOST || self.surfaces[..self.count].get(at) == Some(&surface) {
            return;
        }
        self.count = MOST.min(self.count + 1);
        self.surfaces[at..self.count].rotate_right(1);
        self.surfaces[at] = surface;
    }

    /// All of them, those of bodies that are left first.
    pub(super) fn surfaces(&self) -> impl Iterator<Item = (MaterialId, bool)> {
        self.surfaces.into_iter().take(self.count)
    }

    /// The body that is entered where one is left, or left where one is entered.
    pub(super) fn other_way(&self, front: bool) -> Option<MaterialId> {
        self.surfaces().find(|(_, other)| *other != front).map(|(material, _)| material)
    }
}
