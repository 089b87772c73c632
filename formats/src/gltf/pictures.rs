//! The images of textures: each decoded once, and the next one that a texture names where one cannot be shown.

use super::basisu;
use super::buffers::Buffers;
use super::report::Report;
use super::uri;
use crate::scene::{Image, ImageId};
use crate::{Control, ErrorCode, ImportError, Place, Resources, images, parallel};
use gltf::json;
use std::borrow::Cow;
use std::collections::{BTreeMap, BTreeSet};

/// What tells one encoded image from another.
#[derive(PartialEq, Eq, PartialOrd, Ord)]
enum Key<'a> {
    Uri(&'a str),
    View(usize),
}

/// Why an image of the document cannot be shown.
#[derive(Clone)]
struct Failure {
    code: &'static str,
    message: String,
}

impl Failure {
    fn missing(message: impl Into<String>) -> Self {
        Self { code: "missing-texture", message: message.into() }
    }

    fn of_decoding(error: ImportError) -> Self {
        let unsupported = error.code == ErrorCode::Unsupported;
        Self { code: if unsupported { "unsupported-texture" } else { "broken-texture" }, message: error.message }
    }
}

/// An image that was looked at: its number among those decoded, or why there is none.
type Looked = Result<usize, Failure>;

/// Files of images that have been read, or why not, by URI.
pub(super) type Files = BTreeMap<String, Result<Vec<u8>, ImportError>>;

/// Reads the files of the images that textures name first.
///
/// # Errors
/// [`ErrorCode::Stopped`].
pub(super) fn read_files(
    root: &json::Root,
    textures: &[usize],
    resources: &mut Resources,
    control: &Control,
) -> Result<Files, ImportError> {
    let mut files = Files::new();
    for texture in textures {
        control.check()?;
        let first = known_images(root, *texture).first().and_then(|image| root.images.get(*image));
        let uri = first.and_then(|image| image.uri.as_ref());
        if let Some(uri) = uri.filter(|uri| !uri.starts_with("data:") && !files.contains_key(*uri)) {
            let file = uri::load(uri, resources);
            // The same picture under another name is read again when it is asked for, and not kept until then.
            if file.is_err() || !files.values().any(|known| known.as_ref().ok() == file.as_ref().ok()) {
                files.insert(uri.clone(), file);
            }
        }
    }
    Ok(files)
}

/// Where the images of a document are.
pub(super) struct Encoded<'a> {
    pub(super) root: &'a json::Root,
    pub(super) buffers: &'a Buffers,
    pub(super) files: Files,
}

