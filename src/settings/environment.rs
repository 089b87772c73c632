use serde::{Deserialize, Serialize};
use std::path::PathBuf;

/// An equirectangular picture as a light.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct EnvironmentFile {
    /// Radiance HDR, OpenEXR, or any picture that Kiln reads (8-bit ones are taken as sRGB).
    #[serde(with = "super::path_text")]
    pub path: PathBuf,
    /// Turns the environment about +Y, degrees.
    pub rotation_y_deg: f64,
    /// Multiplies its radiance.
    pub intensity: f64,
}

/// What an asset is lit by beside its own lights.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum EnvironmentSettings {
    /// The studio for assets without light, nothing for the others.
    #[default]
    Auto,
    /// Nothing: assets without light stay black.
    None,
    /// The studio, for assets with light too.
    Studio,
    /// The same linear RGB radiance from everywhere.
    Constant([f32; 3]),
    /// A picture.
    File(EnvironmentFile),
}

impl std::str::FromStr for EnvironmentSettings {
    type Err = String;

    /// `auto`, `none`, `studio`, `constant:R,G,B`, `constant:GREY` or the path of a picture.
    fn from_str(text: &str) -> Result<Self, String> {
        match text {
            "" => Err("needs a file, auto, none, studio or constant:R,G,B".into()),
            "auto" => Ok(Self::Auto),
            "none" => Ok(Self::None),
            "studio" => Ok(Self::Studio),
            _ => match text.strip_prefix("constant:") {
                Some(color) => radiance(color).map(Self::Constant),
                None => Ok(Self::File(EnvironmentFile { path: text.into(), rotation_y_deg: 0.0, intensity: 1.0 })),
            },
        }
    }
}

fn radiance(text: &str) -> Result<[f32; 3], String> {
    let explain = || format!("'{text}' is not R,G,B with three numbers that are finite and not negative");
    let numbers: Vec<f32> =
        text.split(',').map(|n| n.trim().parse()).collect::<Result<_, _>>().map_err(|_| explain())?;
    if !numbers.iter().all(|n: &f32| n.is_finite() && *n >= 0.0) {
        return Err(explain());
    }
    match numbers[..] {
        [grey] => Ok([grey; 3]),
        [r, g, b] => Ok([r, g, b]),
        _ => Err(explain()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_constants_and_files_are_told_apart() {
        assert_eq!("studio".parse(), Ok(EnvironmentSettings::Studio));
        assert_eq!("constant:1, 0.5,0".parse(), Ok(EnvironmentSettings::Constant([1.0, 0.5, 0.0])));
        assert_eq!("constant:2".parse(), Ok(EnvironmentSettings::Constant([2.0; 3])));
        let Ok(EnvironmentSettings::File(file)) = "sky/noon.hdr".parse() else { panic!("a path is a file") };
        assert_eq!((file.path, file.intensity), (PathBuf::from("sky/noon.hdr"), 1.0));
        for wrong in ["", "constant:", "constant:1,2", "constant:-1,0,0", "constant:nan,0,0", "constant:1,1,inf"] {
            assert!(wrong.parse::<EnvironmentSettings>().is_err(), "{wrong}");
        }
    }
}
