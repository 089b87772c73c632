use super::textures::Use;
use super::{Lower, Result};
use crate::ErrorCode;
use crate::ray::options::Dialect;
use crate::ray::source::{At, Offset};
use crate::ray::tree::{FieldName, FieldValue, MaterialExpr, MaterialField, Object, ObjectMap};
use crate::scene::{ColorInput, Material, MaterialId, NormalMap, Phong, ScalarInput, Surface, TextureId, TextureRef};
use std::collections::HashMap;

/// The exponent that a white texel of a `shininess` map stands for.
const MAPPED_SHININESS: f32 = 128.0;
/// Reflected share above which it is worth saying that the renderer scales a material.
const ENERGY_TOLERANCE: f32 = 1.05;

/// Everything that a `.ray` material says; what materials inherit.
#[derive(Clone, Copy, Default)]
pub(super) struct Appearance {
    pub phong: Phong,
    pub emission: Emission,
    /// A map of normals that bends them.
    pub bumps: Option<TextureId>,
    /// Whether it is of a dialect whose spheres have texture coordinates.
    pub wraps_spheres: bool,
    /// Whether `reflective` was said: in some dialects `specular` stands for it else.
    has_mirror: bool,
    /// Index of the name that the file gives to exactly this material.
    name: Option<u32>,
}

/// Emitted radiance. A type of its own for the black default.
#[derive(Clone, Copy)]
pub(super) struct Emission(pub ColorInput);

impl Default for Emission {
    fn default() -> Self {
        Self(ColorInput::BLACK)
    }
}

/// The bits of an appearance: those of equal bits become one material.
type Bits = [u32; 31];

impl Appearance {
    fn colors(&self) -> [&ColorInput; 6] {
        let p = &self.phong;
        [&p.ambient, &p.diffuse, &p.specular, &p.mirror, &p.transmission, &self.emission.0]
    }

    pub fn without_bumps(self) -> Self {
        Self { bumps: None, ..self }
    }

    /// Whether any texture is read.
    pub fn is_textured(&self) -> bool {
        let scalars = [&self.phong.exponent, &self.phong.ior];
        self.bumps.is_some()
            || self.colors().iter().any(|c| c.texture.is_some())
            || scalars.iter().any(|s| s.texture.is_some())
    }

    fn bits(&self) -> Bits {
        let id = |texture: Option<TextureRef>| texture.map_or(u32::MAX, |t| t.texture);
        let colors = self.colors().map(|c| {
            let [r, g, b] = c.factor.map(f32::to_bits);
            [r, g, b, id(c.texture)]
        });
        let scalars = [&self.phong.exponent, &self.phong.ior].map(|s| [s.factor.to_bits(), id(s.texture)]);
        let mut bits = [self.name.unwrap_or(u32::MAX); 31];
        (bits[29], bits[30]) = (self.bumps.unwrap_or(u32::MAX), u32::from(self.wraps_spheres));
        bits.iter_mut().zip(colors.as_flattened().iter().chain(scalars.as_flattened())).for_each(|(b, x)| *b = *x);
        bits
    }
}

/// Named appearances, and the materials made so far.
#[derive(Default)]
pub(super) struct Materials {
    named: HashMap<String, Appearance>,
    names: Vec<String>,
    ids: HashMap<Bits, MaterialId>,
    /// The place of the first positive `shininess`, while all of them are at most 1.
    small_shininess: Option<Offset>,
    large_shininess: bool,
    /// The first object that only ambient light can show.
    ambient_alone: Option<Offset>,
}

impl Lower<'_, '_> {
    /// Evaluates a material expression: a block is a copy of `inherited` with changes.
    pub(super) fn appearance(&mut self, expression: &MaterialExpr, inherited: Appearance) -> Result<Appearance> {
        match expression {
            MaterialExpr::Named(At { at, value: name }) => match self.materials.named.get(name) {
                Some(appearance) => Ok(*appearance),
                None => Err(self.invalid(*at, format!("there is no material `{name}` before this line"))),
            },
            MaterialExpr::Block(At { value: block, .. }) => {
                let inherited = match self.options.dialect {
                    Dialect::Hk => Appearance::default(),
                    Dialect::Ut | Dialect::Uw => inherited,
                };
                let mut appearance = Appearance { name: None, ..inherited };
                appearance.phong.transmission_at_surfaces = self.options.dialect == Dialect::Hk;
                for field in &block.fields {
                    self.set(&mut appearance, field)?;
                }
                if self.options.dialect != Dialect::Ut && !appearance.has_mirror {
                    appearance.phong.mirror = appearance.phong.specular;
                }
                if let Some(At { at, value: name }) = &block.name {
                    appearance.name = Some(self.materials.names.len() as u32);
                    self.materials.names.push(name.clone());
                    // An empty name is how some exporters say "none".
                    if self.materials.named.insert(name.clone(), appearance).is_some() && !name.is_empty() {
                        return Err(self.invalid(*at, format!("the material `{name}` is defined twice")));
                    }
                }
                Ok(appearance)
            }
        }
    }

