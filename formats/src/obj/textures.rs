//! Finds and decodes the images of the materials, each once.

use super::log::Log;
use super::map::Map;
use crate::repair::heights;
use crate::scene::{Channel, ColorSpace, Image, ImageId, Pixels, Texture, TextureId, TextureRef, Wrap};
use crate::{Control, ErrorCode, ImportError, Resources, images, parallel};
use std::collections::HashMap;
use std::path::PathBuf;
use std::sync::Arc;

/// What is worth knowing about an image's pixels.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Look {
    /// Some pixel is not opaque.
    pub(super) has_alpha: bool,
    /// The mean colour is that of a tangent-space normal map.
    pub(super) is_normal_map: bool,
}

/// All images of an asset with the textures made of them.
#[derive(Default)]
pub(super) struct Textures {
    pub(super) images: Vec<Image>,
    pub(super) textures: Vec<Texture>,
    looks: Vec<Look>,
    /// By library and file name.
    by_name: HashMap<(Arc<str>, String), ImageId>,
    by_use: HashMap<(ImageId, bool, bool), TextureId>,
    /// Normal maps made of height maps, by image, wrapping and channel.
    of_heights: HashMap<(ImageId, bool, u8), ImageId>,
}

impl Textures {
    /// Reads and decodes what `maps` name; what fails becomes a warning.
    ///
    /// # Errors
    /// [`ErrorCode::TooLarge`] when a limit is exceeded, [`ErrorCode::Stopped`].
    pub(super) fn load<'a>(
        maps: impl Iterator<Item = &'a Map>,
        resources: &mut Resources,
        log: &mut Log,
        control: &Control,
    ) -> Result<Self, ImportError> {
        let mut files: Vec<(Vec<u8>, &Map)> = Vec::new();
        let mut by_path: HashMap<PathBuf, usize> = HashMap::new();
        let mut wanted: HashMap<(&str, &str), Option<usize>> = HashMap::new();
        let mut order: Vec<(&str, &str)> = Vec::new();
        for map in maps {
            control.check()?;
            let key = (&*map.place.library, map.file.as_str());
            if wanted.contains_key(&key) {
                continue;
            }
            let found = match find(map, resources) {
                Ok((path, reference)) => match by_path.get(&path) {
                    Some(index) => Some(*index),
                    None => read(&reference, map, resources, log)?.map(|bytes| {
                        files.push((bytes, map));
                        by_path.insert(path, files.len() - 1);
                        files.len() - 1
                    }),
                },
                Err(error) => {
                    log.warn("missing-texture", &map.place, || format!("{error}; the material is shown without"));
                    None
                }
            };
            wanted.insert(key, found);
            order.push(key);
        }
        let decoded = decode(&files, resources.limits().max_texels, control)?;
        let mut all = Self::default();
        let mut ids: Vec<Option<ImageId>> = Vec::new();
        for (result, (_, map)) in decoded.into_iter().zip(&files) {
            ids.push(match result {
                Ok((image, look)) => {
                    all.images.push(image);
                    all.looks.push(look);
                    Some(all.images.len() as ImageId - 1)
                }
                Err(error) if error.code == ErrorCode::TooLarge => return Err(error),
                Err(error) => {
                    let code =
                        if error.code == ErrorCode::Unsupported { "unsupported-texture" } else { "broken-texture" };
                    log.warn(code, &map.place, || format!("{error}; the material is shown without"));
                    None
                }
            });
        }
        for key @ (library, file) in order {
            if let Some(Some(id)) = wanted.get(&key).copied().flatten().and_then(|index| ids.get(index)) {
                all.by_name.insert((library.into(), file.into()), *id);
            }
        }
        Ok(all)
    }

    /// A map's image as a texture, if it could be loaded.
    pub(super) fn texture(&mut self, map: &Map, color_space: ColorSpace) -> Option<TextureRef> {
        Some(self.texture_of(self.image(map)?, map, color_space))
    }

    /// The normal map of a map whose image holds heights, if it could be loaded.
    pub(super) fn normals_of_heights(&mut self, map: &Map) -> Option<TextureRef> {
        let source = self.image(map)?;
        let channel = map.channel.unwrap_or(Channel::R);
        let image = match self.of_heights.get(&(source, map.clamp, channel as u8)) {
            Some(image) => *image,
            None => {
                let normals = heights::to_normals(self.images.get(source as usize)?, channel, map.clamp);
                self.images.push(normals);
                self.looks.push(Look { has_alpha: false, is_normal_map: true });
                let id = self.images.len() as ImageId - 1;
                self.of_heights.insert((source, map.clamp, channel as u8), id);
                id
            }
        };
        Some(self.texture_of(image, map, ColorSpace::Linear))
    }

    fn image(&self, map: &Map) -> Option<ImageId> {
        self.by_name.get(&(map.place.library.clone(), map.file.clone())).copied()
    }

    fn texture_of(&mut self, image: ImageId, map: &Map, color_space: ColorSpace) -> TextureRef {
        let next = self.textures.len() as TextureId;
        let wrap = if map.clamp { Wrap::Clamp } else { Wrap::Repeat };
        let id = *self.by_use.entry((image, map.clamp, color_space == ColorSpace::Srgb)).or_insert(next);
        if id == next {
            self.textures.push(Texture { image, wrap_u: wrap, wrap_v: wrap, filter: Default::default(), color_space });
        }
        TextureRef { transform: map.transform(), ..TextureRef::new(id) }
    }

    /// What a map's image looks like, if it could be loaded.
    pub(super) fn look(&self, map: &Map) -> Option<Look> {
        self.looks.get(self.image(map)? as usize).copied()
    }
}

