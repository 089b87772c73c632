//! Buffers and views of them.

use super::document::invalid;
use super::uri;
use crate::{Control, ErrorCode, ImportError, Place, Resources};
use gltf::json;
use std::collections::BTreeMap;
use std::ops::Range;

enum Source {
    Owned(Vec<u8>),
    /// A part of the GLB file.
    Chunk(Range<usize>),
    /// A placeholder, such as the fallback of a compression.
    Absent,
}

/// The bytes of all buffers.
pub(super) struct Buffers {
    file: Vec<u8>,
    sources: Vec<Source>,
    /// Views that were compressed, by index.
    decoded: BTreeMap<usize, Vec<u8>>,
}

/// The bytes of a view, and its stride where the file gives one.
pub(super) struct View<'a> {
    pub(super) bytes: &'a [u8],
    pub(super) stride: Option<usize>,
}

impl Buffers {
    /// Loads every buffer. `file` and `bin` are the GLB file and its binary chunk.
    ///
    /// # Errors
    /// The error of [`uri::load`], at the buffer's JSON pointer; [`ErrorCode::Invalid`] when a buffer is shorter than
    /// it says.
    pub(super) fn load(
        root: &json::Root,
        file: Vec<u8>,
        bin: Option<Range<usize>>,
        resources: &mut Resources,
        control: &Control,
    ) -> Result<Self, ImportError> {
        let mut sources = Vec::new();
        for (i, buffer) in root.buffers.iter().enumerate() {
            control.check()?;
            let place = |name: &str| Place::Json(format!("/buffers/{i}/{name}"));
            let (source, len) = match (&buffer.uri, &bin) {
                (Some(uri), _) => {
                    let bytes = uri::load(uri, resources).map_err(|e| e.at(place("uri")))?;
                    let len = bytes.len();
                    (Source::Owned(bytes), len)
                }
                (None, Some(bin)) if i == 0 => (Source::Chunk(bin.clone()), bin.len()),
                (None, _) => {
                    sources.push(Source::Absent);
                    continue;
                }
            };
            let stated = buffer.byte_length.0;
            if (len as u64) < stated {
                let message = format!("has {len} bytes, not the {stated} that it states");
                return Err(ImportError::new(ErrorCode::Invalid, message).at(place("byteLength")));
            }
            sources.push(source);
        }
        Ok(Self { file, sources, decoded: BTreeMap::new() })
    }

    /// Puts decoded bytes, which have the lengths that the views state, in the place of views.
    pub(super) fn set_decoded(&mut self, views: BTreeMap<usize, Vec<u8>>) {
        self.decoded = views;
    }

    /// Adds the bytes of one more buffer.
    pub(super) fn push(&mut self, bytes: Vec<u8>) {
        self.sources.push(Source::Owned(bytes));
    }

    /// The bytes of a buffer; `None` for placeholders and wrong indices.
    pub(super) fn bytes(&self, buffer: usize) -> Option<&[u8]> {
        match self.sources.get(buffer)? {
            Source::Owned(bytes) => Some(bytes),
            Source::Chunk(range) => self.file.get(range.clone()),
            Source::Absent => None,
        }
    }

    /// A buffer view.
    ///
    /// # Errors
    /// [`ErrorCode::Invalid`] at the JSON pointer of what does not fit. `from` is that of the reference.
    pub(super) fn view(
        &self,
        root: &json::Root,
        view: json::Index<json::buffer::View>,
        from: &dyn Fn() -> String,
    ) -> Result<View<'_>, ImportError> {
        let index = view.value();
        let Some(view) = root.buffer_views.get(index) else {
            return Err(invalid(from(), format!("buffer view {index} of {}", root.buffer_views.len())));
        };
        let range = Self::check_view(root, view, index)?;
        let buffer = view.buffer.value();
        let bytes = match self.decoded.get(&index) {
            Some(decoded) => Some(decoded.as_slice()),
            None => self.bytes(buffer).and_then(|bytes| bytes.get(range)),
        };
        let Some(bytes) = bytes else {
            return Err(invalid(format!("/buffers/{buffer}/uri"), "the buffer has no data"));
        };
        Ok(View { bytes, stride: view.byte_stride.map(|s| s.0) })
    }

    /// The range of a view in its buffer, which has the length that it states, or none.
    ///
    /// # Errors
    /// [`ErrorCode::Invalid`] when there is no such buffer, or the view lies outside it.
    pub(super) fn check_view(
        root: &json::Root,
        view: &json::buffer::View,
        index: usize,
    ) -> Result<Range<usize>, ImportError> {
        let buffer = view.buffer.value();
        let Some(found) = root.buffers.get(buffer) else {
            let message = format!("buffer {buffer} of {}", root.buffers.len());
            return Err(invalid(format!("/bufferViews/{index}/buffer"), message));
        };
        let (offset, length) = (view.byte_offset.map_or(0, |o| o.0), view.byte_length.0);
        let end = offset.checked_add(length).filter(|end| *end <= found.byte_length.0);
        let range = usize::try_from(offset).ok().zip(end.and_then(|e| usize::try_from(e).ok()));
        range.map(|(start, end)| start..end).ok_or_else(|| {
            let message = format!("{length} bytes from {offset} on lie outside the buffer's {}", found.byte_length.0);
            invalid(format!("/bufferViews/{index}"), message)
        })
    }
}
