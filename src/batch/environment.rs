use super::digest;
use crate::prepare::{EnvironmentSource, SharedEnvironment, has_own_light};
use crate::settings::{EnvironmentFile, EnvironmentSettings};
use crate::write::{exr, srgb};
use kiln_formats::scene::{Image, Pixels};
use kiln_formats::{Format, Limits, Scene, images};
use std::path::Path;
use std::sync::{Arc, Mutex, PoisonError};

/// A decoded environment picture with linear pixels.
#[derive(Clone, Debug)]
pub struct LoadedEnvironment {
    image: Arc<Image>,
    digest: String,
    name: String,
    /// As it was last asked for, with rotation and intensity.
    shared: Arc<Mutex<Option<Asked>>>,
}

/// Rotation and intensity, bit for bit, and the tables made for them.
type Asked = ([u32; 2], Arc<SharedEnvironment>);

impl LoadedEnvironment {
    /// Reads an environment picture.
    ///
    /// # Errors
    /// A sentence with the file's name.
    pub fn read(path: &Path) -> Result<Self, String> {
        let limits = Limits::default();
        let in_file = |message: String| format!("environment {}: {message}", path.display());
        let size = path.metadata().map_err(|e| in_file(format!("cannot be read: {e}")))?.len();
        if size > limits.max_file_bytes {
            return Err(in_file(format!("is larger than the limit of {} bytes", limits.max_file_bytes)));
        }
        let bytes = std::fs::read(path).map_err(|e| in_file(format!("cannot be read: {e}")))?;
        let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
        let image = decode(&bytes, &name, limits.max_texels).map_err(in_file)?;
        Ok(Self { image: Arc::new(image), digest: digest::of_bytes(&bytes), name, shared: Arc::default() })
    }

    /// Hash of the file.
    pub fn digest(&self) -> &str {
        &self.digest
    }
}

fn decode(bytes: &[u8], name: &str, max_texels: u64) -> Result<Image, String> {
    const EXR_MAGIC: [u8; 4] = [0x76, 0x2f, 0x31, 0x01];
    if bytes.starts_with(&EXR_MAGIC) {
        let picture = exr::decode(bytes, max_texels)?;
        let values = picture.pixels.into_flattened().into_iter().map(|x| if x.is_finite() { x } else { 0.0 }).collect();
        return Ok(Image {
            name: name.into(),
            width: picture.width,
            height: picture.height,
            pixels: Pixels::RgbaF32(values),
        });
    }
    let image = images::decode(bytes, name, max_texels).map_err(|e| e.message)?;
    let linear = match image.pixels {
        Pixels::RgbaF32(values) => values,
        Pixels::Rgba8(values) => values.iter().map(|v| srgb::decode(f32::from(*v) / 255.0)).collect(),
        Pixels::Rgba16(values) => values.iter().map(|v| srgb::decode(f32::from(*v) / 65535.0)).collect(),
    };
    Ok(Image { pixels: Pixels::RgbaF32(linear), ..image })
}

/// Whether an asset is to be shown in its own light.
///
/// In glTF and OBJ files emissive surfaces are mostly screens, lamps and exporters' habits that nobody means to light the asset
/// with: rasterisers let them light nothing. There only punctual lights count, and emission stronger than a display's white
/// (KHR_materials_emissive_strength; the lamps of OBJ scenes for path tracers).
pub fn lights_itself(scene: &Scene, format: Option<Format>) -> bool {
    let least = match format {
        Some(Format::Gltf) => 1.0,
        // A lamp may be just as bright as white.
        Some(Format::Obj) => 0.99,
        Some(Format::Ray) | None => 0.0,
    };
    has_own_light(scene, least)
}

/// The light that an asset gets beside its own, with the manifest's words for what lights it.
pub fn choose(
    scene: &Scene,
    format: Option<Format>,
    settings: &EnvironmentSettings,
    loaded: Option<&Arc<LoadedEnvironment>>,
) -> (EnvironmentSource, String) {
    let own = lights_itself(scene, format);
    let with_own = |word: &str| if own { format!("own + {word}") } else { word.into() };
    match settings {
        EnvironmentSettings::Auto if own => (EnvironmentSource::None, "own".into()),
        EnvironmentSettings::None => (EnvironmentSource::None, if own { "own" } else { "none" }.into()),
        EnvironmentSettings::Auto | EnvironmentSettings::Studio => (EnvironmentSource::Studio, with_own("studio")),
        EnvironmentSettings::Constant(radiance) => (EnvironmentSource::Constant(*radiance), with_own("constant")),
        EnvironmentSettings::File(file) => match loaded {
            Some(loaded) => (source(file, loaded), with_own(&loaded.name)),
            None => (EnvironmentSource::None, if own { "own" } else { "none" }.into()),
        },
    }
}

