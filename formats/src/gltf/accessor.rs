//! Accessors: typed, strided, normalised and sparse arrays in buffers.

use super::buffers::Buffers;
use super::document::invalid;
use crate::{ErrorCode, ImportError, Place};
use gltf::json;
use gltf::json::accessor::{ComponentType, Type};
use gltf::json::validation::Checked;

/// Elements that an accessor without data may claim beyond 16 times those that it stores sparsely.
const UNBACKED_ELEMENTS: usize = 1 << 16;

/// Reads accessors of one document.
#[derive(Clone, Copy)]
pub(super) struct Accessors<'a> {
    pub(super) root: &'a json::Root,
    pub(super) buffers: &'a Buffers,
}

/// Equally spaced elements; each lies wholly within `bytes`.
struct Layout<'a> {
    bytes: &'a [u8],
    stride: usize,
    count: usize,
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

    fn floats<const N: usize>(
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

    fn integers<const N: usize>(&self, kind: ComponentType, select: Option<&[u32]>) -> Option<Vec<[u32; N]>> {
        Some(match kind {
            ComponentType::U8 => self.read(select, |[b]: [u8; 1]| u32::from(b)),
            ComponentType::U16 => self.read(select, |b| u32::from(u16::from_le_bytes(b))),
            ComponentType::U32 => self.read(select, u32::from_le_bytes),
            _ => return None,
        })
    }
}

type Element<'a> = (&'a json::Accessor, ComponentType, Type);