    fn set(&mut self, appearance: &mut Appearance, field: &MaterialField) -> Result<()> {
        let Appearance { phong, emission, .. } = appearance;
        let at = field.at;
        match field.name {
            FieldName::Emissive => emission.0 = self.color(field)?,
            FieldName::Ambient => phong.ambient = self.color(field)?,
            FieldName::Diffuse => phong.diffuse = self.color(field)?,
            FieldName::Specular => phong.specular = self.color(field)?,
            FieldName::Reflective => {
                phong.mirror = self.color(field)?;
                appearance.has_mirror = true;
            }
            FieldName::Transmissive => phong.transmission = self.color(field)?,
            FieldName::Shininess => {
                phong.exponent = self.scalar(field, MAPPED_SHININESS)?;
                if self.options.dialect == Dialect::Hk && phong.exponent.texture.is_none() {
                    phong.exponent.factor *= MAPPED_SHININESS;
                }
                let n = phong.exponent.factor;
                self.materials.large_shininess |= n > 1.0;
                if n > 0.0 {
                    self.materials.small_shininess.get_or_insert(at);
                }
            }
            FieldName::Index => {
                phong.ior = self.scalar(field, 1.0)?;
                if phong.ior.factor == 0.0 {
                    self.notes.warn("invalid-ior", at, || "an index of refraction of 0 is taken as 1".into());
                    phong.ior = ScalarInput::constant(1.0);
                }
            }
            FieldName::BumpMapping => {
                if let FieldValue::Map(file) = &field.value {
                    appearance.bumps = Some(self.texture(file, Use::Heights, at)?);
                    appearance.wraps_spheres = true;
                } else {
                    self.notes.warn("ignored-field", at, || "`bump_mapping` names no image and is ignored".into());
                }
            }
        }
        Ok(())
    }

    /// What an object says of its own look, over its material.
    pub(super) fn with_own(&mut self, appearance: &mut Appearance, object: &Object) -> Result<()> {
        for (map, At { at, value: file }) in &object.maps {
            let mapped = |id| ColorInput { factor: [1.0; 3], texture: Some(TextureRef::new(id)) };
            match map {
                ObjectMap::Diffuse => appearance.phong.diffuse = mapped(self.texture(file, Use::Color, *at)?),
                ObjectMap::Specular => appearance.phong.specular = mapped(self.texture(file, Use::Color, *at)?),
                ObjectMap::Normal => appearance.bumps = Some(self.texture(file, Use::Color, *at)?),
                ObjectMap::Bump => appearance.bumps = Some(self.texture(file, Use::Heights, *at)?),
            }
            // Whoever registers the name means the material without it.
            (appearance.name, appearance.wraps_spheres) = (None, true);
        }
        if let Some(At { at, value }) = object.emission {
            let radiance = value.map(|c| self.not_negative(c, "an emission", at));
            (appearance.emission.0, appearance.name) = (ColorInput::constant(radiance), None);
        }
        Ok(())
    }

    fn color(&mut self, field: &MaterialField) -> Result<ColorInput> {
        match &field.value {
            FieldValue::Color(factor) => {
                let factor = factor.map(|c| self.not_negative(c, "a colour", field.at));
                Ok(ColorInput::constant(factor))
            }
            FieldValue::Number(grey) => {
                let grey = self.not_negative(*grey, "a colour", field.at);
                Ok(ColorInput::constant([grey; 3]))
            }
            FieldValue::Map(file) => {
                let texture = Some(TextureRef::new(self.texture(file, Use::Color, field.at)?));
                Ok(ColorInput { factor: [1.0; 3], texture })
            }
        }
    }

