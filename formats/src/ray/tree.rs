//! The file as a tree of plain data, before anything is resolved.
//!
//! Nesting is kept flat, in the order of the file: [`Node::Transform`] and [`Node::Group`] open a level that
//! [`Node::Close`] ends, so that no depth of nesting can overflow a stack.

use super::source::{At, Offset};
use glam::{DAffine3, DVec3};

/// One step of the file.
#[derive(Clone, Debug)]
pub(super) enum Node {
    Camera(At<CameraBlock>),
    Light(At<LightBlock>),
    /// Sets the default material of what follows, up to the end of its group.
    Material(MaterialExpr),
    Object(At<Object>),
    /// Opens a level: the matrix applies to one element.
    Transform(At<TransformBlock>),
    /// Opens a level of any number of elements.
    Group,
    /// Ends the innermost level.
    Close,
    /// A field that the dialect passes over.
    Ignored(At<String>),
}

#[derive(Clone, Copy, Debug)]
pub(super) struct TransformBlock {
    pub matrix: DAffine3,
    /// The last row is not (0, 0, 0, 1).
    pub projective: bool,
}

/// `camera { … }`: the fields that it sets.
#[derive(Clone, Debug, Default)]
pub(super) struct CameraBlock {
    pub position: Option<DVec3>,
    pub viewdir: Option<At<DVec3>>,
    pub updir: Option<At<DVec3>>,
    /// Vertical, degrees.
    pub fov: Option<At<f64>>,
    pub aspect_ratio: Option<At<f64>>,
    /// x, y, z, w.
    pub quaternion: Option<[f64; 4]>,
    pub look_at: Option<At<DVec3>>,
    pub focal_distance: Option<Offset>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum LightWord {
    Point,
    Directional,
    Ambient,
    Area,
}

/// `point_light { … }` and its kin.
#[derive(Clone, Debug)]
pub(super) struct LightBlock {
    pub word: LightWord,
    pub name: String,
    pub color: Option<At<DVec3>>,
    pub position: Option<At<DVec3>>,
    pub direction: Option<At<DVec3>>,
    /// Constant, linear and quadratic.
    pub attenuation: [At<f64>; 3],
    pub radius: Option<At<f64>>,
    pub side: Option<At<f64>>,
    pub u: Option<At<DVec3>>,
    pub v: Option<At<DVec3>>,
}

/// What stands behind `material =`.
#[derive(Clone, Debug)]
pub(super) enum MaterialExpr {
    /// A name given earlier.
    Named(At<String>),
    /// Changes to the context's material.
    Block(At<MaterialBlock>),
}

#[derive(Clone, Debug, Default)]
pub(super) struct MaterialBlock {
    pub name: Option<At<String>>,
    pub fields: Vec<MaterialField>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum FieldName {
    Emissive,
    Ambient,
    Diffuse,
    Specular,
    Reflective,
    Transmissive,
    Shininess,
    Index,
    BumpMapping,
}

#[derive(Clone, Debug)]
pub(super) struct MaterialField {
    pub at: Offset,
    pub name: FieldName,
    pub value: FieldValue,
}

#[derive(Clone, Debug)]
pub(super) enum FieldValue {
    Color([f32; 3]),
    Number(f32),
    /// The file of a texture.
    Map(String),
}

/// One primitive or mesh.
#[derive(Clone, Debug)]
pub(super) struct Object {
    pub name: String,
    /// Every `material` of the object, in order: the last holds, but names of all are registered.
    pub materials: Vec<MaterialExpr>,
    /// Textures that the object has in the dialects that give them to objects.
    pub maps: Vec<(ObjectMap, At<String>)>,
    /// `emission` of the object, which holds over the material's.
    pub emission: Option<At<[f32; 3]>>,
    pub shape: Shape,
}

/// What a texture of an object is for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum ObjectMap {
    Diffuse,
    Specular,
    Normal,
    Bump,
}

#[derive(Clone, Debug)]
pub(super) enum Shape {
    Sphere,
    Box,
    Square,
    Cylinder { capped: bool },
    Cone { height: f64, bottom: f64, top: f64, capped: bool },
    Mesh(Box<MeshBlock>),
}

/// `polymesh { … }`.
#[derive(Clone, Debug, Default)]
pub(super) struct MeshBlock {
    pub points: Vec<[f32; 3]>,
    pub normals: Vec<[f32; 3]>,
    /// v grows upwards, as in the file.
    pub uvs: Vec<[f32; 2]>,
    pub faces: Faces,
    pub vertex_materials: Vec<VertexMaterial>,
    pub generate_normals: bool,
    pub objfile: Option<At<String>>,
}

/// One entry of a mesh's `materials`.
#[derive(Clone, Debug)]
pub(super) struct VertexMaterial {
    /// How many of the object's `material` fields were read before it: it starts from the last of them.
    pub after: usize,
    pub material: MaterialExpr,
}

/// Polygons as one list of indices.
#[derive(Clone, Debug, Default)]
pub(super) struct Faces {
    /// Vertex indices as the file has them, so negative ones too.
    pub indices: Vec<i64>,
    /// Of each face: the place, and the end of its indices.
    pub ends: Vec<(Offset, usize)>,
}
