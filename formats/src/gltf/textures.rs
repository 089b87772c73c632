//! Textures and images: only those that materials use, each decoded once.

use super::basisu;
use super::buffers::Buffers;
use super::report::Report;
use super::uri;
use crate::scene::{ColorSpace, Filter, Image, Material, NormalMap, Scene, Surface, Texture, TextureRef, Wrap};
use crate::{Control, ErrorCode, ImportError, Limits, Place, Resources, images, parallel};
use gltf::json;
use gltf::json::texture::{MagFilter, WrappingMode};
use gltf::json::validation::Checked;
use std::borrow::Cow;
use std::collections::BTreeMap;

/// Textures asked for so far. Their numbers are provisional until [`Textures::load`].
#[derive(Default)]
pub(super) struct Textures {
    used: Vec<(usize, ColorSpace)>,
    ids: BTreeMap<(usize, bool), u32>,
}

/// What tells one encoded image from another.
#[derive(PartialEq, Eq, PartialOrd, Ord)]
enum Key<'a> {
    Uri(&'a str),
    View(usize),
}

impl Textures {
    /// A number for a glTF texture in a colour space.
    pub(super) fn id(&mut self, texture: usize, space: ColorSpace) -> u32 {
        *self.ids.entry((texture, space == ColorSpace::Srgb)).or_insert_with(|| {
            self.used.push((texture, space));
            (self.used.len() - 1) as u32
        })
    }

    /// Loads and decodes the images, puts them and the textures into the scene and corrects the materials: an input
    /// whose image cannot be had goes without it.
    ///
    /// # Errors
    /// [`ErrorCode::TooLarge`] when the images' headers claim more texels than the limit; [`ErrorCode::Stopped`].
    pub(super) fn load(
        self,
        root: &json::Root,
        buffers: &Buffers,
        resources: &mut Resources,
        scene: &mut Scene,
        report: &mut Report,
        control: &Control,
    ) -> Result<(), ImportError> {
        let mut distinct: BTreeMap<Key, Option<usize>> = BTreeMap::new();
        let mut encoded: Vec<(usize, Cow<[u8]>)> = Vec::new();
        let mut choices = Vec::new();
        for (texture, space) in &self.used {
            control.check()?;
            let choice = source(root, *texture, report).and_then(|(image, key)| {
                *distinct.entry(key).or_insert_with_key(|key| {
                    let bytes = match key {
                        Key::Uri(uri) => uri::load(uri, resources).map(Cow::Owned),
                        Key::View(view) => {
                            let view = json::Index::new(u32::try_from(*view).unwrap_or(u32::MAX));
                            buffers.view(root, view, &|| format!("/images/{image}/bufferView")).map(|v| v.bytes.into())
                        }
                    };
                    match bytes {
                        // Exporters write the same picture under several names.
                        Ok(bytes) => encoded.iter().position(|(_, known)| *known == bytes).or_else(|| {
                            encoded.push((image, bytes));
                            Some(encoded.len() - 1)
                        }),
                        Err(error) => {
                            report.warn("missing-texture", format!("/images/{image}"), error.to_string());
                            None
                        }
                    }
                })
            });
            choices.push((*texture, *space, choice));
        }
        let decoded = decode(root, &encoded, resources.limits(), control)?;
        let mut image_ids = Vec::new();
        for ((image, _), result) in encoded.iter().zip(decoded) {
            image_ids.push(match result {
                Ok(pixels) => {
                    scene.images.push(pixels);
                    Some((scene.images.len() - 1) as u32)
                }
                Err(error) if error.code == ErrorCode::Stopped => return Err(error),
                Err(error) => {
                    let unsupported = error.code == ErrorCode::Unsupported;
                    let code = if unsupported { "unsupported-texture" } else { "broken-texture" };
                    report.warn(code, format!("/images/{image}"), error.message);
                    None
                }
            });
        }
        let mut ids = Vec::new();
        for (texture, space, choice) in choices {
            let image = choice.and_then(|c| image_ids.get(c).copied().flatten());
            ids.push(image.map(|image| {
                scene.textures.push(build(root, texture, image, space));
                (scene.textures.len() - 1) as u32
            }));
        }
        scene.materials.iter_mut().for_each(|m| renumber(m, &ids));
        Ok(())
    }
}

