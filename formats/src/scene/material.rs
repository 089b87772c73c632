use super::TextureRef;

/// A channel of a texture.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[allow(missing_docs)]
pub enum Channel {
    #[default]
    R = 0,
    G = 1,
    B = 2,
    A = 3,
}

/// A colour: a factor, times the RGB of a texture where there is one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ColorInput {
    /// Linear RGB, finite and ≥ 0.
    pub factor: [f32; 3],
    /// Multiplies the factor.
    pub texture: Option<TextureRef>,
}

/// A number: a factor, times one channel of a texture where there is one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ScalarInput {
    /// Finite and ≥ 0.
    pub factor: f32,
    /// Multiplies the factor.
    pub texture: Option<TextureRef>,
    /// The channel of the texture that is read.
    pub channel: Channel,
}

impl ColorInput {
    /// Black.
    pub const BLACK: Self = Self::constant([0.0; 3]);
    /// White.
    pub const WHITE: Self = Self::constant([1.0; 3]);

    /// A colour without a texture.
    pub const fn constant(factor: [f32; 3]) -> Self {
        Self { factor, texture: None }
    }

    /// Whether it is zero whatever the texture says.
    pub fn is_black(&self) -> bool {
        self.factor == [0.0; 3]
    }
}

impl ScalarInput {
    /// A number without a texture.
    pub const fn constant(factor: f32) -> Self {
        Self { factor, texture: None, channel: Channel::R }
    }
}

/// The inside of a closed body (KHR_materials_volume): Beer–Lambert absorption.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Volume {
    /// Colour of white light after `attenuation_distance`, each in (0, 1].
    pub attenuation_color: [f32; 3],
    /// World units; infinite for a clear body.
    pub attenuation_distance: f32,
}

/// glTF's pbrMetallicRoughness with the extensions specular, ior, transmission and volume.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MetalRough {
    /// Albedo of the dielectric part and F0 of the metallic part; vertex colours multiply it.
    pub base_color: ColorInput,
    /// 0 dielectric … 1 metal.
    pub metallic: ScalarInput,
    /// Perceptual roughness; GGX α is its square.
    pub roughness: ScalarInput,
    /// KHR_materials_specular: strength of the dielectric reflection (F0 and F90). 0 leaves pure Lambert.
    pub specular: ScalarInput,
    /// KHR_materials_specular: tints F0 of the dielectric.
    pub specular_color: ColorInput,
    /// Index of refraction of the dielectric, ≥ 1 (or 0, glTF's word for "F0 = 1").
    pub ior: f32,
    /// Share of the dielectric's diffuse part that is transmitted instead.
    pub transmission: ScalarInput,
    /// `Some`: the surface bounds a solid, transmission refracts and is absorbed. `None`: a thin wall.
    pub volume: Option<Volume>,
}

impl Default for MetalRough {
    fn default() -> Self {
        Self {
            base_color: ColorInput::WHITE,
            metallic: ScalarInput::constant(0.0),
            roughness: ScalarInput::constant(1.0),
            specular: ScalarInput::constant(1.0),
            specular_color: ColorInput::WHITE,
            ior: 1.5,
            transmission: ScalarInput::constant(0.0),
            volume: None,
        }
    }
}

/// The material of `.ray` files, in their own terms; the renderer maps it to physically based lobes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Phong {
    /// k_a, times the scene's ambient light; only look-alike integrators use it.
    pub ambient: ColorInput,
    /// k_d, albedo of the Lambert lobe; vertex colours multiply it.
    pub diffuse: ColorInput,
    /// k_s, of the highlight `k_s · cosⁿ`.
    pub specular: ColorInput,
    /// n, the Phong exponent.
    pub exponent: ScalarInput,
    /// k_r, weight of a perfect mirror.
    pub mirror: ColorInput,
    /// k_t, transmittance per world unit inside the body; not black makes it a refracting body.
    pub transmission: ColorInput,
    /// Index of refraction inside.
    pub ior: ScalarInput,
}

impl Default for Phong {
    fn default() -> Self {
        Self {
            ambient: ColorInput::BLACK,
            diffuse: ColorInput::BLACK,
            specular: ColorInput::BLACK,
            exponent: ScalarInput::constant(0.0),
            mirror: ColorInput::BLACK,
            transmission: ColorInput::BLACK,
            ior: ScalarInput::constant(1.0),
        }
    }
}

/// How a surface scatters light.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Surface {
    /// glTF's model; OBJ is mapped to it.
    MetalRough(MetalRough),
    /// The `.ray` model.
    Phong(Phong),
    /// KHR_materials_unlit: shows its colour (times vertex colours) and scatters nothing.
    Unlit(ColorInput),
}

/// How alpha is taken.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum AlphaMode {
    /// Ignored: the surface is whole.
    #[default]
    Opaque,
    /// The surface is there where alpha ≥ cutoff.
    Mask {
        /// The threshold.
        cutoff: f32,
    },
    /// The surface covers this share of what is behind it.
    Blend,
}

/// Coverage of a surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Alpha {
    /// How the value is taken.
    pub mode: AlphaMode,
    /// Alpha; the alpha of vertex colours multiplies it.
    pub value: ScalarInput,
}

/// A tangent-space normal map.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NormalMap {
    /// RGB = (x, y, z)·0.5 + 0.5, y upwards (against v), as in glTF.
    pub texture: TextureRef,
    /// Multiplies x and y.
    pub scale: f32,
}

/// Everything about a surface but its shape.
#[derive(Clone, Debug, PartialEq)]
pub struct Material {
    /// Name in the file, or empty.
    pub name: String,
    /// How it scatters.
    pub surface: Surface,
    /// Emitted radiance, W/(m² sr). The renderer makes area lights of what is not black.
    pub emission: ColorInput,
    /// Whether the back emits too (`.ray`, and glTF's double-sided materials).
    pub emission_two_sided: bool,
    /// Coverage.
    pub alpha: Alpha,
    /// Bends the shading normal.
    pub normal_map: Option<NormalMap>,
    /// `false`: camera rays pass through the back (glTF's culling); the back still casts shadows.
    pub double_sided: bool,
}

impl Default for Material {
    /// An opaque, double-sided, white and rough dielectric.
    fn default() -> Self {
        Self {
            name: String::new(),
            surface: Surface::MetalRough(MetalRough::default()),
            emission: ColorInput::BLACK,
            emission_two_sided: false,
            alpha: Alpha { mode: AlphaMode::Opaque, value: ScalarInput::constant(1.0) },
            normal_map: None,
            double_sided: true,
        }
    }
}

impl Material {
    /// Every texture that the material reads.
    pub fn textures(&self) -> Vec<TextureRef> {
        let mut all = vec![self.emission.texture, self.alpha.value.texture, self.normal_map.map(|n| n.texture)];
        match &self.surface {
            Surface::MetalRough(m) => all.extend([
                m.base_color.texture,
                m.metallic.texture,
                m.roughness.texture,
                m.specular.texture,
                m.specular_color.texture,
                m.transmission.texture,
            ]),
            Surface::Phong(p) => all.extend([
                p.ambient.texture,
                p.diffuse.texture,
                p.specular.texture,
                p.exponent.texture,
                p.mirror.texture,
                p.transmission.texture,
                p.ior.texture,
            ]),
            Surface::Unlit(c) => all.push(c.texture),
        }
        all.into_iter().flatten().collect()
    }
}
