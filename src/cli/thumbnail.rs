use super::exit::{Exit, Fatal};
use clap::{Args, value_parser};
use kiln::Control;
use kiln::batch::{Desk, Job, MemorySink, Output, run_asset_with};
use kiln::formats::Limits;
use kiln::settings::{Goal, PictureFormat, PictureSettings, Preset, RenderSettings, Settings, ViewSettings};
use kiln::write::atomic;
use std::path::PathBuf;

const EXAMPLES: &str = "\
Examples:
  kiln thumbnail chair.glb chair.png
  kiln thumbnail --size 512 file:///models/chair%20with%20arms.glb thumbnail.png

File managers that follow the freedesktop specification show Kiln's thumbnails once scripts/desktop/kiln.thumbnailer is in
~/.local/share/thumbnailers (docs/desktop.md).";

/// `kiln thumbnail`.
#[derive(Args)]
#[command(after_help = EXAMPLES)]
pub struct ThumbnailCommand {
    /// A .gltf, .glb, .obj or .ray file, as a path or a file:// address
    asset: String,
    /// The PNG file to write, whatever its name ends in
    output: PathBuf,
    /// Width and height in pixels
    #[arg(short, long, default_value_t = 256, value_name = "N", value_parser = value_parser!(u32).range(1..=4096))]
    size: u32,
    /// Seconds that it may take; the best picture so far is written
    #[arg(long, default_value_t = 10.0, value_name = "SECONDS", value_parser = super::options::positive)]
    time: f64,
}

impl ThumbnailCommand {
    /// Does it. A picture that was cut short is better than none: only without one it failed.
    ///
    /// # Errors
    /// When there is no picture.
    pub fn run(self) -> Result<Exit, Fatal> {
        let input = path(&self.asset).ok_or_else(|| Fatal::usage(format!("{}: is not a local file", self.asset)))?;
        let (goal, spp) = Preset::Preview.goal();
        let job = Job {
            name: self.asset.clone(),
            input,
            root: None,
            limits: Limits::default(),
            output: Output { folder: PathBuf::new(), stem: "thumbnail".into(), ending: None },
            settings: Settings {
                views: ViewSettings { width: self.size, height: self.size, ..ViewSettings::default() },
                render: RenderSettings { spp, ..RenderSettings::default() },
                goal: Goal { time: Some(self.time), ..goal },
                pictures: PictureSettings { formats: vec![PictureFormat::Png], ..PictureSettings::default() },
                ..Settings::default()
            },
        };
        let sink = MemorySink::default();
        let desk = Desk { sink: &sink, on_stage: &|_| (), environment: None };
        let outcome = run_asset_with(&job, &Control::default(), &desk);
        let Some((_, png)) = sink.into_files().into_iter().next() else {
            let message = outcome.error_message.unwrap_or_else(|| "there is no picture".into());
            return Err(Fatal::failed(format!("{}: {message}", self.asset)));
        };
        let unwritable = |e| Fatal::failed(format!("{}: cannot be written: {e}", self.output.display()));
        atomic::write(&self.output, &png).map_err(unwritable)?;
        Ok(Exit::Done)
    }
}

/// The path that a text means: itself, or that of a `file://` address (RFC 8089) with its `%XX`.
fn path(text: &str) -> Option<PathBuf> {
    let Some(rest) = text.strip_prefix("file://") else {
        let is_address = text.split_once("://").is_some_and(|(s, _)| s.bytes().all(|b| b.is_ascii_alphanumeric()));
        return (!is_address).then(|| text.into());
    };
    let encoded = rest.strip_prefix("localhost").unwrap_or(rest);
    encoded.starts_with('/').then(|| decoded(encoded))?
}

#[cfg(unix)]
fn from_bytes(bytes: Vec<u8>) -> Option<PathBuf> {
    use std::os::unix::ffi::OsStringExt;
    Some(std::ffi::OsString::from_vec(bytes).into())
}

#[cfg(not(unix))]
fn from_bytes(bytes: Vec<u8>) -> Option<PathBuf> {
    let text = String::from_utf8(bytes).ok()?;
    // file:///C:/a.glb
    Some(text.strip_prefix('/').filter(|rest| rest.as_bytes().get(1) == Some(&b':')).unwrap_or(&text).into())
}

fn decoded(text: &str) -> Option<PathBuf> {
    let mut bytes = Vec::with_capacity(text.len());
    let mut rest = text.as_bytes();
    while let [first, after @ ..] = rest {
        let hex = |b: Option<&u8>| b.and_then(|b| char::from(*b).to_digit(16));
        (rest, _) = match (first, hex(after.first()), hex(after.get(1))) {
            (b'%', Some(high), Some(low)) => (&after[2..], bytes.push((high * 16 + low) as u8)),
            (b'%', ..) => return None,
            (byte, ..) => (after, bytes.push(*byte)),
        };
    }
    from_bytes(bytes)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn addresses_and_paths_are_files() {
        let is = |text: &str, want: &str| assert_eq!(path(text), Some(PathBuf::from(want)), "{text}");
        is("chairs/oak 50%.glb", "chairs/oak 50%.glb");
        is("file:///home/me/a%20%C3%A9%23.glb", "/home/me/a é#.glb");
        is("file://localhost/a.glb", "/a.glb");
        for wrong in ["file://elsewhere/a.glb", "https://example.org/a.glb", "file:///a%2", "file:///a%zz"] {
            assert_eq!(path(wrong), None, "{wrong}");
        }
    }
}
