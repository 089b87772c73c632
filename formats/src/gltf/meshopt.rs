//! EXT_meshopt_compression and KHR_meshopt_compression: buffer views decoded by the `meshopt` crate.

use super::buffers::Buffers;
use super::document::invalid;
use super::report::Report;
use crate::{Control, ErrorCode, ImportError, Limits, Place};
use gltf::json;
use serde::Deserialize;
use std::collections::BTreeMap;

/// The names under which the extension goes, the newer first.
pub(super) const NAMES: [&str; 2] = ["KHR_meshopt_compression", "EXT_meshopt_compression"];

/// Decoded bytes that need no justification by the size of what they are decoded from, and how many each encoded
/// byte justifies beyond them. The format's own bound is near 1024; data that tell anything stay far below this one.
const FREE_BYTES: u64 = 128 << 20;
const BYTES_PER_BYTE: u64 = 64;

#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
struct Extension {
    buffer: usize,
    #[serde(default)]
    byte_offset: u64,
    byte_length: u64,
    byte_stride: usize,
    count: u64,
    mode: Mode,
    #[serde(default)]
    filter: Filter,
}

#[derive(Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "UPPERCASE")]
enum Mode {
    Attributes,
    Triangles,
    Indices,
}

#[derive(Clone, Copy, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "UPPERCASE")]
enum Filter {
    #[default]
    None,
    Octahedral,
    Quaternion,
    Exponential,
    Color,
}

/// Decodes every compressed buffer view; the result goes by the view's index. A view whose stream is broken and whose
/// fallback has data keeps the fallback, with a warning.
///
/// # Errors
/// At the JSON pointer of the extension: [`ErrorCode::Invalid`] for streams and descriptions that do not fit,
/// [`ErrorCode::TooLarge`] for data that grow out of all proportion; [`ErrorCode::Stopped`].
pub(super) fn decode_views(
    root: &json::Root,
    buffers: &Buffers,
    limits: &Limits,
    report: &mut Report,
    control: &Control,
) -> Result<BTreeMap<usize, Vec<u8>>, ImportError> {
    let mut decoded = BTreeMap::new();
    let mut allowance = FREE_BYTES;
    for (i, view) in root.buffer_views.iter().enumerate() {
        let extensions = view.extensions.as_ref().map(|e| &e.others);
        let found = extensions.and_then(|e| NAMES.iter().find_map(|name| Some((*name, e.get(*name)?))));
        let Some((name, value)) = found else { continue };
        control.check()?;
        let place = format!("/bufferViews/{i}/extensions/{name}");
        let stated = view.byte_length.0;
        match decode_view(value, buffers, stated, &mut allowance, limits, &place) {
            Ok(bytes) => {
                decoded.insert(i, bytes);
            }
            Err(error) if buffers.bytes(view.buffer.value()).is_some() && error.code == ErrorCode::Invalid => {
                let message = format!("{}; the uncompressed fallback is used", error.message);
                report.warn("fallback-used", place, message);
            }
            Err(error) => return Err(error),
        }
    }
    Ok(decoded)
}

fn decode_view(
    value: &serde_json::Value,
    buffers: &Buffers,
    stated: u64,
    allowance: &mut u64,
    limits: &Limits,
    place: &str,
) -> Result<Vec<u8>, ImportError> {
    let wrong = |message: String| invalid(place, message);
    let e = Extension::deserialize(value).map_err(|e| wrong(e.to_string()))?;
    let sizes = match e.mode {
        Mode::Attributes => e.byte_stride.is_multiple_of(4) && (4..=256).contains(&e.byte_stride),
        Mode::Triangles | Mode::Indices => e.byte_stride == 2 || e.byte_stride == 4,
    };
    let filtered = match e.filter {
        Filter::None => true,
        Filter::Octahedral | Filter::Color => e.byte_stride == 4 || e.byte_stride == 8,
        Filter::Quaternion => e.byte_stride == 8,
        Filter::Exponential => e.byte_stride.is_multiple_of(4),
    };
    if !sizes || !filtered || (e.mode != Mode::Attributes && e.filter != Filter::None) {
        return Err(wrong(format!("the mode or filter does not go with a stride of {} bytes", e.byte_stride)));
    }
    if e.mode == Mode::Triangles && !e.count.is_multiple_of(3) {
        return Err(wrong(format!("{} corners are no whole triangles", e.count)));
    }
    let size = e.count.checked_mul(e.byte_stride as u64).filter(|size| *size == stated).ok_or_else(|| {
        wrong(format!("{} elements of {} bytes do not make up the view's {stated}", e.count, e.byte_stride))
    })?;
    let start = usize::try_from(e.byte_offset).ok();
    let end = e.byte_offset.checked_add(e.byte_length).and_then(|end| usize::try_from(end).ok());
    let stream = start.zip(end).and_then(|(start, end)| buffers.bytes(e.buffer)?.get(start..end));
    let Some(stream) = stream else {
        let message = format!("{} bytes from {} on lie outside buffer {}", e.byte_length, e.byte_offset, e.buffer);
        return Err(wrong(message));
    };
    *allowance = allowance.saturating_add((stream.len() as u64).saturating_mul(BYTES_PER_BYTE));
    *allowance = allowance.checked_sub(size).filter(|_| size <= limits.max_file_bytes).ok_or_else(|| {
        let message = format!("{} bytes that claim to hold {size} are out of proportion", stream.len());
        ImportError::new(ErrorCode::TooLarge, message).at(Place::Json(place.into()))
    })?;
    let count = usize::try_from(e.count).map_err(|_| wrong("there are too many elements".into()))?;
    // The decoder refuses index streams of less than a byte an element before it touches the output, but the output
    // is allocated first; so the same rule here.
    let least = if e.mode == Mode::Triangles { count / 3 } else { count };
    if e.mode != Mode::Attributes && stream.len() < least {
        return Err(wrong(format!("{} bytes cannot hold {count} indices", stream.len())));
    }
    let decoded = match (e.mode, e.byte_stride) {
        (Mode::Attributes, stride) => vertices(stream, count, stride),
        (Mode::Triangles, 2) => meshopt::decode_index_buffer(stream, count).ok().map(|v| bytes(&v, u16::to_le_bytes)),
        (Mode::Triangles, _) => meshopt::decode_index_buffer(stream, count).ok().map(|v| bytes(&v, u32::to_le_bytes)),
        (Mode::Indices, 2) => meshopt::decode_index_sequence(stream, count).ok().map(|v| bytes(&v, u16::to_le_bytes)),
        (Mode::Indices, _) => meshopt::decode_index_sequence(stream, count).ok().map(|v| bytes(&v, u32::to_le_bytes)),
    };
    let decoded = decoded.ok_or_else(|| wrong(format!("the stream of {} bytes is not sound", stream.len())))?;
    Ok(unfilter(decoded, e.filter, e.byte_stride))
}

