use super::{MaterialId, MeshId};
use glam::DAffine3;

/// What the triangles of a `.ray` primitive stand for. Only look-alike integrators ask.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Primitive {
    /// The unit sphere about the origin of object space.
    Sphere,
    /// An open surface whose normal always turns to the viewer.
    Sheet,
}

/// Triangles in object space with attributes per vertex. Counter-clockwise corners show the front.
#[derive(Clone, Debug, Default)]
pub struct Mesh {
    /// Name in the file, or empty.
    pub name: String,
    /// Vertex positions, object space.
    pub positions: Vec<[f32; 3]>,
    /// Shading normals, one per position and not necessarily of unit length, or empty: the faces are flat.
    pub normals: Vec<[f32; 3]>,
    /// Tangents (xyz) and handedness (w = ±1) in the sense of glTF, one per position or empty.
    pub tangents: Vec<[f32; 4]>,
    /// Two sets of texture coordinates, each one per position or empty. v grows downwards: (0, 0) is the centre
    /// of no texel but the upper left corner of the image, as in glTF. Importers of formats with v upwards flip.
    pub uvs: [Vec<[f32; 2]>; 2],
    /// Linear RGBA that multiplies the base or diffuse colour and alpha, one per position or empty.
    pub colors: Vec<[f32; 4]>,
    /// Three vertex indices per triangle.
    pub triangles: Vec<[u32; 3]>,
    /// The material of all triangles.
    pub material: MaterialId,
    /// One [`super::Surface::Phong`] material per position, all their fields interpolated (`.ray` meshes with
    /// `materials`), or empty: `material` holds everywhere.
    pub vertex_materials: Vec<MaterialId>,
    /// What the triangles stand for, where they are more than themselves.
    pub primitive: Option<Primitive>,
}

/// One placement of a mesh in the world.
#[derive(Clone, Debug)]
pub struct Instance {
    /// Name of the node, or empty.
    pub name: String,
    /// The mesh placed.
    pub mesh: MeshId,
    /// Object to world, composed over the whole hierarchy in double precision. May be reflecting or sheared.
    /// Singular ones are legal here: the renderer drops what has no area.
    pub transform: DAffine3,
}