/// The image of a texture, and what tells it from others.
fn source<'a>(root: &'a json::Root, texture: usize, report: &mut Report) -> Option<(usize, Key<'a>)> {
    let place = || format!("/textures/{texture}");
    let source = root.textures.get(texture)?;
    let other = |name: &str| {
        let extension = source.extensions.as_ref()?.others.get(name)?;
        usize::try_from(extension.get("source")?.as_u64()?).ok()
    };
    let extensions = ["EXT_texture_webp", "KHR_texture_basisu", "MSFT_texture_dds"].map(other);
    let candidates = [extensions[0], extensions[1], Some(source.source.value()), extensions[2]];
    let Some(index) = candidates.into_iter().flatten().find(|i| *i < root.images.len()) else {
        if other("EXT_texture_avif").is_some() {
            let message = "its only image is AVIF, which is not decoded; its inputs go without it";
            report.warn("unsupported-texture", place(), message);
        } else {
            report.warn("missing-texture", place(), "names no image that can be read; its inputs go without it");
        }
        return None;
    };
    let image = root.images.get(index)?;
    match (&image.uri, image.buffer_view) {
        (Some(uri), _) => Some((index, Key::Uri(uri))),
        (None, Some(view)) => Some((index, Key::View(view.value()))),
        (None, None) => {
            report.warn("missing-texture", format!("/images/{index}"), "the image has no data");
            None
        }
    }
}

type Decoded = Vec<Result<Image, ImportError>>;

fn decode(
    root: &json::Root,
    encoded: &[(usize, Cow<[u8]>)],
    limits: &Limits,
    control: &Control,
) -> Result<Decoded, ImportError> {
    let mut texels = 0u64;
    for (image, bytes) in encoded {
        texels = texels.saturating_add(stated_texels(bytes));
        if texels > limits.max_texels {
            let message = format!("the images have more than {} texels", limits.max_texels);
            return Err(ImportError::new(ErrorCode::TooLarge, message).at(Place::Json(format!("/images/{image}"))));
        }
    }
    let decode = |(image, bytes): &(usize, Cow<[u8]>)| {
        control.check()?;
        let decode = if basisu::is_ktx2(bytes) { basisu::decode } else { images::decode };
        let decoded = decode(bytes, &name(root, *image), limits.max_texels);
        control.advance(1);
        decoded
    };
    Ok(parallel::map(encoded, control, decode))
}

/// Width times height by the header, 0 where it cannot be read.
fn stated_texels(bytes: &[u8]) -> u64 {
    if basisu::is_ktx2(bytes) {
        return basisu::stated_texels(bytes);
    }
    images::dimensions(bytes, "").map_or(0, |(w, h)| u64::from(w) * u64::from(h))
}

fn name(root: &json::Root, index: usize) -> String {
    let image = root.images.get(index);
    let file = image.and_then(|i| i.uri.as_deref()).filter(|uri| !uri.starts_with("data:"));
    let name = image.and_then(|i| i.name.as_deref()).filter(|n| !n.is_empty());
    file.or(name).map_or_else(|| format!("images/{index}"), str::to_owned)
}

fn build(root: &json::Root, texture: usize, image: u32, color_space: ColorSpace) -> Texture {
    let sampler = root.textures.get(texture).and_then(|t| t.sampler).and_then(|s| root.samplers.get(s.value()));
    let wrap = |mode: Option<Checked<WrappingMode>>| match mode {
        Some(Checked::Valid(WrappingMode::ClampToEdge)) => Wrap::Clamp,
        Some(Checked::Valid(WrappingMode::MirroredRepeat)) => Wrap::Mirror,
        _ => Wrap::Repeat,
    };
    let filter = match sampler.and_then(|s| s.mag_filter) {
        Some(Checked::Valid(MagFilter::Nearest)) => Filter::Nearest,
        _ => Filter::Linear,
    };
    Texture {
        image,
        wrap_u: wrap(sampler.map(|s| s.wrap_s)),
        wrap_v: wrap(sampler.map(|s| s.wrap_t)),
        filter,
        color_space,
    }
}

/// Replaces the provisional texture numbers of a material; `None` takes the texture away.
fn renumber(material: &mut Material, ids: &[Option<u32>]) {
    let new = |reference: TextureRef| {
        let texture = ids.get(reference.texture as usize).copied().flatten()?;
        Some(TextureRef { texture, ..reference })
    };
    let normal_map = |n: NormalMap| Some(NormalMap { texture: new(n.texture)?, ..n });
    let mut slots = vec![&mut material.emission.texture, &mut material.alpha.value.texture];
    match &mut material.surface {
        Surface::MetalRough(m) => {
            slots.extend([
                &mut m.base_color.texture,
                &mut m.metallic.texture,
                &mut m.roughness.texture,
                &mut m.specular.texture,
                &mut m.specular_color.texture,
                &mut m.transmission.texture,
            ]);
            if let Some(layers) = &mut m.layers {
                layers.clearcoat_normal_map = layers.clearcoat_normal_map.and_then(normal_map);
                slots.extend(layers.texture_slots());
            }
        }
        Surface::Unlit(color) => slots.push(&mut color.texture),
        Surface::Phong(_) => {}
    }
    slots.into_iter().for_each(|slot| *slot = slot.and_then(new));
    material.normal_map = material.normal_map.and_then(normal_map);
}
