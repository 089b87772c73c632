use serde::{Deserialize, Serialize};
use std::fmt;
use std::str::FromStr;

/// Something that a scene can call for, and that costs time where it is simulated.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Effect {
    /// Colours and numbers from images.
    Textures,
    /// Shading normals bent by images.
    NormalMaps,
    /// Colours of vertices.
    VertexColors,
    /// Shading normals of vertices.
    SmoothNormals,
    /// Surfaces that are there where alpha reaches a threshold.
    AlphaCutouts,
    /// Surfaces that cover a part of what is behind them.
    AlphaBlending,
    /// Camera rays pass through backs.
    Culling,
    /// Reflection by dielectrics, and Phong highlights.
    Specular,
    /// Reflection by metals.
    Metal,
    /// Perfect mirrors of `.ray` files.
    Mirror,
    /// Light through surfaces.
    Transmission,
    /// Bodies that bend light.
    Refraction,
    /// Bodies that take away light.
    Absorption,
    /// Bodies that bend each colour of light differently.
    Dispersion,
    /// Clear coats.
    Clearcoat,
    /// Fibres.
    Sheen,
    /// Thin films.
    Iridescence,
    /// Highlights with a direction.
    Anisotropy,
    /// Diffuse light through surfaces.
    DiffuseTransmission,
    /// Diffuse surfaces that are not Lambert's.
    DiffuseRoughness,
    /// Surfaces that show their colour and scatter nothing.
    Unlit,
    /// Surfaces that shine.
    Emission,
    /// Point and spot lights.
    PointLights,
    /// Lights from infinitely far away.
    DirectionalLights,
    /// Point lights with an extent (`area_light` of `.ray` files).
    SoftShadows,
    /// Light that shines through bodies and takes on their colour (`.ray`).
    TintedShadows,
    /// Light from all around.
    Environment,
}

impl Effect {
    /// All of them.
    pub const ALL: [Self; 27] = [
        Self::Textures,
        Self::NormalMaps,
        Self::VertexColors,
        Self::SmoothNormals,
        Self::AlphaCutouts,
        Self::AlphaBlending,
        Self::Culling,
        Self::Specular,
        Self::Metal,
        Self::Mirror,
        Self::Transmission,
        Self::Refraction,
        Self::Absorption,
        Self::Dispersion,
        Self::Clearcoat,
        Self::Sheen,
        Self::Iridescence,
        Self::Anisotropy,
        Self::DiffuseTransmission,
        Self::DiffuseRoughness,
        Self::Unlit,
        Self::Emission,
        Self::PointLights,
        Self::DirectionalLights,
        Self::SoftShadows,
        Self::TintedShadows,
        Self::Environment,
    ];

    /// Its name on the command line, in the manifest and in `inspect`.
    pub fn name(self) -> &'static str {
        match self {
            Self::Textures => "textures",
            Self::NormalMaps => "normal-maps",
            Self::VertexColors => "vertex-colors",
            Self::SmoothNormals => "smooth-normals",
            Self::AlphaCutouts => "alpha-cutouts",
            Self::AlphaBlending => "alpha-blending",
            Self::Culling => "culling",
            Self::Specular => "specular",
            Self::Metal => "metal",
            Self::Mirror => "mirror",
            Self::Transmission => "transmission",
            Self::Refraction => "refraction",
            Self::Absorption => "absorption",
            Self::Dispersion => "dispersion",
            Self::Clearcoat => "clearcoat",
            Self::Sheen => "sheen",
            Self::Iridescence => "iridescence",
            Self::Anisotropy => "anisotropy",
            Self::DiffuseTransmission => "diffuse-transmission",
            Self::DiffuseRoughness => "diffuse-roughness",
            Self::Unlit => "unlit",
            Self::Emission => "emission",
            Self::PointLights => "point-lights",
            Self::DirectionalLights => "directional-lights",
            Self::SoftShadows => "soft-shadows",
            Self::TintedShadows => "tinted-shadows",
            Self::Environment => "environment",
        }
    }
}

impl fmt::Display for Effect {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str(self.name())
    }
}

/// A set of effects.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(from = "Vec<Effect>", into = "Vec<Effect>")]
pub struct EffectSet(u32);

impl EffectSet {
    /// Whether it holds an effect.
    pub fn has(self, effect: Effect) -> bool {
        self.0 >> effect as u32 & 1 != 0
    }

    /// Every effect there is.
    pub fn all() -> Self {
        Effect::ALL.into_iter().collect()
    }

