use super::PathText;
use serde::{Deserialize, Serialize};
use std::str::FromStr;

/// How scene-referred light becomes displayable colour in [0, 1].
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, clap::ValueEnum)]
#[serde(rename_all = "lowercase")]
#[value(rename_all = "lowercase")]
pub enum ToneMap {
    /// Khronos PBR Neutral: keeps base colours as they are under even light.
    #[default]
    Neutral,
    /// Stephen Hill's fit of the ACES RRT and ODT.
    Aces,
    /// Troy Sobotka's AgX, base look, in Benjamin Wrensch's fit.
    Agx,
    /// Clamps each channel.
    None,
    /// As the course tracers of `.ray` scenes write: clamped, over black, 8 bits of linear light without rounding up.
    Course,
}

/// How bright the displayed picture is. EXR files are never exposed.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Exposure {
    /// Metered by a small prepass with fixed random numbers, one value for all views of an asset.
    Auto,
    /// Radiance is multiplied by 2 to this power.
    Ev(f64),
}

impl Default for Exposure {
    fn default() -> Self {
        Self::Ev(0.0)
    }
}

impl FromStr for Exposure {
    type Err = String;

    /// `auto` or a number from −64 to 64.
    fn from_str(text: &str) -> Result<Self, String> {
        match text.parse::<f64>() {
            _ if text == "auto" => Ok(Self::Auto),
            Ok(ev) if ev.abs() <= 64.0 => Ok(Self::Ev(ev)),
            _ => Err(format!("'{text}' is neither auto nor a number of EV from -64 to 64")),
        }
    }
}

/// What is seen where the asset is not.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Background {
    /// Nothing: alpha 0.
    #[default]
    Transparent,
    /// The environment that lights the asset.
    Environment,
    /// An sRGB colour (in PNG files; EXR files stay transparent).
    Color([u8; 3]),
}

impl FromStr for Background {
    type Err = String;

    /// `transparent`, `environment`, `#rrggbb` or `#rgb`.
    fn from_str(text: &str) -> Result<Self, String> {
        let explain = || format!("'{text}' is none of transparent, environment, #rrggbb");
        let hex = match text {
            "transparent" => return Ok(Self::Transparent),
            "environment" => return Ok(Self::Environment),
            _ => text.strip_prefix('#').ok_or_else(explain)?,
        };
        let digits: Vec<u8> = hex
            .chars()
            .map(|c| c.to_digit(16).and_then(|d| u8::try_from(d).ok()))
            .collect::<Option<_>>()
            .ok_or_else(explain)?;
        match digits[..] {
            [r, g, b] => Ok(Self::Color([r * 17, g * 17, b * 17])),
            [r1, r0, g1, g0, b1, b0] => Ok(Self::Color([r1 * 16 + r0, g1 * 16 + g0, b1 * 16 + b0])),
            _ => Err(explain()),
        }
    }
}

/// Bits per channel of a PNG.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, clap::ValueEnum)]
pub enum BitDepth {
    /// 8 bits.
    #[default]
    #[serde(rename = "8")]
    #[value(name = "8")]
    Eight,
    /// 16 bits.
    #[serde(rename = "16")]
    #[value(name = "16")]
    Sixteen,
}

/// A picture's file format.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize, clap::ValueEnum)]
#[serde(rename_all = "lowercase")]
#[value(rename_all = "lowercase")]
pub enum PictureFormat {
    /// Tone-mapped sRGB with straight alpha.
    Png,
    /// Linear float with premultiplied alpha.
    Exr,
}

impl PictureFormat {
    /// The file ending, without the dot.
    pub fn ending(self) -> &'static str {
        match self {
            Self::Png => "png",
            Self::Exr => "exr",
        }
    }
}

/// What an EXR file has beside the picture.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize, clap::ValueEnum)]
#[serde(rename_all = "lowercase")]
#[value(rename_all = "lowercase")]
pub enum Layer {
    /// Base or diffuse colour of the first surface.
    Albedo,
    /// Its shading normal, world space.
    Normal,
    /// Its distance along the camera's axis, world units.
    Depth,
    /// Which object it is, as Cryptomatte.
    Object,
    /// Which material, as Cryptomatte.
    Material,
}

/// From light to files.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct PictureSettings {
    /// Tone mapping (PNG).
    pub tonemap: ToneMap,
    /// Exposure (PNG).
    pub exposure: Exposure,
    /// What is behind the asset.
    pub background: Background,
    /// Bits per channel (PNG).
    pub bits: BitDepth,
    /// The files written for each view.
    pub formats: Vec<PictureFormat>,
    /// Further layers (EXR).
    #[serde(default)]
    pub layers: Vec<Layer>,
    /// The program of Open Image Denoise that makes a picture without noise of each, to stand beside it; `None`: there is none.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub denoise: Option<PathText>,
}

impl Default for PictureSettings {
    fn default() -> Self {
        Self {
            tonemap: ToneMap::default(),
            exposure: Exposure::default(),
            background: Background::default(),
            bits: BitDepth::default(),
            formats: vec![PictureFormat::Png, PictureFormat::Exr],
            layers: Vec::new(),
            denoise: None,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn backgrounds_are_words_or_hex_colours() {
        assert_eq!("environment".parse(), Ok(Background::Environment));
        assert_eq!("#10fF80".parse(), Ok(Background::Color([0x10, 0xff, 0x80])));
        assert_eq!("#1f8".parse(), Ok(Background::Color([0x11, 0xff, 0x88])));
        for wrong in ["", "#", "#12345", "10ff80", "#10ff8g", "blue", "#١٢٣"] {
            assert!(wrong.parse::<Background>().is_err(), "{wrong}");
        }
    }

    #[test]
    fn exposures_are_auto_or_finite() {
        assert_eq!("auto".parse(), Ok(Exposure::Auto));
        assert_eq!("-1.5".parse(), Ok(Exposure::Ev(-1.5)));
        for wrong in ["nan", "inf", "1e9", "bright", ""] {
            assert!(wrong.parse::<Exposure>().is_err(), "{wrong}");
        }
    }
}
