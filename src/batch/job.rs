use crate::settings::{PictureFormat, Settings, path_text};
use kiln_formats::Limits;
use serde::{Deserialize, Serialize};
use std::ffi::{OsStr, OsString};
use std::path::{Path, PathBuf};

/// One asset to be turned into pictures: all that [`super::run_asset`] needs, as plain data.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Job {
    /// The asset's file.
    #[serde(with = "path_text")]
    pub input: PathBuf,
    /// What the manifest calls it: its path below the batch's folder, with `/`.
    pub name: String,
    /// The folder that references may not leave; by default the parent of the asset's folder.
    #[serde(with = "path_text::optional")]
    pub root: Option<PathBuf>,
    /// How large it may be.
    #[serde(default)]
    pub limits: Limits,
    /// Where the pictures go.
    pub output: Output,
    /// What they look like.
    pub settings: Settings,
}

/// Where an asset's pictures go and how they are called.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Output {
    /// The folder of the whole batch.
    #[serde(with = "path_text")]
    pub folder: PathBuf,
    /// Path below it without the picture's ending, such as `chairs/oak.glb`.
    #[serde(with = "path_text")]
    pub stem: PathBuf,
    /// The ending without the dot, instead of the format's own: `PNG` when somebody asked for `oak.PNG`.
    pub ending: Option<String>,
}

impl Output {
    /// The path of a picture without noise beside that of a picture: `oak.glb.denoised.png` beside `oak.glb.png`.
    pub fn denoised(picture: &Path) -> PathBuf {
        let ending = picture.extension().unwrap_or_default().to_string_lossy();
        picture.with_extension(format!("denoised.{ending}"))
    }

    /// The path below the folder of one picture. Turntables count their frames with at least three digits from 000.
    pub fn picture(&self, frame: Option<u32>, format: PictureFormat) -> PathBuf {
        let mut name: OsString = self.stem.file_name().unwrap_or_default().to_os_string();
        if let Some(frame) = frame {
            name.push(format!(".{frame:03}"));
        }
        name.push(".");
        name.push(self.ending.as_deref().unwrap_or(format.ending()));
        self.stem.with_file_name(name)
    }
}

/// What is being done for an asset.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Stage {
    /// Reading and decoding.
    Import,
    /// Flattening, lights, kd-tree.
    Prepare,
    /// Metering the exposure.
    Expose,
    /// Light transport.
    Render {
        /// Which view, from 0.
        view: u32,
        /// How many there are.
        views: u32,
    },
    /// Encoding and writing.
    Write,
}

impl Stage {
    /// One word.
    pub fn word(self) -> &'static str {
        match self {
            Self::Import => "import",
            Self::Prepare => "prepare",
            Self::Expose => "expose",
            Self::Render { .. } => "render",
            Self::Write => "write",
        }
    }
}

/// A path with `/` between its parts, for manifests. Bytes that are not UTF-8 become `%` and two hexadecimal digits.
pub fn slashed(path: &Path) -> String {
    if path.has_root() {
        return text(path.as_os_str());
    }
    let parts: Vec<_> = path.components().map(|c| text(c.as_os_str())).collect();
    parts.join("/")
}

fn text(name: &OsStr) -> String {
    let mut text = String::new();
    for chunk in name.as_encoded_bytes().utf8_chunks() {
        text += chunk.valid();
        chunk.invalid().iter().for_each(|byte| text += &format!("%{byte:02X}"));
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[cfg(unix)]
    #[test]
    fn names_that_are_no_text_become_some() {
        use std::os::unix::ffi::OsStrExt;
        let slashed_bytes = |bytes: &[u8]| slashed(Path::new(OsStr::from_bytes(bytes)));
        assert_eq!(slashed_bytes(b"caf\xe9/\xff.glb"), "caf%E9/%FF.glb");
        assert_eq!(slashed_bytes("стул/100%.glb".as_bytes()), "стул/100%.glb");
    }

    #[test]
    fn pictures_keep_the_assets_ending() {
        let output = Output { folder: "out".into(), stem: "chairs/oak.glb".into(), ending: None };
        assert_eq!(output.picture(None, PictureFormat::Png), Path::new("chairs/oak.glb.png"));
        assert_eq!(output.picture(Some(7), PictureFormat::Exr), Path::new("chairs/oak.glb.007.exr"));
        assert_eq!(output.picture(Some(1234), PictureFormat::Exr), Path::new("chairs/oak.glb.1234.exr"));
        assert_eq!(Output::denoised(Path::new("a/oak.glb.007.png")), Path::new("a/oak.glb.007.denoised.png"));
        let output = Output { ending: Some("PNG".into()), stem: "oak".into(), ..output };
        assert_eq!(output.picture(None, PictureFormat::Png), Path::new("oak.PNG"));
    }
}
