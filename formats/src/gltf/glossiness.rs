//! KHR_materials_pbrSpecularGlossiness, the archived way of describing materials.

use super::layers::Object;
use super::materials::Converter;
use crate::scene::{Channel, ColorInput, ColorSpace, MetalRough, ScalarInput, TextureRef};

impl Converter<'_, '_> {
    /// A dielectric whose F0 is the specular colour: `0.04 · specular_color` at the index of refraction 1.5; its
    /// roughness is 1 − glossiness, texture included. What it reflects is taken from the diffuse part, as the extension
    /// wants by `diffuse · (1 − max(specular))`. Also gives the diffuse factor with alpha, and the diffuse texture.
    pub(super) fn specular_glossiness(&mut self, e: &Object) -> (MetalRough, [f32; 4], Option<TextureRef>) {
        let diffuse = self.texture(e.info("diffuseTexture").as_ref(), ColorSpace::Srgb, &e.at("diffuseTexture"));
        let key = "specularGlossinessTexture";
        let specular = self.texture(e.info(key).as_ref(), ColorSpace::Srgb, &e.at(key));
        let factor = e.numbers::<4>("diffuseFactor", 1.0).map(|x| self.unit(x, &e.at("diffuseFactor")));
        let color = e.numbers::<3>("specularFactor", 1.0).map(|x| self.unit(x, &e.at("specularFactor")) / 0.04);
        let glossiness = self.unit(e.number("glossinessFactor", 1.0), &e.at("glossinessFactor"));
        let [r, g, b, _] = factor;
        let surface = MetalRough {
            base_color: ColorInput { factor: [r, g, b], texture: diffuse },
            roughness: ScalarInput { factor: -glossiness, texture: specular, channel: Channel::A, bias: 1.0 },
            specular_color: ColorInput { factor: color, texture: specular },
            ..MetalRough::default()
        };
        (surface, factor, diffuse)
    }
}
