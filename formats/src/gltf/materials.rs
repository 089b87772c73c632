//! Materials: metal and roughness with their extensions.

use super::layers::Object;
use super::report::Report;
use super::textures::Textures;
use super::uv_sets::{FIRST_TWO, UvSets};
use crate::scene::{
    Alpha, AlphaMode, Channel, ColorInput, ColorSpace, Layers, Material, MetalRough, NormalMap, ScalarInput, Surface,
    TextureRef, UvTransform, Volume,
};
use gltf::json;
use gltf::json::extensions::material::Material as Extensions;
use gltf::json::extensions::texture::TextureTransform;
use gltf::json::material as source;
use gltf::json::texture::Info;
use gltf::json::validation::Checked;

/// Materials converted so far.
#[derive(Default)]
pub(super) struct Materials {
    /// The scene's materials.
    pub(super) list: Vec<Material>,
    /// Textures that they use.
    pub(super) textures: Textures,
    /// Ids by (glTF material or default, without what needs tangents).
    ids: std::collections::BTreeMap<(Option<usize>, bool), u32>,
    /// Texture coordinates that each of the file's materials reads.
    uv_sets: Vec<UvSets>,
}

impl Materials {
    /// None yet, of a file whose materials read these texture coordinates.
    pub(super) fn reading(uv_sets: Vec<UvSets>) -> Self {
        Self { uv_sets, ..Self::default() }
    }

    /// The sets of texture coordinates of a glTF material.
    pub(super) fn uv_sets(&self, material: Option<usize>) -> UvSets {
        material.and_then(|m| self.uv_sets.get(m)).copied().unwrap_or(FIRST_TWO)
    }

    /// The id of a glTF material (`None`: the default one), converted on first use.
    pub(super) fn id(&mut self, root: &json::Root, material: Option<usize>, report: &mut Report) -> u32 {
        if let Some(id) = self.ids.get(&(material, false)) {
            return *id;
        }
        let fallback = source::Material::default();
        let found = material.and_then(|m| root.materials.get(m)).unwrap_or(&fallback);
        let place = material.map_or_else(String::new, |m| format!("/materials/{m}"));
        let uv_sets = self.uv_sets(material);
        let converted = Converter { root, textures: &mut self.textures, report, place, uv_sets }.material(found);
        self.list.push(converted);
        let id = (self.list.len() - 1) as u32;
        self.ids.insert((material, false), id);
        id
    }

    /// The texture reference for whose coordinates a material needs tangents, if it needs any: a normal map's, or that of
    /// the anisotropy (the first set without a texture).
    pub(super) fn tangent_source(&self, id: u32) -> Option<TextureRef> {
        let material = self.list.get(id as usize)?;
        let layers = material.layers().filter(|l| l.need_tangents());
        let coat = layers.and_then(|l| l.clearcoat_normal_map);
        let maps = material.normal_map.or(coat).map(|n| n.texture);
        maps.or(layers.map(|l| l.anisotropy_texture.unwrap_or(TextureRef::new(0))))
    }

    /// The same material without normal maps and anisotropy, for primitives that cannot carry them.
    pub(super) fn without_tangents(&mut self, material: Option<usize>, id: u32) -> u32 {
        *self.ids.entry((material, true)).or_insert_with(|| {
            let plain = self.list.get(id as usize).cloned().unwrap_or_default();
            let mut plain = Material { normal_map: None, ..plain };
            if let Surface::MetalRough(MetalRough { layers: Some(layers), .. }) = &mut plain.surface {
                *layers = Layers { anisotropy: 0.0, clearcoat_normal_map: None, ..*layers };
            }
            self.list.push(plain);
            (self.list.len() - 1) as u32
        })
    }
}

/// Converts one material; extensions that need more room have files of their own.
pub(super) struct Converter<'a, 'r> {
    root: &'a json::Root,
    textures: &'a mut Textures,
    pub(super) report: &'a mut Report<'r>,
    /// JSON pointer of the material.
    pub(super) place: String,
    uv_sets: UvSets,
}

