//! The file around a glTF document: plain JSON, or GLB with its chunks.

use crate::{ErrorCode, ImportError, Place};
use serde_json::Value;
use std::ops::Range;

const JSON_CHUNK: u32 = 0x4E4F_534A;
const BIN_CHUNK: u32 = 0x004E_4942;

/// A file split into its parts.
pub(super) struct Container {
    /// The document.
    pub(super) json: Value,
    /// The whole file where it is a GLB, else empty.
    pub(super) bytes: Vec<u8>,
    /// Where in `bytes` the binary chunk lies.
    pub(super) bin: Option<Range<usize>>,
}

fn at(offset: usize, message: impl Into<String>) -> ImportError {
    ImportError::new(ErrorCode::Syntax, message).at(Place::Byte(offset as u64))
}

fn word(bytes: &[u8], offset: usize) -> Option<u32> {
    bytes.get(offset..)?.first_chunk().map(|b| u32::from_le_bytes(*b))
}

/// Splits a file; GLB is told by its magic number.
///
/// # Errors
/// [`ErrorCode::Syntax`] with the byte offset for lengths that do not fit the file, or with line and column for JSON
/// that is none; [`ErrorCode::Unsupported`] for binary glTF 1.0.
pub(super) fn split(bytes: Vec<u8>) -> Result<Container, ImportError> {
    if !bytes.starts_with(b"glTF") {
        let json = parse(&bytes)?;
        return Ok(Container { json, bytes: Vec::new(), bin: None });
    }
    let (json, bin) = chunks(&bytes)?;
    let json = parse(bytes.get(json).unwrap_or_default())?;
    Ok(Container { json, bytes, bin })
}

fn chunks(bytes: &[u8]) -> Result<(Range<usize>, Option<Range<usize>>), ImportError> {
    let (Some(version), Some(length)) = (word(bytes, 4), word(bytes, 8)) else {
        return Err(at(bytes.len(), "the GLB header is cut short"));
    };
    if version != 2 {
        let message = format!("is binary glTF {version}; only version 2 can be read");
        return Err(ImportError::new(ErrorCode::Unsupported, message).at(Place::Byte(4)));
    }
    let length = length as usize;
    if length > bytes.len() {
        let message = format!("the GLB header says {length} bytes but the file has {}", bytes.len());
        return Err(at(8, message));
    }
    // Bytes after the stated length are no part of the asset.
    let bytes = bytes.get(..length).unwrap_or_default();
    let (mut json, mut bin) = (None, None);
    let mut offset = 12;
    while offset < length {
        let (Some(size), Some(kind)) = (word(bytes, offset), word(bytes, offset + 4)) else {
            return Err(at(offset, "the header of a GLB chunk is cut short"));
        };
        let start = offset + 8;
        let end = start
            .checked_add(size as usize)
            .filter(|end| *end <= length)
            .ok_or_else(|| at(offset, format!("a GLB chunk of {size} bytes reaches past the end")))?;
        match kind {
            JSON_CHUNK if json.is_none() => json = Some(start..end),
            BIN_CHUNK if json.is_some() && bin.is_none() => bin = Some(start..end),
            JSON_CHUNK | BIN_CHUNK => return Err(at(offset, "a GLB chunk is out of order or there twice")),
            // Unknown chunks are to be ignored, but the first is always JSON.
            _ if json.is_none() => return Err(at(offset, "the first GLB chunk is not JSON")),
            _ => {}
        }
        offset = end;
    }
    Ok((json.ok_or_else(|| at(12, "has no JSON chunk"))?, bin))
}

fn parse(bytes: &[u8]) -> Result<Value, ImportError> {
    let text = bytes.strip_prefix(b"\xEF\xBB\xBF").unwrap_or(bytes);
    // Some writers pad the JSON chunk with zeros instead of spaces.
    let zeros = text.iter().rev().take_while(|b| **b == 0).count();
    let text = text.get(..text.len() - zeros).unwrap_or_default();
    // serde_json refuses nesting deeper than 128, so that no walk over the value can exhaust the stack.
    serde_json::from_slice(text).map_err(|e| {
        let narrow = |n: usize| u32::try_from(n).unwrap_or(u32::MAX);
        let place = Place::Text { line: narrow(e.line()), column: narrow(e.column()) };
        ImportError::new(ErrorCode::Syntax, format!("is not JSON: {e}")).at(place)
    })
}