fn source(file: &EnvironmentFile, loaded: &LoadedEnvironment) -> EnvironmentSource {
    let (rotation_y, intensity) = (file.rotation_y_deg.to_radians() as f32, file.intensity as f32);
    let asked = [rotation_y.to_bits(), intensity.to_bits()];
    let mut shared = loaded.shared.lock().unwrap_or_else(PoisonError::into_inner);
    let new = || (asked, Arc::new(SharedEnvironment::new(loaded.image.clone(), rotation_y, intensity)));
    let kept = shared.take().filter(|(kept, _)| *kept == asked).unwrap_or_else(new);
    EnvironmentSource::Shared(shared.insert(kept).1.clone())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::film::Picture;
    use crate::write::Metadata;
    use kiln_formats::scene::{ColorInput, Instance, Material, Mesh};

    #[test]
    fn assets_without_light_get_the_studio_and_it_is_said() {
        let drawn = |material: Material| {
            let instance = Instance { name: String::new(), mesh: 0, transform: glam::DAffine3::IDENTITY };
            let (meshes, instances) = (vec![Mesh::default()], vec![instance]);
            Scene { materials: vec![material], meshes, instances, ..Scene::default() }
        };
        let dark = drawn(Material::default());
        let lit = drawn(Material { emission: ColorInput::WHITE, ..Material::default() });
        let words = |scene, settings: &EnvironmentSettings| choose(scene, None, settings, None).1;
        assert!(matches!(choose(&dark, None, &EnvironmentSettings::Auto, None).0, EnvironmentSource::Studio));
        assert!(matches!(choose(&lit, None, &EnvironmentSettings::Auto, None).0, EnvironmentSource::None));
        assert_eq!(words(&dark, &EnvironmentSettings::Auto), "studio");
        assert_eq!(words(&lit, &EnvironmentSettings::Auto), "own");
        assert_eq!(words(&dark, &EnvironmentSettings::None), "none");
        assert_eq!(words(&lit, &EnvironmentSettings::Constant([1.0; 3])), "own + constant");
        // A glTF file's emission is a lamp only when it is stronger than 1.
        assert!(!lights_itself(&lit, Some(Format::Gltf)) && lights_itself(&lit, Some(Format::Obj)));
        let faint = Material { emission: ColorInput::constant([0.1; 3]), ..Material::default() };
        assert!(!lights_itself(&drawn(faint.clone()), Some(Format::Obj)));
        assert!(lights_itself(&drawn(faint), Some(Format::Ray)));
        let strong = Material { emission: ColorInput::constant([0.0, 5.0, 0.0]), ..Material::default() };
        assert!(lights_itself(&drawn(strong), Some(Format::Gltf)));
    }

    #[test]
    fn exr_environments_are_read_and_broken_ones_named() {
        let folder = tempfile::tempdir().expect("temporary folder");
        let metadata = Metadata {
            software: String::new(),
            source: String::new(),
            content: String::new(),
            settings: String::new(),
            seed: 0,
            spp: 1,
            view: 0,
            stated: None,
            denoised: None,
        };
        let picture =
            Picture { width: 2, height: 1, pixels: vec![[1.0, 2.0, 30.0, 1.0], [f32::INFINITY, 0.0, 0.5, 1.0]] };
        let path = folder.path().join("sky.exr");
        std::fs::write(&path, exr::encode(&picture, &metadata).expect("small")).expect("write");
        let loaded = LoadedEnvironment::read(&path).expect("sound");
        assert_eq!((loaded.image.width, loaded.image.height, loaded.name.as_str()), (2, 1, "sky.exr"));
        let Pixels::RgbaF32(values) = &loaded.image.pixels else { panic!("floats") };
        assert_eq!(values[..], [1.0, 2.0, 30.0, 1.0, 0.0, 0.0, 0.5, 1.0]);
        // Its tables are made once, and anew for another light.
        let file = |intensity| EnvironmentFile { path: path.clone(), rotation_y_deg: 0.0, intensity };
        let shared = |intensity| match source(&file(intensity), &loaded) {
            EnvironmentSource::Shared(shared) => shared,
            other => panic!("{other:?}"),
        };
        assert!(Arc::ptr_eq(&shared(1.0), &shared(1.0)) && !Arc::ptr_eq(&shared(1.0), &shared(2.0)));
        std::fs::write(&path, b"no picture at all").expect("write");
        assert!(LoadedEnvironment::read(&path).expect_err("broken").contains("sky.exr"));
        assert!(LoadedEnvironment::read(&folder.path().join("none.hdr")).is_err());
    }
}