    /// `scale` multiplies the grey of a map, not a number.
    fn scalar(&mut self, field: &MaterialField, scale: f32) -> Result<ScalarInput> {
        match &field.value {
            FieldValue::Number(number) => {
                Ok(ScalarInput::constant(self.not_negative(*number, "a material's number", field.at)))
            }
            FieldValue::Map(file) => {
                let texture = Some(TextureRef::new(self.texture(file, Use::Grey, field.at)?));
                Ok(ScalarInput { factor: scale, texture, ..ScalarInput::constant(scale) })
            }
            FieldValue::Color(_) => Err(self.source.error(ErrorCode::Syntax, field.at, "a number was expected")),
        }
    }

    /// The material of an appearance, made when there is none yet. `at` places the warnings.
    pub(super) fn material(&mut self, appearance: &Appearance, at: Offset) -> MaterialId {
        let bits = appearance.bits();
        if let Some(id) = self.materials.ids.get(&bits) {
            return *id;
        }
        let reflected = self.reflected(&appearance.phong);
        if reflected > ENERGY_TOLERANCE {
            self.notes.warn("energy-scaled", at, || {
                format!(
                    "the material reflects {reflected:.2} times the light that it gets (diffuse, highlight and mirror \
                     together) and is scaled down"
                )
            });
        }
        let phong = &appearance.phong;
        let others = [&phong.diffuse, &phong.specular, &phong.mirror, &phong.transmission, &appearance.emission.0];
        if !phong.ambient.is_black() && others.iter().all(|c| c.is_black()) {
            self.materials.ambient_alone.get_or_insert(at);
        }
        let id = self.scene.materials.len() as MaterialId;
        let name = appearance.name.and_then(|i| self.materials.names.get(i as usize));
        self.scene.materials.push(Material {
            name: name.cloned().unwrap_or_default(),
            surface: Surface::Phong(appearance.phong),
            emission: appearance.emission.0,
            emission_two_sided: true,
            normal_map: appearance.bumps.map(|id| NormalMap { texture: TextureRef::new(id), scale: 1.0 }),
            double_sided: true,
            ..Material::default()
        });
        self.materials.ids.insert(bits, id);
        id
    }

    /// The largest share of light of any channel that a material reflects: k_d + A_s + k_r, where the highlight's
    /// albedo is A_s = min(1, 2 k_s / (n + 1)), the energy of the lobe k_s · cosⁿ in the course's units of light.
    fn reflected(&self, phong: &Phong) -> f32 {
        let brightest = |input: &ColorInput| {
            let texels = input.texture.map_or([1.0; 3], |t| self.textures.brightest(t.texture));
            [0, 1, 2].map(|i| input.factor[i] * texels[i])
        };
        let (diffuse, specular, mirror) =
            (brightest(&phong.diffuse), brightest(&phong.specular), brightest(&phong.mirror));
        let highlight = |k_s: f32| (2.0 * k_s / (phong.exponent.factor + 1.0)).min(1.0);
        let channels = [0, 1, 2].map(|i| diffuse[i] + highlight(specular[i]) + mirror[i]);
        channels.into_iter().fold(0.0, f32::max)
    }

    /// Makes what the ambient light shows a part of the emission.
    pub(super) fn emit_ambient(&mut self) {
        let light = self.scene.ambient;
        for material in &mut self.scene.materials {
            let Surface::Phong(phong) = &material.surface else { continue };
            let shown = [0, 1, 2].map(|i| phong.ambient.factor[i] * light[i]);
            let emission = &mut material.emission;
            // Two inputs with textures have no sum here; emission is kept.
            if emission.is_black() || (emission.texture.is_none() && phong.ambient.texture.is_none()) {
                let factor = [0, 1, 2].map(|i| emission.factor[i] + shown[i]);
                *emission = ColorInput { factor, texture: phong.ambient.texture };
            }
        }
    }

    /// Says so when something is black because paths know no ambient light.
    pub(super) fn warn_about_ambient_alone(&mut self) {
        if let Some(at) = self.materials.ambient_alone.filter(|_| self.scene.ambient != [0.0; 3]) {
            self.notes.warn("ambient-ignored", at, || {
                "only ambient light shows this object, which light paths do not know: it is black (--ray-ambient makes it \
                 emission, --integrator whitted knows it)"
                    .into()
            });
        }
    }

    /// Says so when every exponent suggests that the file is of the dialect with exponents of 0 to 1.
    pub(super) fn warn_about_shininess(&mut self) {
        if let Some(at) = self.materials.small_shininess.filter(|_| !self.materials.large_shininess) {
            self.notes.warn("shininess-dialect", at, || {
                "every `shininess` is at most 1, which is the dialect where 1 stands for an exponent of 128; taken as \
                 exponents as they are (--ray-dialect hk)"
                    .into()
            });
        }
    }
}
