//! The scene IR: what every importer makes and the renderer takes.
//!
//! What a [`Scene`] that passes [`Scene::validate`] guarantees: every index is in range, every number is finite,
//! vertex attributes are as long as their positions or empty, geometry is triangles only, textures are decoded,
//! node hierarchies are composed into one `f64` transform per instance. World axes are right-handed.
//! Lengths are in the file's own unit (glTF: metres), angles in radians, colours linear Rec. 709.

mod camera;
mod light;
mod material;
mod mesh;
mod texture;
mod validate;

pub use camera::{Camera, Projection};
pub use light::{Extent, Falloff, Light, LightKind};
pub use material::{
    Alpha, AlphaMode, Channel, ColorInput, Layers, Material, MetalRough, NormalMap, Phong, ScalarInput, Surface, Volume,
};
pub use mesh::{Instance, Mesh, Primitive};
pub use texture::{ColorSpace, Filter, Image, Pixels, Texture, TextureRef, UvTransform, Wrap};
pub use validate::InvalidScene;

/// Index into [`Scene::meshes`].
pub type MeshId = u32;
/// Index into [`Scene::materials`].
pub type MaterialId = u32;
/// Index into [`Scene::textures`].
pub type TextureId = u32;
/// Index into [`Scene::images`].
pub type ImageId = u32;

/// Which world axis the asset calls "up"; turntables turn around it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum UpAxis {
    /// +Y (glTF always; OBJ by habit).
    #[default]
    Y,
    /// +Z.
    Z,
}

/// One asset, complete: geometry, materials, lights and cameras, with nothing left to read from disk.
#[derive(Clone, Debug, Default)]
pub struct Scene {
    /// Up axis for automatic framing and turntables.
    pub up: UpAxis,
    /// Triangle meshes in object space; each is drawn as often as `instances` name it.
    pub meshes: Vec<Mesh>,
    /// Placements of meshes in the world.
    pub instances: Vec<Instance>,
    /// Materials. Meshes name at least one, so this is not empty when there are meshes.
    pub materials: Vec<Material>,
    /// Images with their way of being sampled.
    pub textures: Vec<Texture>,
    /// Decoded images.
    pub images: Vec<Image>,
    /// Punctual and directional lights. Emissive surfaces are a property of their material.
    pub lights: Vec<Light>,
    /// The asset's own cameras; the first is its default view.
    pub cameras: Vec<Camera>,
    /// Sum of `.ray` ambient lights; only look-alike integrators use it.
    pub ambient: [f32; 3],
}

impl Scene {
    /// Triangles drawn, counted once per instance.
    pub fn triangle_count(&self) -> u64 {
        self.instances.iter().filter_map(|i| self.meshes.get(i.mesh as usize)).map(|m| m.triangles.len() as u64).sum()
    }

    /// Checks every guarantee that the module documentation gives.
    ///
    /// # Errors
    /// The first broken guarantee, with the path of the offending item, such as `meshes[3].triangles[17]`.
    pub fn validate(&self) -> Result<(), InvalidScene> {
        validate::images(self)?;
        validate::validate_but_images(self)
    }

    /// [`Scene::validate`] of a scene whose images need not have pixels.
    pub(crate) fn validate_but_images(&self) -> Result<(), InvalidScene> {
        validate::validate_but_images(self)
    }
}
