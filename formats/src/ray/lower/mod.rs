//! From the tree to the scene IR.

mod appearance;
mod camera;
mod lights;
mod mesh;
mod objects;
mod objfile;
mod textures;

use super::RayOptions;
use super::notes::Notes;
use super::source::{At, Offset, Source};
use super::tree::{Node, Object, Shape};
use crate::scene::{Instance, Mesh, MeshId};
use crate::{Control, ErrorCode, ImportError, Resources, Scene};
use appearance::{Appearance, Materials};
use camera::CameraState;
use glam::DAffine3;
use objects::{Detail, ShapeKey};
use std::collections::HashMap;
use textures::Textures;

type Result<T> = std::result::Result<T, ImportError>;

/// Resolves names, inheritance and nesting, loads textures and makes the scene.
///
/// # Errors
/// As [`super::import`], for what is wrong with a text of sound grammar.
pub(super) fn lower(
    nodes: Vec<Node>,
    source: Source<'_>,
    resources: &mut Resources,
    options: RayOptions,
    notes: &mut Notes<'_>,
    control: &Control,
) -> Result<Scene> {
    let mut lower = Lower {
        source,
        detail: Detail::for_scene(&nodes),
        resources,
        options,
        notes,
        control,
        scene: Scene::default(),
        textures: Textures::default(),
        materials: Materials::default(),
        shapes: HashMap::new(),
        triangles: 0,
    };
    lower.run(nodes)?;
    Ok(lower.scene)
}

/// What a level of nesting hands down.
#[derive(Clone, Copy, Default)]
struct Context {
    /// To the world.
    transform: DAffine3,
    /// What materials start from.
    material: Appearance,
}

struct Lower<'a, 'n> {
    source: Source<'a>,
    detail: Detail,
    resources: &'a mut Resources,
    options: RayOptions,
    notes: &'a mut Notes<'n>,
    control: &'a Control,
    scene: Scene,
    textures: Textures,
    materials: Materials,
    /// Meshes that several instances can share.
    shapes: HashMap<ShapeKey, MeshId>,
    /// Triangles drawn so far.
    triangles: u64,
}

impl Lower<'_, '_> {
    fn run(&mut self, nodes: Vec<Node>) -> Result<()> {
        let mut camera = CameraState::default();
        let mut context = Context::default();
        let mut outer: Vec<Context> = Vec::new();
        for node in nodes {
            self.control.check()?;
            match node {
                Node::Camera(block) => camera.update(block),
                Node::Light(light) => self.light(light)?,
                Node::Material(expression) => context.material = self.appearance(&expression, context.material)?,
                Node::Ignored(At { at, value: field }) => {
                    self.notes.warn("ignored-field", at, || format!("{field} is not known and passed over"));
                }
                Node::Object(object) => self.object(object, &context)?,
                Node::Transform(At { at, value }) => {
                    outer.push(context);
                    context.transform *= value.matrix;
                    if value.projective {
                        self.notes.warn("ignored-field", at, || {
                            "the last row of this matrix is not (0,0,0,1) and is ignored".into()
                        });
                    }
                    if !context.transform.is_finite() {
                        return Err(self.invalid(at, "this transform leaves the range of numbers"));
                    }
                }
                Node::Group => outer.push(context),
                Node::Close => context = outer.pop().unwrap_or_default(),
            }
        }
        self.camera(&camera)?;
        self.warn_about_shininess();
        if self.options.emit_ambient {
            self.emit_ambient();
        } else {
            self.warn_about_ambient_alone();
        }
        if self.triangles == 0 {
            return Err(ImportError::new(ErrorCode::Empty, "the scene has no geometry"));
        }
        Ok(())
    }

    fn object(&mut self, At { at, value: object }: At<Object>, context: &Context) -> Result<()> {
        let mut appearances = Vec::with_capacity(object.materials.len());
        for expression in &object.materials {
            appearances.push(self.appearance(expression, context.material)?);
        }
        let mut appearance = appearances.last().copied().unwrap_or(context.material);
        self.with_own(&mut appearance, &object)?;
        let Object { name, shape, .. } = object;
        let material = self.material(&appearance, at);
        match shape {
            Shape::Mesh(block) => {
                // What an entry of `materials` inherits: the mesh's material as read before it.
                let inherited = |after: usize| match after.checked_sub(1) {
                    Some(last) => appearances.get(last).copied().unwrap_or(context.material),
                    None => context.material,
                };
                let mut vertex_materials = Vec::with_capacity(block.vertex_materials.len());
                for entry in &block.vertex_materials {
                    vertex_materials.push(self.appearance(&entry.material, inherited(entry.after))?);
                }
                if let Some(mesh) = self.mesh(*block, at, &name, material, &appearance, &vertex_materials)? {
                    self.place(mesh, name, context.transform, at)?;
                }
            }
            shape => self.primitive(&shape, at, name, material, &appearance, &context.transform)?,
        }
        Ok(())
    }

    fn add_mesh(&mut self, mesh: Mesh) -> MeshId {
        self.scene.meshes.push(mesh);
        (self.scene.meshes.len() - 1) as MeshId
    }

    /// Adds an instance, within the limit of triangles.
    fn place(&mut self, mesh: MeshId, name: String, transform: DAffine3, at: Offset) -> Result<()> {
        self.triangles += self.scene.meshes.get(mesh as usize).map_or(0, |m| m.triangles.len() as u64);
        let limit = self.resources.limits().max_triangles;
        if self.triangles > limit {
            let message = format!("the scene has more triangles than the limit of {limit}");
            return Err(self.source.error(ErrorCode::TooLarge, at, message));
        }
        self.scene.instances.push(Instance { name, mesh, transform });
        Ok(())
    }

    fn invalid(&self, at: Offset, message: impl Into<String>) -> ImportError {
        self.source.error(ErrorCode::Invalid, at, message)
    }

    /// A number that must not be negative, such as a share of light: negative ones become 0, with a warning.
    fn not_negative<T: PartialOrd + Default>(&mut self, value: T, what: &str, at: Offset) -> T {
        if value >= T::default() {
            return value;
        }
        self.notes.warn("negative-value", at, || format!("{what} is negative and taken as 0"));
        T::default()
    }
}
