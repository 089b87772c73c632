//! The effects that a prepared scene calls for.

use super::PreparedScene;
use super::asks::drawn;
use crate::effects::{AttributeBytes, Called, attribute_bytes, called_for};
use crate::lighting::Environment;
use crate::settings::Effect;

impl PreparedScene {
    /// The effects that the scene calls for, with reasons; areas are those in the world. Looks at every triangle.
    pub fn effects(&self) -> Vec<Called> {
        let mut called = called_for(&self.scene, &self.mesh_areas());
        called.extend(self.environment());
        called
    }

    /// What its vertices and images hold.
    pub fn attribute_bytes(&self) -> AttributeBytes {
        attribute_bytes(&self.scene)
    }

    /// Their names alone, without a look at the triangles.
    pub fn effect_names(&self) -> Vec<&'static str> {
        let called = called_for(&self.scene, &drawn(&self.scene, &self.geometry));
        called.into_iter().chain(self.environment()).map(|called| called.effect.name()).collect()
    }

    /// World-space areas of the scene's meshes, all placements together, in the unit of the rays' frame.
    fn mesh_areas(&self) -> Vec<f64> {
        let geometry = &self.geometry;
        let mut areas = vec![0.0; self.scene.meshes.len()];
        for triangle in 0..geometry.len() as u32 {
            let [a, b, c] = geometry.corners(triangle).map(|corner| corner.as_dvec3());
            areas[geometry.part(triangle).mesh as usize] += 0.5 * (b - a).cross(c - a).length();
        }
        areas
    }

    fn environment(&self) -> Option<Called> {
        let reason = match self.lights.environment.as_ref()? {
            Environment::Constant(_) => "the same light from everywhere",
            Environment::Map(_) => "light from a picture all around",
        };
        Some(Called { effect: Effect::Environment, reason: reason.into(), area: None })
    }
}