impl Converter<'_, '_> {
    fn material(&mut self, m: &source::Material) -> Material {
        use ColorSpace::{Linear, Srgb};
        let none = Extensions::default();
        let extensions = m.extensions.as_ref().unwrap_or(&none);
        let glossy = Object::of(extensions, "KHR_materials_pbrSpecularGlossiness");
        let (mut surface, [.., base_alpha], base_texture) = match glossy {
            Some(object) => self.specular_glossiness(&object),
            None => {
                let pbr = &m.pbr_metallic_roughness;
                let texture =
                    self.texture(pbr.base_color_texture.as_ref(), Srgb, "pbrMetallicRoughness/baseColorTexture");
                let rough = pbr.metallic_roughness_texture.as_ref();
                let rough = self.texture(rough, Linear, "pbrMetallicRoughness/metallicRoughnessTexture");
                let factor = pbr.base_color_factor.0.map(|x| self.unit(x, "pbrMetallicRoughness/baseColorFactor"));
                let [r, g, b, _] = factor;
                let metallic = self.unit(pbr.metallic_factor.0, "pbrMetallicRoughness/metallicFactor");
                let roughness = self.unit(pbr.roughness_factor.0, "pbrMetallicRoughness/roughnessFactor");
                let surface = MetalRough {
                    base_color: ColorInput { factor: [r, g, b], texture },
                    metallic: ScalarInput { factor: metallic, texture: rough, channel: Channel::B, bias: 0.0 },
                    roughness: ScalarInput { factor: roughness, texture: rough, channel: Channel::G, bias: 0.0 },
                    ..MetalRough::default()
                };
                (surface, factor, texture)
            }
        };
        self.specular_and_transmission(extensions, &mut surface);
        let unlit = extensions.unlit.is_some();
        surface.layers = if unlit { None } else { self.layers(extensions) };
        let emission = if unlit { ColorInput::BLACK } else { self.emission(m, extensions) };
        let normal_map = m.normal_texture.as_ref().filter(|_| !unlit).and_then(|n| self.normal_map(n));
        if m.occlusion_texture.is_some() {
            let message = "occlusion textures are ignored: occlusion is computed";
            self.report.once("occlusion-ignored", format!("{}/occlusionTexture", self.place), message);
        }
        let mode = match m.alpha_mode {
            Checked::Valid(source::AlphaMode::Opaque) => AlphaMode::Opaque,
            Checked::Valid(source::AlphaMode::Blend) => AlphaMode::Blend,
            Checked::Valid(source::AlphaMode::Mask) => {
                let cutoff = m.alpha_cutoff.map_or(0.5, |c| c.0);
                AlphaMode::Mask { cutoff: if cutoff.is_finite() { cutoff } else { 0.5 } }
            }
            Checked::Invalid => {
                self.report.warn("invalid-object", format!("{}/alphaMode", self.place), "is taken as OPAQUE");
                AlphaMode::Opaque
            }
        };
        let value = match mode {
            AlphaMode::Opaque => ScalarInput::constant(1.0),
            _ => ScalarInput { factor: base_alpha, texture: base_texture, channel: Channel::A, bias: 0.0 },
        };
        Material {
            name: m.name.clone().unwrap_or_default(),
            surface: if unlit { Surface::Unlit(surface.base_color) } else { Surface::MetalRough(surface) },
            emission,
            emission_two_sided: m.double_sided,
            alpha: Alpha { mode, value },
            normal_map,
            double_sided: m.double_sided,
        }
    }

    fn emission(&mut self, m: &source::Material, extensions: &Extensions) -> ColorInput {
        let texture = self.texture(m.emissive_texture.as_ref(), ColorSpace::Srgb, "emissiveTexture");
        let strength = extensions.emissive_strength.as_ref().map_or(1.0, |s| s.emissive_strength.0);
        let factor = m.emissive_factor.0.map(|x| self.factor(x * strength, f32::MAX, "emissiveFactor"));
        ColorInput { factor, texture }
    }

    fn normal_map(&mut self, n: &source::NormalTexture) -> Option<NormalMap> {
        let transform = n.extensions.as_ref().and_then(|e| e.others.get("KHR_texture_transform"));
        let transform = transform.and_then(|t| serde_json::from_value::<TextureTransform>(t.clone()).ok());
        let (index, set) = (n.index.value(), n.tex_coord);
        let texture = self.reference(index, set, transform.as_ref(), ColorSpace::Linear, "normalTexture")?;
        let scale = if n.scale.is_finite() { n.scale } else { 1.0 };
        Some(NormalMap { texture, scale })
    }

