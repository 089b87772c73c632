//! Textures: those that materials use.

use super::pictures::{self, Encoded};
use super::report::Report;
use crate::scene::{ColorSpace, Filter, ImageId, Material, NormalMap, Scene, Surface, Texture, TextureRef, Wrap};
use crate::{Control, ImportError, Resources};
use gltf::json;
use gltf::json::texture::{MagFilter, WrappingMode};
use gltf::json::validation::Checked;
use std::collections::{BTreeMap, BTreeSet};

/// Textures asked for so far. Their numbers are provisional until [`Textures::load`].
#[derive(Default)]
pub(super) struct Textures {
    used: Vec<(usize, ColorSpace)>,
    ids: BTreeMap<(usize, bool), u32>,
}

impl Textures {
    /// A number for a glTF texture in a colour space.
    pub(super) fn id(&mut self, texture: usize, space: ColorSpace) -> u32 {
        *self.ids.entry((texture, space == ColorSpace::Srgb)).or_insert_with(|| {
            self.used.push((texture, space));
            (self.used.len() - 1) as u32
        })
    }

    /// The textures asked for, once each, though one may be read in two colour spaces.
    pub(super) fn wanted(&self) -> Vec<usize> {
        let mut known = BTreeSet::new();
        self.used.iter().map(|(texture, _)| *texture).filter(|t| known.insert(*t)).collect()
    }

    /// Decodes the images, puts them and the textures into the scene and corrects the materials: an input
    /// whose image cannot be had goes without it.
    ///
    /// # Errors
    /// Those of [`pictures::load`].
    pub(super) fn load(
        self,
        encoded: Encoded,
        resources: &mut Resources,
        scene: &mut Scene,
        report: &mut Report,
        control: &Control,
    ) -> Result<(), ImportError> {
        let wanted = self.wanted();
        let root = encoded.root;
        let found = pictures::load(&wanted, encoded, resources, &mut scene.images, report, control)?;
        let mut ids = Vec::new();
        let images: BTreeMap<usize, ImageId> =
            wanted.into_iter().zip(found).filter_map(|(texture, image)| Some((texture, image?))).collect();
        for (texture, space) in &self.used {
            ids.push(images.get(texture).map(|image| {
                scene.textures.push(build(root, *texture, *image, *space));
                (scene.textures.len() - 1) as u32
            }));
        }
        scene.materials.iter_mut().for_each(|m| renumber(m, &ids));
        Ok(())
    }
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