    /// Those that are in one of two sets.
    pub fn and(self, other: Self) -> Self {
        Self(self.0 | other.0)
    }

    /// Those that are not in `other`.
    pub fn but(self, other: Self) -> Self {
        Self(self.0 & !other.0)
    }

    /// Whether one of these is in it.
    pub fn has_any(self, effects: &[Effect]) -> bool {
        effects.iter().any(|effect| self.has(*effect))
    }

    /// Adds an effect.
    pub fn insert(&mut self, effect: Effect) {
        self.0 |= 1 << effect as u32;
    }

    /// Whether there is nothing in it.
    pub fn is_empty(self) -> bool {
        self.0 == 0
    }

    /// Its effects, in the order of [`Effect::ALL`].
    pub fn iter(self) -> impl Iterator<Item = Effect> {
        Effect::ALL.into_iter().filter(move |effect| self.has(*effect))
    }
}

impl From<Vec<Effect>> for EffectSet {
    fn from(effects: Vec<Effect>) -> Self {
        effects.into_iter().collect()
    }
}

impl From<EffectSet> for Vec<Effect> {
    fn from(set: EffectSet) -> Self {
        set.iter().collect()
    }
}

impl FromIterator<Effect> for EffectSet {
    fn from_iter<I: IntoIterator<Item = Effect>>(effects: I) -> Self {
        let mut set = Self::default();
        effects.into_iter().for_each(|effect| set.insert(effect));
        set
    }
}

/// Which effects are simulated: those that the scene calls for, unless told otherwise.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct EffectSettings {
    /// The scene is rendered as the file has it, without rewriting what has no effect.
    pub raw: bool,
    /// Effects that are left out though the scene calls for them: another picture.
    pub without: EffectSet,
    /// Effects that are reckoned with at every hit, whether the scene calls for them or not: the same picture, byte for byte.
    #[serde(default, skip_serializing_if = "is_empty")]
    pub forced: EffectSet,
}

impl FromStr for EffectSettings {
    type Err = String;

    /// `auto`, or a list of `raw`, `all`, `+NAME` and `-NAME`, with commas between.
    fn from_str(text: &str) -> Result<Self, String> {
        let mut settings = Self::default();
        for word in text.split(',').map(str::trim) {
            match (word, word.strip_prefix('-')) {
                ("auto", _) => {}
                ("raw", _) => settings.raw = true,
                ("all", _) => settings.forced = EffectSet::all(),
                (_, Some("environment")) => return Err("'environment' is left out by --env none".into()),
                (_, Some(name)) => settings.without.insert(by_name(name)?),
                _ => match word.strip_prefix('+') {
                    Some(name) => settings.forced.insert(by_name(name)?),
                    None => return Err(format!("'{word}' is not auto, raw, all, or +NAME or -NAME of an effect")),
                },
            }
        }
        Ok(settings)
    }
}

fn is_empty(set: &EffectSet) -> bool {
    set.is_empty()
}

fn by_name(name: &str) -> Result<Effect, String> {
    Effect::ALL.into_iter().find(|effect| effect.name() == name).ok_or_else(|| {
        let known: Vec<_> = Effect::ALL.iter().map(|effect| effect.name()).collect();
        format!("'{name}' is no effect; these are: {}", known.join(", "))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn effects_are_left_out_by_name() {
        let settings: EffectSettings = "-clearcoat,-normal-maps".parse().expect("known effects");
        assert!(settings.without.has(Effect::Clearcoat) && settings.without.has(Effect::NormalMaps));
        assert_eq!(settings.without.iter().count(), 2);
        assert!("raw".parse::<EffectSettings>().expect("a word").raw);
        assert_eq!("auto".parse(), Ok(EffectSettings::default()));
        assert_eq!("all".parse::<EffectSettings>().expect("a word").forced, EffectSet::all());
        let mixed: EffectSettings = "+culling,-sheen".parse().expect("known effects");
        assert!(mixed.forced.has(Effect::Culling) && mixed.without.has(Effect::Sheen));
        for wrong in ["-coat", "+coat", "clearcoat", "", "-environment"] {
            assert!(wrong.parse::<EffectSettings>().is_err(), "{wrong}");
        }
    }

    #[test]
    fn names_are_those_of_the_manifest() {
        for (k, effect) in Effect::ALL.into_iter().enumerate() {
            assert_eq!(effect as usize, k);
            assert_eq!(serde_json::to_value(effect).expect("a word"), effect.name());
        }
    }
}
