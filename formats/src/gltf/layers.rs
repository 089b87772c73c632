//! The extensions that put layers on and into a surface: clear coat, sheen, thin film, anisotropy, diffuse transmission
//! and diffuse roughness.

use super::materials::Converter;
use crate::scene::{Channel, ColorInput, ColorSpace, Layers, NormalMap, ScalarInput};
use gltf::json::extensions::material::Material as Extensions;
use gltf::json::texture::Info;
use serde_json::Value;

/// An extension's object and the path to it below the material.
pub(super) struct Object<'a> {
    value: &'a Value,
    pub(super) place: String,
}

impl<'a> Object<'a> {
    pub(super) fn of(extensions: &'a Extensions, name: &str) -> Option<Self> {
        let value = extensions.others.get(name)?;
        Some(Self { value, place: format!("extensions/{name}") })
    }

    pub(super) fn at(&self, key: &str) -> String {
        format!("{}/{key}", self.place)
    }

    pub(super) fn number(&self, key: &str, default: f32) -> f32 {
        self.value.get(key).and_then(Value::as_f64).map_or(default, |x| x as f32)
    }

    pub(super) fn numbers<const N: usize>(&self, key: &str, default: f32) -> [f32; N] {
        let items = self.value.get(key).and_then(Value::as_array);
        std::array::from_fn(|k| items.and_then(|i| i.get(k)?.as_f64()).map_or(default, |x| x as f32))
    }

    pub(super) fn info(&self, key: &str) -> Option<Info> {
        self.value.get(key).and_then(|t| serde_json::from_value(t.clone()).ok())
    }
}

/// Whether a material may need tangents, by what its file says.
pub(super) fn may_need_tangents(material: &gltf::json::Material) -> bool {
    let names = ["KHR_materials_clearcoat", "KHR_materials_anisotropy"];
    let extended = |e: &Extensions| names.iter().any(|name| e.others.contains_key(*name));
    material.normal_texture.is_some() || material.extensions.as_ref().is_some_and(extended)
}

impl Converter<'_, '_> {
    /// The layers of a material; `None` where no extension is in effect.
    pub(super) fn layers(&mut self, extensions: &Extensions) -> Option<Layers> {
        let mut layers = Layers::default();
        if let Some(e) = Object::of(extensions, "KHR_materials_clearcoat") {
            layers.clearcoat = self.share(&e, "clearcoatFactor", "clearcoatTexture", Channel::R);
            let (factor, texture) = ("clearcoatRoughnessFactor", "clearcoatRoughnessTexture");
            layers.clearcoat_roughness = self.share(&e, factor, texture, Channel::G);
            layers.clearcoat_normal_map = self.coat_normal_map(&e);
        }
        if let Some(e) = Object::of(extensions, "KHR_materials_sheen") {
            layers.sheen_color = self.color(&e, "sheenColorFactor", "sheenColorTexture", 0.0);
            layers.sheen_roughness = self.share(&e, "sheenRoughnessFactor", "sheenRoughnessTexture", Channel::A);
        }
        if let Some(e) = Object::of(extensions, "KHR_materials_iridescence") {
            layers.iridescence = self.share(&e, "iridescenceFactor", "iridescenceTexture", Channel::R);
            layers.iridescence_ior = self.at_least_one(&e, "iridescenceIor", 1.3);
            let mut bound = |key: &str, default| self.factor(e.number(key, default), f32::MAX, &e.at(key));
            let (least, most) =
                (bound("iridescenceThicknessMinimum", 100.0), bound("iridescenceThicknessMaximum", 400.0));
            let key = "iridescenceThicknessTexture";
            let texture = self.texture(e.info(key).as_ref(), ColorSpace::Linear, &e.at(key));
            let bias = if texture.is_some() { least } else { 0.0 };
            layers.iridescence_thickness = ScalarInput { factor: most - bias, texture, channel: Channel::G, bias };
        }
        if let Some(e) = Object::of(extensions, "KHR_materials_anisotropy") {
            layers.anisotropy = self.unit(e.number("anisotropyStrength", 0.0), &e.at("anisotropyStrength"));
            let rotation = e.number("anisotropyRotation", 0.0);
            layers.anisotropy_rotation = if rotation.is_finite() { rotation } else { 0.0 };
            let key = "anisotropyTexture";
            layers.anisotropy_texture = self.texture(e.info(key).as_ref(), ColorSpace::Linear, &e.at(key));
        }
        if let Some(e) = Object::of(extensions, "KHR_materials_diffuse_transmission") {
            let (factor, texture) = ("diffuseTransmissionFactor", "diffuseTransmissionTexture");
            layers.diffuse_transmission = self.share(&e, factor, texture, Channel::A);
            let (factor, texture) = ("diffuseTransmissionColorFactor", "diffuseTransmissionColorTexture");
            layers.diffuse_transmission_color = self.color(&e, factor, texture, 1.0);
        }
        // The draft named EXT is rough unless it says otherwise.
        for (name, default) in [("EXT_materials_diffuse_roughness", 1.0), ("KHR_materials_diffuse_roughness", 0.0)] {
            if let Some(e) = Object::of(extensions, name) {
                let (factor, texture) = ("diffuseRoughnessFactor", "diffuseRoughnessTexture");
                let value = self.unit(e.number(factor, default), &e.at(factor));
                let texture = self.texture(e.info(texture).as_ref(), ColorSpace::Linear, &e.at(texture));
                layers.diffuse_roughness = ScalarInput { factor: value, texture, channel: Channel::R, bias: 0.0 };
            }
        }
        let strengths =
            [&layers.clearcoat, &layers.iridescence, &layers.diffuse_transmission, &layers.diffuse_roughness];
        let in_effect =
            strengths.iter().any(|s| s.factor > 0.0) || layers.anisotropy > 0.0 || !layers.sheen_color.is_black();
        in_effect.then_some(layers)
    }

    /// A number in [0, 1] that is 0 where it is missing, with its texture.
    fn share(&mut self, e: &Object, factor: &str, texture: &str, channel: Channel) -> ScalarInput {
        let value = self.unit(e.number(factor, 0.0), &e.at(factor));
        let texture = self.texture(e.info(texture).as_ref(), ColorSpace::Linear, &e.at(texture));
        ScalarInput { factor: value, texture, channel, bias: 0.0 }
    }

    fn color(&mut self, e: &Object, factor: &str, texture: &str, default: f32) -> ColorInput {
        let value = e.numbers::<3>(factor, default).map(|x| self.unit(x, &e.at(factor)));
        ColorInput { factor: value, texture: self.texture(e.info(texture).as_ref(), ColorSpace::Srgb, &e.at(texture)) }
    }

    fn at_least_one(&mut self, e: &Object, key: &str, default: f32) -> f32 {
        let value = e.number(key, default);
        if value >= 1.0 && value.is_finite() {
            return value;
        }
        let place = format!("{}/{}", self.place, e.at(key));
        self.report.warn("factor-out-of-range", place, format!("{value} is taken as 1"));
        1.0
    }

    fn coat_normal_map(&mut self, e: &Object) -> Option<NormalMap> {
        let key = "clearcoatNormalTexture";
        let texture = self.texture(e.info(key).as_ref(), ColorSpace::Linear, &e.at(key))?;
        let scale = e.value.get(key).and_then(|t| t.get("scale")?.as_f64()).map_or(1.0, |x| x as f32);
        Some(NormalMap { texture, scale: if scale.is_finite() { scale } else { 1.0 } })
    }
}