    /// KHR_materials_specular, _ior, _transmission and _volume.
    fn specular_and_transmission(&mut self, extensions: &Extensions, surface: &mut MetalRough) {
        use ColorSpace::{Linear, Srgb};
        if let Some(s) = &extensions.specular {
            let place = "extensions/KHR_materials_specular";
            let texture = self.texture(s.specular_texture.as_ref(), Linear, &format!("{place}/specularTexture"));
            let factor = self.unit(s.specular_factor.0, &format!("{place}/specularFactor"));
            surface.specular = ScalarInput { factor, texture, channel: Channel::A, bias: 0.0 };
            let texture =
                self.texture(s.specular_color_texture.as_ref(), Srgb, &format!("{place}/specularColorTexture"));
            let at = format!("{place}/specularColorFactor");
            let factor = s.specular_color_factor.0.map(|x| self.factor(x, f32::MAX, &at));
            surface.specular_color = ColorInput { factor, texture };
        }
        if let Some(i) = &extensions.ior {
            let ior = i.ior.0;
            // 0 is the extension's word for a reflectance of 1.
            surface.ior = if ior == 0.0 || (ior >= 1.0 && ior.is_finite()) {
                ior
            } else {
                let place = format!("{}/extensions/KHR_materials_ior/ior", self.place);
                self.report.warn("factor-out-of-range", place, format!("{ior} is taken as 1"));
                1.0
            };
        }
        if let Some(t) = &extensions.transmission {
            let place = "extensions/KHR_materials_transmission";
            let texture =
                self.texture(t.transmission_texture.as_ref(), Linear, &format!("{place}/transmissionTexture"));
            let factor = self.unit(t.transmission_factor.0, &format!("{place}/transmissionFactor"));
            surface.transmission = ScalarInput { factor, texture, channel: Channel::R, bias: 0.0 };
        }
        // The thickness is for rasterizers; here it only tells a solid from a thin wall.
        if let Some(v) = extensions.volume.as_ref().filter(|v| v.thickness_factor.0 > 0.0) {
            let place = "extensions/KHR_materials_volume";
            let color = v.attenuation_color.0.map(|x| self.unit(x, &format!("{place}/attenuationColor")));
            let mut distance = v.attenuation_distance.0;
            if distance.is_nan() || distance <= 0.0 {
                let at = format!("{}/{place}/attenuationDistance", self.place);
                self.report.warn("factor-out-of-range", at, format!("{distance} is taken as infinite"));
                distance = f32::INFINITY;
            }
            surface.volume = Some(Volume { attenuation_color: color, attenuation_distance: distance });
            if let Some(e) = Object::of(extensions, "KHR_materials_dispersion") {
                surface.dispersion = self.factor(e.number("dispersion", 0.0), f32::MAX, &e.at("dispersion"));
            }
        }
    }

    pub(super) fn unit(&mut self, value: f32, name: &str) -> f32 {
        self.factor(value, 1.0, name)
    }

    pub(super) fn factor(&mut self, value: f32, max: f32, name: &str) -> f32 {
        if (0.0..=max).contains(&value) {
            return value;
        }
        let sound = if value.is_nan() { 0.0 } else { value.clamp(0.0, max) };
        let message = format!("{value} is taken as {sound}");
        self.report.warn("factor-out-of-range", format!("{}/{name}", self.place), message);
        sound
    }

    pub(super) fn texture(&mut self, info: Option<&Info>, space: ColorSpace, name: &str) -> Option<TextureRef> {
        let info = info?;
        let transform = info.extensions.as_ref().and_then(|e| e.texture_transform.as_ref());
        self.reference(info.index.value(), info.tex_coord, transform, space, name)
    }

    fn reference(
        &mut self,
        texture: usize,
        set: u32,
        transform: Option<&TextureTransform>,
        space: ColorSpace,
        name: &str,
    ) -> Option<TextureRef> {
        let place = || format!("{}/{name}", self.place);
        if texture >= self.root.textures.len() {
            self.report.warn("missing-texture", place(), format!("there is no texture {texture}"));
            return None;
        }
        let set = transform.and_then(|t| t.tex_coord).unwrap_or(set);
        let Some(uv_set) = self.uv_sets.iter().position(|s| *s == set) else {
            let [one, two] = self.uv_sets;
            let message =
                format!("TEXCOORD_{set} is not read beside TEXCOORD_{one} and TEXCOORD_{two}: the texture is left out");
            self.report.warn("texcoord-ignored", place(), message);
            return None;
        };
        let uv_set = uv_set as u8;
        let transform = transform.map_or(UvTransform::IDENTITY, uv_transform);
        let finite = transform.linear.as_flattened().iter().chain(&transform.offset).all(|x| x.is_finite());
        let transform = if finite { transform } else { UvTransform::IDENTITY };
        Some(TextureRef { texture: self.textures.id(texture, space), uv_set, transform })
    }
}

/// KHR_texture_transform: translation · rotation · scale.
///
/// The extension's text rotates "counter-clockwise" with v downwards; its GLSL sample turns the other way, and the
/// Khronos sample viewer, three.js and the test model TextureTransformTest go by the text.
fn uv_transform(t: &TextureTransform) -> UvTransform {
    let [x, y] = t.scale.0;
    let (sin, cos) = (libm::sinf(t.rotation.0), libm::cosf(t.rotation.0));
    UvTransform { linear: [[cos * x, sin * y], [-sin * x, cos * y]], offset: t.offset.0 }
}