impl<'a> Accessors<'a> {
    fn get(&self, index: usize, from: &dyn Fn() -> String) -> Result<Element<'a>, ImportError> {
        let accessors = &self.root.accessors;
        let Some(accessor) = accessors.get(index) else {
            return Err(invalid(from(), format!("accessor {index} of {}", accessors.len())));
        };
        let Checked::Valid(component) = accessor.component_type else {
            return Err(invalid(format!("/accessors/{index}/componentType"), "is no component type"));
        };
        let Checked::Valid(kind) = accessor.type_ else {
            return Err(invalid(format!("/accessors/{index}/type"), "is no accessor type"));
        };
        Ok((accessor, component.0, kind))
    }

    /// Number of elements. `from` is the JSON pointer of the reference to the accessor.
    ///
    /// # Errors
    /// [`ErrorCode::Invalid`] for wrong indices, [`ErrorCode::TooLarge`] when nothing could hold as many.
    pub(super) fn count(&self, index: usize, from: &dyn Fn() -> String) -> Result<usize, ImportError> {
        let (accessor, ..) = self.get(index, from)?;
        u32::try_from(accessor.count.0).map(|n| n as usize).map_err(|_| {
            let message = format!("{} elements are more than indices can name", accessor.count.0);
            ImportError::new(ErrorCode::TooLarge, message).at(Place::Json(format!("/accessors/{index}/count")))
        })
    }

    /// Whether the accessor is all zeros by its own account: no buffer view, nothing sparse.
    pub(super) fn is_blank(&self, index: usize) -> bool {
        self.root.accessors.get(index).is_some_and(|a| a.buffer_view.is_none() && a.sparse.is_none())
    }

    /// Whether the elements have so many components.
    pub(super) fn has_components(&self, index: usize, n: usize) -> bool {
        let kind = self.root.accessors.get(index).map(|a| a.type_);
        matches!(kind, Some(Checked::Valid(kind)) if kind.multiplicity() == n)
    }

    /// Reads numbers as floats, normalised where the accessor says so: all of them, or those that the sorted list
    /// `select` names.
    ///
    /// # Errors
    /// [`ErrorCode::Invalid`] at the JSON pointer of what does not fit: another type than `N` components, a range
    /// outside its buffer view, sparse indices out of range, ….
    pub(super) fn floats<const N: usize>(
        &self,
        index: usize,
        select: Option<&[u32]>,
        from: &dyn Fn() -> String,
    ) -> Result<Vec<[f32; N]>, ImportError> {
        let (accessor, component, kind) = self.get(index, from)?;
        let normalized = accessor.normalized;
        self.read(index, (accessor, component, kind), select, [0.0; N], |layout, select| {
            layout.floats(component, normalized, select)
        })
    }

    /// Reads unsigned integers, as [`Accessors::floats`] does.
    ///
    /// # Errors
    /// As [`Accessors::floats`]; floats and signed integers are [`ErrorCode::Invalid`].
    pub(super) fn integers<const N: usize>(
        &self,
        index: usize,
        select: Option<&[u32]>,
        from: &dyn Fn() -> String,
    ) -> Result<Vec<[u32; N]>, ImportError> {
        let (accessor, component, kind) = self.get(index, from)?;
        self.read(index, (accessor, component, kind), select, [0; N], |layout, select| {
            layout.integers(component, select)
        })
    }

    fn read<const N: usize, T: Copy>(
        &self,
        index: usize,
        (accessor, component, kind): Element<'a>,
        select: Option<&[u32]>,
        zero: [T; N],
        decode: impl Fn(&Layout<'a>, Option<&[u32]>) -> Option<Vec<[T; N]>>,
    ) -> Result<Vec<[T; N]>, ImportError> {
        let pointer = || format!("/accessors/{index}");
        let square = matches!(kind, Type::Mat2 | Type::Mat3 | Type::Mat4);
        if kind.multiplicity() != N || square != (N == 16) {
            return Err(invalid(format!("{}/type", pointer()), format!("{kind:?} where {N} components are needed")));
        }
        let misfit = || invalid(format!("{}/componentType", pointer()), format!("{component:?} cannot be used here"));
        let size = component.size() * N;
        let count = self.count(index, &pointer)?;
        let mut values = match accessor.buffer_view {
            Some(view) => {
                let offset = accessor.byte_offset.map_or(0, |o| o.0);
                let layout = self.layout(view, offset, count, size, &|| format!("{}/bufferView", pointer()))?;
                decode(&layout, select).ok_or_else(misfit)?
            }
            None => {
                let stored = accessor.sparse.as_ref().map_or(0, |s| usize::try_from(s.count.0).unwrap_or(usize::MAX));
                let len = select.map_or(count, <[u32]>::len);
                if len > stored.saturating_mul(16).saturating_add(UNBACKED_ELEMENTS) {
                    let message = format!("claims {count} elements and stores {stored}");
                    return Err(invalid(format!("{}/count", pointer()), message));
                }
                vec![zero; len]
            }
        };
        let Some(sparse) = &accessor.sparse else {
            return Ok(values);
        };
        let stored = usize::try_from(sparse.count.0).ok().filter(|n| *n <= count).ok_or_else(|| {
            invalid(format!("{}/sparse/count", pointer()), format!("{} of {count} elements", sparse.count.0))
        })?;
        let indices_at = || format!("{}/sparse/indices", pointer());
        let Checked::Valid(index_type) = sparse.indices.component_type else {
            return Err(invalid(format!("{}/componentType", indices_at()), "is no index type"));
        };
        let offset = sparse.indices.byte_offset.0;
        let size_of_index = index_type.0.size();
        let layout = self.layout(sparse.indices.buffer_view, offset, stored, size_of_index, &indices_at)?;
        let indices = layout.integers::<1>(index_type.0, None).ok_or_else(misfit)?;
        let values_at = || format!("{}/sparse/values", pointer());
        let layout = self.layout(sparse.values.buffer_view, sparse.values.byte_offset.0, stored, size, &values_at)?;
        let replacements = decode(&layout, None).ok_or_else(misfit)?;
        for ([i], replacement) in indices.into_iter().zip(replacements) {
            if i as usize >= count {
                return Err(invalid(indices_at(), format!("index {i} of {count}")));
            }
            let slot = select.map_or(Some(i as usize), |list| list.binary_search(&i).ok());
            if let Some(value) = slot.and_then(|slot| values.get_mut(slot)) {
                *value = replacement;
            }
        }
        Ok(values)
    }

    /// `count` elements of `size` bytes from `offset` within a buffer view.
    fn layout(
        &self,
        view: json::Index<json::buffer::View>,
        offset: u64,
        count: usize,
        size: usize,
        from: &dyn Fn() -> String,
    ) -> Result<Layout<'a>, ImportError> {
        let view_index = view.value();
        let view = self.buffers.view(self.root, view, from)?;
        let stride = view.stride.unwrap_or(size);
        if stride < size {
            let message = format!("{stride} bytes are less than an element's {size}");
            return Err(invalid(format!("/bufferViews/{view_index}/byteStride"), message));
        }
        let len = match count {
            0 => Some(0),
            n => (n - 1).checked_mul(stride).and_then(|l| l.checked_add(size)),
        };
        let start = usize::try_from(offset).ok();
        let bytes = start.zip(len).and_then(|(start, len)| view.bytes.get(start..start.checked_add(len)?)).ok_or_else(
            || {
                let available = view.bytes.len();
                invalid(from(), format!("{count} elements from byte {offset} lie outside the view's {available} bytes"))
            },
        )?;
        Ok(Layout { bytes, stride, count })
    }

    /// Checks every accessor's references and ranges, used or not: one that does not fit tells of a damaged file.
    ///
    /// # Errors
    /// [`ErrorCode::Invalid`] at the JSON pointer of what does not fit.
    pub(super) fn check_all(&self) -> Result<(), ImportError> {
        let absent = |view: &json::Index<json::buffer::View>| {
            let view = self.root.buffer_views.get(view.value());
            view.is_some_and(|v| {
                self.root.buffers.len() > v.buffer.value() && self.buffers.bytes(v.buffer.value()).is_none()
            })
        };
        for i in 0..self.root.buffer_views.len() {
            let view = json::Index::new(u32::try_from(i).unwrap_or(u32::MAX));
            // Placeholders are an error for those only who read them.
            if !absent(&view) {
                self.buffers.view(self.root, view, &|| format!("/bufferViews/{i}"))?;
            }
        }
        for (i, accessor) in self.root.accessors.iter().enumerate() {
            let (Checked::Valid(component), Checked::Valid(kind)) = (accessor.component_type, accessor.type_) else {
                continue;
            };
            if let Some(view) = accessor.buffer_view.filter(|v| !absent(v)) {
                let pointer = || format!("/accessors/{i}");
                let size = component.0.size() * kind.multiplicity();
                let offset = accessor.byte_offset.map_or(0, |o| o.0);
                let count = self.count(i, &pointer)?;
                self.layout(view, offset, count, size, &|| format!("{}/bufferView", pointer()))?;
            }
        }
        Ok(())
    }
}
