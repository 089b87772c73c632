use super::views;
use kiln_formats::scene::{
    AlphaMode, ColorSpace, Filter, Light, LightKind, Material, Pixels, Projection, Surface, Texture, UpAxis, Wrap,
};
use kiln_formats::{Contents, Format, Imported, Scene, Warning};
use serde::Serialize;

/// What is in an asset, for `kiln inspect`.
#[derive(Clone, Debug, Serialize)]
pub struct AssetFacts {
    /// Version of the JSON form (docs/inspect.md).
    pub schema: u32,
    /// Its format.
    pub format: Option<Format>,
    /// Files read, the asset with all that it refers to.
    pub files: u64,
    /// Triangles drawn, counted once per instance.
    pub triangles: u64,
    /// Vertices, counted once per mesh.
    pub vertices: u64,
    /// Meshes.
    pub meshes: u64,
    /// Placements of meshes.
    pub instances: u64,
    /// Lower and upper corner of everything drawn, world space.
    pub bounds: Option<[[f64; 3]; 2]>,
    /// Up axis.
    pub up: UpAxis,
    /// Materials.
    pub materials: Vec<MaterialFacts>,
    /// Textures.
    pub textures: Vec<TextureFacts>,
    /// Lights that are not surfaces.
    pub lights: Vec<LightFacts>,
    /// Cameras; the first is the default view.
    pub cameras: Vec<CameraFacts>,
    /// What the file says about itself.
    pub contents: Contents,
    /// What was mended or left out.
    pub warnings: Vec<Warning>,
}

/// A material.
#[derive(Clone, Debug, Serialize)]
pub struct MaterialFacts {
    /// Its name.
    pub name: String,
    /// `metal-rough`, `phong` or `unlit`.
    pub kind: &'static str,
    /// `opaque`, `mask` or `blend`.
    pub alpha: &'static str,
    /// Whether backs are shown.
    pub double_sided: bool,
    /// Whether it emits light.
    pub emits: bool,
    /// Indices of its textures, sorted.
    pub textures: Vec<u32>,
}

/// A texture.
#[derive(Clone, Debug, Serialize)]
pub struct TextureFacts {
    /// Name or file of its image.
    pub name: String,
    /// Width in texels.
    pub width: u32,
    /// Height in texels.
    pub height: u32,
    /// Bits per channel.
    pub bits: u32,
    /// `srgb` or `linear`.
    pub color_space: &'static str,
    /// `repeat`, `mirror` or `clamp`, along u and v.
    pub wrap: [&'static str; 2],
    /// `linear` or `nearest`.
    pub filter: &'static str,
}

/// A light.
#[derive(Clone, Debug, Serialize)]
pub struct LightFacts {
    /// Its name.
    pub name: String,
    /// `directional`, `point` or `spot`.
    pub kind: &'static str,
    /// Linear RGB: intensity or irradiance.
    pub color: [f32; 3],
}

/// A camera.
#[derive(Clone, Debug, Serialize)]
pub struct CameraFacts {
    /// Its name.
    pub name: String,
    /// Perspective or orthographic.
    pub projection: Projection,
    /// Vertical field of view in degrees (perspective).
    pub vertical_fov_deg: Option<f64>,
    /// Width / height, where the file fixes it.
    pub aspect: Option<f64>,
}

impl AssetFacts {
    /// Of an imported asset.
    pub fn of(format: Option<Format>, imported: &Imported) -> Self {
        let scene = &imported.scene;
        let corners = |(low, high): (glam::DVec3, glam::DVec3)| [low.to_array(), high.to_array()];
        Self {
            schema: 1,
            format,
            files: imported.files.len() as u64,
            triangles: scene.triangle_count(),
            vertices: scene.meshes.iter().map(|m| m.positions.len() as u64).sum(),
            meshes: scene.meshes.len() as u64,
            instances: scene.instances.len() as u64,
            bounds: views::bounds(scene).map(corners),
            up: scene.up,
            materials: scene.materials.iter().map(material).collect(),
            textures: scene.textures.iter().filter_map(|t| texture(scene, t)).collect(),
            lights: scene.lights.iter().map(light).collect(),
            cameras: scene.cameras.iter().map(camera).collect(),
            contents: imported.contents.clone(),
            warnings: imported.warnings.clone(),
        }
    }
}

fn material(material: &Material) -> MaterialFacts {
    let mut textures: Vec<u32> = material.textures().iter().map(|t| t.texture).collect();
    textures.sort_unstable();
    textures.dedup();
    MaterialFacts {
        name: material.name.clone(),
        kind: match material.surface {
            Surface::MetalRough(_) => "metal-rough",
            Surface::Phong(_) => "phong",
            Surface::Unlit(_) => "unlit",
        },
        alpha: match material.alpha.mode {
            AlphaMode::Opaque => "opaque",
            AlphaMode::Mask { .. } => "mask",
            AlphaMode::Blend => "blend",
        },
        double_sided: material.double_sided,
        emits: !material.emission.is_black(),
        textures,
    }
}

fn texture(scene: &Scene, texture: &Texture) -> Option<TextureFacts> {
    let image = scene.images.get(texture.image as usize)?;
    Some(TextureFacts {
        name: image.name.clone(),
        width: image.width,
        height: image.height,
        bits: match image.pixels {
            Pixels::Rgba8(_) => 8,
            Pixels::Rgba16(_) => 16,
            Pixels::RgbaF32(_) => 32,
        },
        color_space: match texture.color_space {
            ColorSpace::Srgb => "srgb",
            ColorSpace::Linear => "linear",
        },
        wrap: [texture.wrap_u, texture.wrap_v].map(|wrap| match wrap {
            Wrap::Repeat => "repeat",
            Wrap::Mirror => "mirror",
            Wrap::Clamp => "clamp",
        }),
        filter: match texture.filter {
            Filter::Linear => "linear",
            Filter::Nearest => "nearest",
        },
    })
}

fn light(light: &Light) -> LightFacts {
    let kind = match light.kind {
        LightKind::Directional => "directional",
        LightKind::Point { .. } => "point",
        LightKind::Spot { .. } => "spot",
    };
    LightFacts { name: light.name.clone(), kind, color: light.color }
}

fn camera(camera: &kiln_formats::scene::Camera) -> CameraFacts {
    let fov = 2.0 * libm::atan(camera.up.length() / camera.forward.length());
    CameraFacts {
        name: camera.name.clone(),
        projection: camera.projection,
        vertical_fov_deg: (camera.projection == Projection::Perspective).then(|| fov.to_degrees()),
        aspect: camera.aspect,
    }
}