fn bytes<T: Copy, const S: usize>(values: &[T], write: impl Fn(T) -> [u8; S]) -> Vec<u8> {
    values.iter().flat_map(|v| write(*v)).collect()
}

/// A vertex of `N` words: a type of the size that the decoder is told of by its type alone.
#[derive(Clone, Copy)]
struct Vertex<const N: usize>([[u8; 4]; N]);

impl<const N: usize> Default for Vertex<N> {
    fn default() -> Self {
        Self([[0; 4]; N])
    }
}

fn words<const N: usize>(stream: &[u8], count: usize) -> Option<Vec<u8>> {
    let vertices: Vec<Vertex<N>> = meshopt::decode_vertex_buffer(stream, count).ok()?;
    let mut bytes = Vec::with_capacity(count * N * 4);
    vertices.iter().for_each(|v| bytes.extend_from_slice(v.0.as_flattened()));
    Some(bytes)
}

/// Vertices of `stride` bytes, a multiple of 4 up to 256.
fn vertices(stream: &[u8], count: usize, stride: usize) -> Option<Vec<u8>> {
    macro_rules! by_words {
        ($($n:literal)*) => {
            match stride / 4 {
                $($n => words::<$n>(stream, count),)*
                _ => None,
            }
        };
    }
    by_words!(1 2 3 4 5 6 7 8 9 10 11 12 13 14 15 16 17 18 19 20 21 22 23 24 25 26 27 28 29 30 31 32
        33 34 35 36 37 38 39 40 41 42 43 44 45 46 47 48 49 50 51 52 53 54 55 56 57 58 59 60 61 62 63 64)
}

/// Undoes a filter on elements of `stride` bytes, which goes with the filter.
fn unfilter(data: Vec<u8>, filter: Filter, stride: usize) -> Vec<u8> {
    let small = || data.as_chunks::<4>().0.to_vec();
    let wide = || data.as_chunks::<2>().0.iter().map(|b| u16::from_le_bytes(*b)).collect::<Vec<u16>>();
    match (filter, stride) {
        (Filter::None, _) => data,
        (Filter::Octahedral, 4) => {
            let mut values: Vec<[i8; 4]> = small().iter().map(|v| v.map(u8::cast_signed)).collect();
            meshopt::decode_filter_oct(&mut values);
            values.iter().flatten().map(|x| x.cast_unsigned()).collect()
        }
        (Filter::Octahedral | Filter::Quaternion, _) => {
            let mut values: Vec<[i16; 4]> = wide().as_chunks::<4>().0.iter().map(|v| v.map(u16::cast_signed)).collect();
            match filter {
                Filter::Octahedral => meshopt::decode_filter_oct(&mut values),
                _ => meshopt::decode_filter_quat(&mut values),
            }
            bytes(values.as_flattened(), i16::to_le_bytes)
        }
        (Filter::Exponential, _) => {
            let mut values: Vec<[u32; 1]> = data.as_chunks::<4>().0.iter().map(|b| [u32::from_le_bytes(*b)]).collect();
            meshopt::decode_filter_exp(&mut values);
            bytes(values.as_flattened(), u32::to_le_bytes)
        }
        (Filter::Color, 4) => {
            let mut values = small();
            meshopt::decode_filter_color(&mut values);
            values.into_flattened()
        }
        (Filter::Color, _) => {
            let mut values = wide().as_chunks::<4>().0.to_vec();
            meshopt::decode_filter_color(&mut values);
            bytes(values.as_flattened(), u16::to_le_bytes)
        }
    }
}