struct Pictures<'a, 'r> {
    root: &'a json::Root,
    buffers: &'a Buffers,
    files: Files,
    resources: &'r mut Resources,
    control: &'r Control,
    /// By place of the bytes.
    distinct: BTreeMap<Key<'a>, Looked>,
    /// With the image of the document that they were first met in.
    encoded: Vec<(usize, Cow<'a, [u8]>)>,
    decoded: Vec<Result<ImageId, Failure>>,
    /// By the headers, of all but those that could not be decoded.
    texels: u64,
}

/// Puts the images of textures (numbers in the document) into `pictures` and tells which is whose. The first of a texture's images that can
/// be shown is taken; where there is none, the warnings say why.
///
/// # Errors
/// [`ErrorCode::TooLarge`] when the images' headers claim more texels than the limit; [`ErrorCode::Stopped`].
pub(super) fn load(
    textures: &[usize],
    encoded: Encoded,
    resources: &mut Resources,
    pictures: &mut Vec<Image>,
    report: &mut Report,
    control: &Control,
) -> Result<Vec<Option<ImageId>>, ImportError> {
    let Encoded { root, buffers, files } = encoded;
    let mut all = Pictures {
        root,
        buffers,
        files,
        resources,
        control,
        distinct: BTreeMap::new(),
        encoded: Vec::new(),
        decoded: Vec::new(),
        texels: 0,
    };
    let mut candidates: Vec<Vec<usize>> = textures.iter().map(|texture| candidates(root, *texture, report)).collect();
    candidates.iter_mut().for_each(|images| images.reverse());
    let mut found = vec![None; textures.len()];
    let mut failed: Vec<Vec<(usize, Failure)>> = vec![Vec::new(); textures.len()];
    while candidates.iter().any(|left| !left.is_empty()) {
        let mut round = Vec::new();
        for (slot, left) in candidates.iter_mut().enumerate() {
            control.check()?;
            if let Some(image) = left.pop() {
                round.push((slot, image, all.look(image)));
            }
        }
        all.decode(pictures)?;
        for (slot, image, looked) in round {
            match looked.and_then(|number| all.decoded[number].clone()) {
                Ok(id) => {
                    found[slot] = Some(id);
                    candidates[slot].clear();
                    for (image, why) in &failed[slot] {
                        let message = format!("image {image} {}; another one of the texture is shown", why.message);
                        report.warn("texture-fallback", format!("/textures/{}", textures[slot]), message);
                    }
                }
                Err(why) => failed[slot].push((image, why)),
            }
        }
    }
    let mut told = BTreeSet::new();
    for (_, failed) in found.iter().zip(failed).filter(|(found, _)| found.is_none()) {
        for (image, why) in failed {
            if told.insert(image) {
                report.warn(why.code, format!("/images/{image}"), why.message);
            }
        }
    }
    Ok(found)
}

/// A number that an extension of a texture gives for its image.
fn by_extension(root: &json::Root, texture: usize, name: &str) -> Option<usize> {
    let extension = root.textures.get(texture)?.extensions.as_ref()?.others.get(name)?;
    usize::try_from(extension.get("source")?.as_u64()?).ok()
}

/// The images that a texture names, the best first.
fn known_images(root: &json::Root, texture: usize) -> Vec<usize> {
    let other = |name| by_extension(root, texture, name);
    let plain = root.textures.get(texture).map(|texture| texture.source.value());
    let named = [other("EXT_texture_webp"), other("KHR_texture_basisu"), plain, other("MSFT_texture_dds")];
    named.into_iter().flatten().filter(|image| *image < root.images.len()).collect()
}

/// As [`known_images`]; that there is none is reported.
fn candidates(root: &json::Root, texture: usize, report: &mut Report) -> Vec<usize> {
    let known = known_images(root, texture);
    if known.is_empty() && texture < root.textures.len() {
        let place = format!("/textures/{texture}");
        if by_extension(root, texture, "EXT_texture_avif").is_some() {
            let message = "its only image is AVIF, which is not decoded; its inputs go without it";
            report.warn("unsupported-texture", place, message);
        } else {
            report.warn("missing-texture", place, "names no image that can be read; its inputs go without it");
        }
    }
    known
}

impl<'a> Pictures<'a, '_> {
    /// Reads the bytes of an image of the document, unless they are there.
    fn look(&mut self, image: usize) -> Looked {
        let none = || Failure::missing("the image has no data");
        let source = self.root.images.get(image).ok_or_else(none)?;
        let key = match (&source.uri, source.buffer_view) {
            (Some(uri), _) => Key::Uri(uri),
            (None, Some(view)) => Key::View(view.value()),
            (None, None) => return Err(none()),
        };
        if let Some(known) = self.distinct.get(&key) {
            return known.clone();
        }
        let bytes = match &key {
            Key::Uri(uri) => self.files.remove(*uri).unwrap_or_else(|| uri::load(uri, self.resources)).map(Cow::Owned),
            Key::View(view) => {
                let view = json::Index::new(u32::try_from(*view).unwrap_or(u32::MAX));
                let place = || format!("/images/{image}/bufferView");
                self.buffers.view(self.root, view, &place).map(|view| Cow::Borrowed(view.bytes))
            }
        };
        let looked = match bytes {
            // Exporters write the same picture under several names.
            Ok(bytes) => Ok(self.encoded.iter().position(|(_, known)| *known == bytes).unwrap_or_else(|| {
                self.encoded.push((image, bytes));
                self.encoded.len() - 1
            })),
            Err(error) => Err(Failure::missing(error.to_string())),
        };
        self.distinct.insert(key, looked.clone());
        looked
    }

    /// Decodes what is not decoded yet, or reads its headers where no more is wanted.
    fn decode(&mut self, pictures: &mut Vec<Image>) -> Result<(), ImportError> {
        let limit = self.resources.limits().max_texels;
        let new = &self.encoded[self.decoded.len()..];
        for (image, bytes) in new {
            self.texels = self.texels.saturating_add(stated_texels(bytes));
            if self.texels > limit {
                let message = format!("the images have more than {limit} texels");
                return Err(ImportError::new(ErrorCode::TooLarge, message).at(Place::Json(format!("/images/{image}"))));
            }
        }
        let decode = |(image, bytes): &(usize, Cow<[u8]>)| {
            self.control.check()?;
            let decode = match (basisu::is_ktx2(bytes), self.resources.is_survey()) {
                (true, false) => basisu::decode,
                (true, true) => basisu::header,
                (false, false) => images::decode,
                (false, true) => images::header,
            };
            let decoded = decode(bytes, &name(self.root, *image), limit);
            self.control.advance(1);
            decoded
        };
        let results = parallel::map_costly(new, self.control, |(_, bytes)| bytes.len(), decode);
        for ((_, bytes), result) in new.iter().zip(results) {
            self.decoded.push(match result {
                Ok(image) => {
                    pictures.push(image);
                    Ok((pictures.len() - 1) as ImageId)
                }
                Err(error) if error.code == ErrorCode::Stopped => return Err(error),
                Err(error) => {
                    // What is not there takes no room from another image of the texture.
                    self.texels = self.texels.saturating_sub(stated_texels(bytes));
                    Err(Failure::of_decoding(error))
                }
            });
        }
        Ok(())
    }
}

/// Width times height by the header, 0 where it cannot be read.
fn stated_texels(bytes: &[u8]) -> u64 {
    if basisu::is_ktx2(bytes) {
        return basisu::stated_texels(bytes);
    }
    images::dimensions(bytes, "").map_or(0, |(w, h)| u64::from(w) * u64::from(h))
}

fn name(root: &json::Root, index: usize) -> String {
    let image = root.images.get(index);
    let file = image.and_then(|i| i.uri.as_deref()).filter(|uri| !uri.starts_with("data:"));
    let name = image.and_then(|i| i.name.as_deref()).filter(|n| !n.is_empty());
    file.or(name).map_or_else(|| format!("images/{index}"), str::to_owned)
}