/// Where a name may lie: beside the MTL file, beside the OBJ file, and by its last part alone in both places.
fn find(map: &Map, resources: &Resources) -> Result<(PathBuf, String), ImportError> {
    let file = map.file.replace('\\', "/");
    let uncommented = map.file.split(" #").next().unwrap_or_default().trim().replace('\\', "/");
    let base = file.rsplit('/').next().unwrap_or_default();
    let folder = map.place.library.replace('\\', "/");
    let folder = folder.rsplit_once('/').map_or("", |(folder, _)| folder);
    let mut references: Vec<String> = Vec::new();
    for name in [file.as_str(), uncommented.as_str(), base] {
        for folder in [folder, ""] {
            let reference = if folder.is_empty() { name.to_owned() } else { format!("{folder}/{name}") };
            if !references.contains(&reference) {
                references.push(reference);
            }
        }
    }
    let mut first_error = None;
    for reference in references {
        match resources.resolve(&reference) {
            Ok(path) if path.is_file() => return Ok((path, reference)),
            Ok(_) => {}
            Err(error) => drop(first_error.get_or_insert(error)),
        }
    }
    let unnamed = || ImportError::new(ErrorCode::Io, "is not a file");
    Err(first_error.unwrap_or_else(unnamed).in_file(&map.file))
}

fn read(reference: &str, map: &Map, resources: &mut Resources, log: &mut Log) -> Result<Option<Vec<u8>>, ImportError> {
    match resources.read(reference) {
        Ok(bytes) => Ok(Some(bytes)),
        Err(error) if error.code == ErrorCode::TooLarge => Err(error),
        Err(error) => {
            log.warn("missing-texture", &map.place, || format!("{error}; the material is shown without"));
            Ok(None)
        }
    }
}

type Decoded = Result<(Image, Look), ImportError>;

fn decode(files: &[(Vec<u8>, &Map)], max_texels: u64, control: &Control) -> Result<Vec<Decoded>, ImportError> {
    // The limit holds for all together, and is looked at before anything is decoded.
    let mut texels = 0_u64;
    for (bytes, map) in files {
        if let Ok((width, height)) = images::dimensions(bytes, &map.file) {
            texels = texels.saturating_add(u64::from(width) * u64::from(height));
        }
    }
    if texels > max_texels {
        let message = format!("{texels} texels in all images together exceed the limit of {max_texels}");
        return Err(ImportError::new(ErrorCode::TooLarge, message));
    }
    let one = |(bytes, map): &(Vec<u8>, &Map)| {
        control.check()?;
        images::decode(bytes, &map.file, max_texels).map(|image| {
            let look = look(&image);
            (image, look)
        })
    };
    // A lone image is not worth waking other threads.
    let decoded = if files.len() > 1 {
        parallel::map_costly(files, control, |(bytes, _)| bytes.len(), one)
    } else {
        files.iter().map(one).collect()
    };
    control.check()?;
    Ok(decoded)
}

fn look(image: &Image) -> Look {
    match &image.pixels {
        Pixels::Rgba8(p) => look_at(p.as_chunks().0, |x| f64::from(x) / 255.0),
        Pixels::Rgba16(p) => look_at(p.as_chunks().0, |x| f64::from(x) / 65535.0),
        Pixels::RgbaF32(p) => look_at(p.as_chunks().0, f64::from),
    }
}

fn look_at<T: Copy + Sync>(pixels: &[[T; 4]], unit: impl Fn(T) -> f64) -> Look {
    let has_alpha = pixels.iter().any(|p| unit(p[3]) < 1.0);
    let mut sum = [0.0; 3];
    for [r, g, b, _] in pixels {
        for (sum, x) in sum.iter_mut().zip([*r, *g, *b]) {
            *sum += unit(x);
        }
    }
    let [r, g, b] = sum.map(|x| x / pixels.len().max(1) as f64);
    let is_normal_map = b > 0.8 && (r - 0.5).abs() < 0.12 && (g - 0.5).abs() < 0.12;
    Look { has_alpha, is_normal_map }
}
