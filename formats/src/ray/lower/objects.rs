use super::mesh::NO_UV;
use super::{Appearance, Lower, Result};
use crate::ray::shapes::{self, Tessellation};
use crate::ray::source::Offset;
use crate::ray::tree::{Node, Object, Shape};
use crate::scene::{MaterialId, Mesh, Primitive};
use glam::{DAffine3, DVec3};

/// Triangles that the spheres, and that the cylinders and cones of a scene may have together before they get coarser.
const ROUND_BUDGET: u64 = 4_000_000;
/// Subdivisions of a sphere at most: 20 480 triangles.
const SPHERE_LEVELS: u32 = 5;
/// Segments around a cylinder or cone at most.
const SEGMENTS: u32 = 256;

/// How finely round shapes are cut, the same for the whole scene.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Detail {
    pub sphere_levels: u32,
    pub segments: u32,
}

impl Detail {
    /// As fine as the budget allows, and never coarser than 320 triangles a sphere or 32 segments.
    pub fn for_scene(nodes: &[Node]) -> Self {
        let (mut spheres, mut bodies) = (0_u64, 0_u64);
        for node in nodes {
            if let Node::Object(object) = node {
                let Object { shape, .. } = &object.value;
                spheres += u64::from(matches!(shape, Shape::Sphere));
                bodies += u64::from(matches!(shape, Shape::Cylinder { .. } | Shape::Cone { .. }));
            }
        }
        let sphere_levels = (2..=SPHERE_LEVELS).rev().find(|l| spheres * (20 << (2 * l)) <= ROUND_BUDGET).unwrap_or(2);
        let fits = |segments: &u32| bodies * 4 * u64::from(*segments) <= ROUND_BUDGET;
        let segments = [SEGMENTS, 128, 64].into_iter().find(fits).unwrap_or(32);
        Self { sphere_levels, segments }
    }
}

/// Which primitives share a mesh.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) struct ShapeKey {
    word: u8,
    capped: bool,
    /// Bits of a cone's numbers.
    cone: [u64; 3],
    material: MaterialId,
}

impl ShapeKey {
    fn new(shape: &Shape, material: MaterialId) -> Self {
        let key = |word, capped, cone: [f64; 3]| Self { word, capped, cone: cone.map(f64::to_bits), material };
        match shape {
            Shape::Sphere | Shape::Mesh(_) => key(0, true, [0.0; 3]),
            Shape::Box => key(1, true, [0.0; 3]),
            Shape::Square => key(2, true, [0.0; 3]),
            Shape::Cylinder { capped } => key(3, *capped, [0.0; 3]),
            Shape::Cone { height, bottom, top, capped } => key(4, *capped, [height.abs(), bottom.abs(), top.abs()]),
        }
    }
}

impl Lower<'_, '_> {
    /// Adds a primitive: an instance of a mesh that all primitives of the same shape and material share.
    pub(super) fn primitive(
        &mut self,
        shape: &Shape,
        at: Offset,
        name: String,
        material: MaterialId,
        appearance: &Appearance,
        transform: &DAffine3,
    ) -> Result<()> {
        let mut transform = *transform;
        if let Shape::Cone { height, .. } = shape {
            if *height == 0.0 {
                self.notes.warn("empty-shape", at, || "a cone of height 0 is left out".into());
                return Ok(());
            }
            if *height < 0.0 {
                transform *= DAffine3::from_scale(DVec3::new(1.0, 1.0, -1.0));
            }
        }
        let key = ShapeKey::new(shape, material);
        let mesh = match self.shapes.get(&key) {
            Some(mesh) => *mesh,
            None => {
                let mut tessellation = match shape {
                    Shape::Sphere if appearance.wraps_spheres => shapes::globe(self.detail.segments / 2),
                    shape => self.tessellate(shape),
                };
                if appearance.is_textured() && tessellation.uvs.is_empty() {
                    self.warn_about_missing_uvs(at);
                    tessellation.uvs = vec![NO_UV; tessellation.positions.len()];
                }
                let Tessellation { positions, normals, uvs, triangles } = tessellation;
                let primitive = match shape {
                    Shape::Sphere if !appearance.wraps_spheres => Some(Primitive::Sphere),
                    Shape::Square | Shape::Cone { capped: false, .. } | Shape::Cylinder { capped: false } => {
                        Some(Primitive::Sheet)
                    }
                    _ => None,
                };
                let uvs = [uvs, Vec::new()];
                let mut mesh = Mesh { positions, normals, uvs, triangles, material, primitive, ..Mesh::default() };
                self.bend(&mut mesh, appearance, at);
                let mesh = self.add_mesh(mesh);
                self.shapes.insert(key, mesh);
                mesh
            }
        };
        self.place(mesh, name, transform, at)
    }

    fn tessellate(&self, shape: &Shape) -> Tessellation {
        let Detail { sphere_levels, segments } = self.detail;
        match shape {
            Shape::Sphere | Shape::Mesh(_) => shapes::sphere(sphere_levels),
            Shape::Box => shapes::cube(),
            Shape::Square => shapes::square(),
            Shape::Cylinder { capped } => shapes::cone(1.0, 1.0, 1.0, *capped, segments),
            Shape::Cone { height, bottom, top, capped } => {
                shapes::cone(height.abs(), bottom.abs(), top.abs(), *capped, segments)
            }
        }
    }
}
