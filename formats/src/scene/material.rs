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

/// A number: a bias plus a factor, the factor times one channel of a texture where there is one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ScalarInput {
    /// Finite; ≥ 0 unless there is a bias.
    pub factor: f32,
    /// Multiplies the factor.
    pub texture: Option<TextureRef>,
    /// The channel of the texture that is read.
    pub channel: Channel,
    /// Added; finite and ≥ 0. The sum with the factor is ≥ 0 too.
    pub bias: f32,
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
        Self { factor, texture: None, channel: Channel::R, bias: 0.0 }
    }

    /// The least that it can be anywhere, whatever its texture says.
    pub fn least(&self) -> f32 {
        self.bias + if self.texture.is_some() { self.factor.min(0.0) } else { self.factor }
    }

    /// The most that it can be anywhere.
    pub fn most(&self) -> f32 {
        self.bias + if self.texture.is_some() { self.factor.max(0.0) } else { self.factor }
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

/// Layers on and in a metallic-roughness surface, each one of glTF's extensions. The default has none of them.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Layers {
    /// KHR_materials_clearcoat: strength of the coat.
    pub clearcoat: ScalarInput,
    /// Perceptual roughness of the coat.
    pub clearcoat_roughness: ScalarInput,
    /// The coat's own normals; the base's normal map does not bend the coat.
    pub clearcoat_normal_map: Option<NormalMap>,
    /// KHR_materials_sheen: colour of the fibres.
    pub sheen_color: ColorInput,
    /// Perceptual roughness of the fibres.
    pub sheen_roughness: ScalarInput,
    /// KHR_materials_iridescence: strength of the thin film.
    pub iridescence: ScalarInput,
    /// Index of refraction of the film, ≥ 1.
    pub iridescence_ior: f32,
    /// Thickness of the film, nanometres.
    pub iridescence_thickness: ScalarInput,
    /// KHR_materials_anisotropy: strength, in [0, 1].
    pub anisotropy: f32,
    /// Counter-clockwise angle from the tangent to the rough direction, radians.
    pub anisotropy_rotation: f32,
    /// RG: the rough direction in the tangent plane · 0.5 + 0.5, turned by the rotation; B multiplies the strength.
    pub anisotropy_texture: Option<TextureRef>,
    /// KHR_materials_diffuse_transmission: share of the diffuse part that goes to the other side.
    pub diffuse_transmission: ScalarInput,
    /// Its colour.
    pub diffuse_transmission_color: ColorInput,
    /// KHR_materials_diffuse_roughness: roughness of the diffuse part; 0 is Lambert.
    pub diffuse_roughness: ScalarInput,
}

impl Default for Layers {
    fn default() -> Self {
        Self {
            clearcoat: ScalarInput::constant(0.0),
            clearcoat_roughness: ScalarInput::constant(0.0),
            clearcoat_normal_map: None,
            sheen_color: ColorInput::BLACK,
            sheen_roughness: ScalarInput::constant(0.0),
            iridescence: ScalarInput::constant(0.0),
            iridescence_ior: 1.3,
            iridescence_thickness: ScalarInput::constant(400.0),
            anisotropy: 0.0,
            anisotropy_rotation: 0.0,
            anisotropy_texture: None,
            diffuse_transmission: ScalarInput::constant(0.0),
            diffuse_transmission_color: ColorInput::WHITE,
            diffuse_roughness: ScalarInput::constant(0.0),
        }
    }
}

impl Layers {
    /// Every number.
    pub fn scalars(&self) -> [&ScalarInput; 7] {
        [
            &self.clearcoat,
            &self.clearcoat_roughness,
            &self.sheen_roughness,
            &self.iridescence,
            &self.iridescence_thickness,
            &self.diffuse_transmission,
            &self.diffuse_roughness,
        ]
    }

    /// Every texture.
    pub fn textures(&self) -> impl Iterator<Item = TextureRef> + use<> {
        let scalars = self.scalars().map(|s| s.texture);
        let others = [
            self.clearcoat_normal_map.map(|n| n.texture),
            self.sheen_color.texture,
            self.anisotropy_texture,
            self.diffuse_transmission_color.texture,
        ];
        scalars.into_iter().chain(others).flatten()
    }

    /// Every place of a texture, to change it.
    pub fn texture_slots(&mut self) -> [&mut Option<TextureRef>; 10] {
        [
            &mut self.clearcoat.texture,
            &mut self.clearcoat_roughness.texture,
            &mut self.sheen_roughness.texture,
            &mut self.iridescence.texture,
            &mut self.iridescence_thickness.texture,
            &mut self.diffuse_transmission.texture,
            &mut self.diffuse_roughness.texture,
            &mut self.sheen_color.texture,
            &mut self.anisotropy_texture,
            &mut self.diffuse_transmission_color.texture,
        ]
    }

    /// Whether a mesh needs tangents for them.
    pub fn need_tangents(&self) -> bool {
        self.clearcoat_normal_map.is_some() || self.anisotropy > 0.0
    }
}

/// glTF's pbrMetallicRoughness with its extensions; OBJ is mapped to it.
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
    /// KHR_materials_dispersion: 20 over the Abbe number, ≥ 0, of bodies (with a `volume`); `ior` is then that of the
    /// helium d line. 0: all wavelengths are refracted alike.
    pub dispersion: f32,
    /// Share of the dielectric's diffuse part that is transmitted instead.
    pub transmission: ScalarInput,
    /// `Some`: the surface bounds a solid, transmission refracts and is absorbed. `None`: a thin wall.
    pub volume: Option<Volume>,
    /// What lies on and in the surface besides; `None` is what nearly all have.
    pub layers: Option<Layers>,
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
            dispersion: 0.0,
            transmission: ScalarInput::constant(0.0),
            volume: None,
            layers: None,
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
    /// Whether `transmission` is what each surface of the body lets through, and not what each unit of length does.
    pub transmission_at_surfaces: bool,
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
            transmission_at_surfaces: false,
        }
    }
}

/// How a surface scatters light.
#[derive(Clone, Copy, Debug, PartialEq)]
#[expect(clippy::large_enum_variant, reason = "a scene has few materials, and they are read in place")]
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
    /// What else than shape and normals lies on and in the surface.
    pub fn layers(&self) -> Option<&Layers> {
        match &self.surface {
            Surface::MetalRough(m) => m.layers.as_ref(),
            Surface::Phong(_) | Surface::Unlit(_) => None,
        }
    }

    /// Every texture that the material reads.
    pub fn textures(&self) -> Vec<TextureRef> {
        let mut all = vec![self.emission.texture, self.alpha.value.texture, self.normal_map.map(|n| n.texture)];
        match &self.surface {
            Surface::MetalRough(m) => {
                all.extend([
                    m.base_color.texture,
                    m.metallic.texture,
                    m.roughness.texture,
                    m.specular.texture,
                    m.specular_color.texture,
                    m.transmission.texture,
                ]);
                all.extend(m.layers.iter().flat_map(Layers::textures).map(Some));
            }
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
