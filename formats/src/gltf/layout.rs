//! Equally spaced elements in bytes, and their decoding.

use super::document::invalid;
use crate::ImportError;
use gltf::json::accessor::ComponentType;

/// Equally spaced elements; each lies wholly within `bytes`.
pub(super) struct Layout<'a> {
    pub(super) bytes: &'a [u8],
    pub(super) stride: usize,
    pub(super) count: usize,
}

impl Layout<'_> {
    /// Element `i` of `N` components of `S` bytes.
    fn get<const S: usize, const N: usize>(&self, i: usize) -> [[u8; S]; N] {
        let at = self.bytes.get(i.saturating_mul(self.stride)..).unwrap_or_default();
        at.as_chunks().0.first_chunk().copied().unwrap_or([[0; S]; N])
    }

    fn read<const S: usize, const N: usize, T: Copy>(
        &self,
        select: Option<&[u32]>,
        decode: impl Fn([u8; S]) -> T,
    ) -> Vec<[T; N]> {
        match select {
            Some(list) => list.iter().map(|i| self.get(*i as usize).map(&decode)).collect(),
            // Tightly packed: one straight pass over the bytes.
            None if self.stride == S * N => {
                self.bytes.as_chunks().0.as_chunks().0.iter().take(self.count).map(|e| e.map(&decode)).collect()
            }
            None => (0..self.count).map(|i| self.get(i).map(&decode)).collect(),
        }
    }

    /// The elements that the list `select` names, or all, as floats; `None` for 32-bit integers.
    pub(super) fn floats<const N: usize>(
        &self,
        kind: ComponentType,
        normalized: bool,
        select: Option<&[u32]>,
    ) -> Option<Vec<[f32; N]>> {
        // glTF 2.0, 3.6.2.2: normalised integers are c / max, and signed ones at least −1.
        let signed = |x: f32, max: f32| if normalized { (x / max).max(-1.0) } else { x };
        let unsigned = |x: f32, max: f32| if normalized { x / max } else { x };
        Some(match kind {
            ComponentType::F32 => self.read(select, f32::from_le_bytes),
            ComponentType::I8 => self.read(select, |b| signed(f32::from(i8::from_le_bytes(b)), 127.0)),
            ComponentType::U8 => self.read(select, |b| unsigned(f32::from(u8::from_le_bytes(b)), 255.0)),
            ComponentType::I16 => self.read(select, |b| signed(f32::from(i16::from_le_bytes(b)), 32767.0)),
            ComponentType::U16 => self.read(select, |b| unsigned(f32::from(u16::from_le_bytes(b)), 65535.0)),
            ComponentType::U32 => return None,
        })
    }

    /// The elements that the list `select` names, or all; `None` unless they are unsigned integers.
    pub(super) fn integers<const N: usize>(
        &self,
        kind: ComponentType,
        select: Option<&[u32]>,
    ) -> Option<Vec<[u32; N]>> {
        Some(match kind {
            ComponentType::U8 => self.read(select, |[b]: [u8; 1]| u32::from(b)),
            ComponentType::U16 => self.read(select, |b| u32::from(u16::from_le_bytes(b))),
            ComponentType::U32 => self.read(select, u32::from_le_bytes),
            _ => return None,
        })
    }
}

/// Where in a view of `len` bytes `count` elements of `size` bytes, `stride` apart from `offset` on, begin and end.
///
/// # Errors
/// [`crate::ErrorCode::Invalid`] for a stride under `size` and for elements outside the view.
pub(super) fn extent(
    view: usize,
    len: usize,
    stride: usize,
    offset: u64,
    count: usize,
    size: usize,
    from: &dyn Fn() -> String,
) -> Result<(usize, usize), ImportError> {
    if stride < size {
        let message = format!("{stride} bytes are less than an element's {size}");
        return Err(invalid(format!("/bufferViews/{view}/byteStride"), message));
    }
    let bytes = match count {
        0 => Some(0),
        n => (n - 1).checked_mul(stride).and_then(|l| l.checked_add(size)),
    };
    let start = usize::try_from(offset).ok();
    let end = start.zip(bytes).and_then(|(start, bytes)| start.checked_add(bytes)).filter(|end| *end <= len);
    start.zip(end).ok_or_else(|| {
        invalid(from(), format!("{count} elements from byte {offset} on lie outside the view's {len} bytes"))
    })
}
