//! Accessors: typed, strided, normalised and sparse arrays in buffers.

use super::buffers::Buffers;
use super::document::invalid;
use super::layout::{Layout, extent};
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

    /// Refuses an accessor that claims far more elements than the file stores, so that nothing is allocated on its
    /// mere word. For those whose count nothing else in the file bears out.
    ///
    /// # Errors
    /// [`ErrorCode::Invalid`] at the accessor's count.
    pub(super) fn check_backed(&self, index: usize, from: &dyn Fn() -> String) -> Result<(), ImportError> {
        let count = self.count(index, from)?;
        let accessor = self.root.accessors.get(index).filter(|a| a.buffer_view.is_none());
        let Some(accessor) = accessor else { return Ok(()) };
        let stored = accessor.sparse.as_ref().map_or(0, |s| usize::try_from(s.count.0).unwrap_or(usize::MAX));
        if count <= stored.saturating_mul(16).saturating_add(UNBACKED_ELEMENTS) {
            return Ok(());
        }
        Err(invalid(format!("/accessors/{index}/count"), format!("claims {count} elements and stores {stored}")))
    }

    /// The largest number that an accessor of unsigned integers can hold.
    pub(super) fn largest(&self, index: usize) -> Option<u32> {
        match self.root.accessors.get(index)?.component_type {
            Checked::Valid(component) => match component.0 {
                ComponentType::U8 => Some(u8::MAX.into()),
                ComponentType::U16 => Some(u16::MAX.into()),
                ComponentType::U32 => Some(u32::MAX),
                _ => None,
            },
            Checked::Invalid => None,
        }
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

    /// Reads joint numbers. Some exporters write them as floats.
    ///
    /// # Errors
    /// As [`Accessors::integers`].
    pub(super) fn joints(
        &self,
        index: usize,
        select: Option<&[u32]>,
        from: &dyn Fn() -> String,
    ) -> Result<Vec<[u32; 4]>, ImportError> {
        let (_, component, _) = self.get(index, from)?;
        if component != ComponentType::F32 {
            return self.integers(index, select, from);
        }
        let whole = |x: f32| if x >= 0.0 && x.fract() == 0.0 { x as u32 } else { u32::MAX };
        Ok(self.floats::<4>(index, select, from)?.into_iter().map(|joints| joints.map(whole)).collect())
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
            // The callers see to it that no more is claimed than the file has data for: `Accessors::check_backed`.
            None => vec![zero; select.map_or(count, <[u32]>::len)],
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
        let index = view.value();
        let view = self.buffers.view(self.root, view, from)?;
        let stride = view.stride.unwrap_or(size);
        let (start, end) = extent(index, view.bytes.len(), stride, offset, count, size, from)?;
        Ok(Layout { bytes: view.bytes.get(start..end).unwrap_or_default(), stride, count })
    }

    /// Checks the references and stated ranges of every buffer view and accessor, used or not: one that does not fit
    /// tells of a damaged file. Placeholder buffers without data pass; they are an error for those only who read them.
    ///
    /// # Errors
    /// [`ErrorCode::Invalid`] at the JSON pointer of what does not fit.
    pub(super) fn check_all(&self) -> Result<(), ImportError> {
        for (i, view) in self.root.buffer_views.iter().enumerate() {
            Buffers::check_view(self.root, view, i)?;
        }
        for (i, accessor) in self.root.accessors.iter().enumerate() {
            let (Checked::Valid(component), Checked::Valid(kind)) = (accessor.component_type, accessor.type_) else {
                continue;
            };
            let pointer = |name: &str| format!("/accessors/{i}/{name}");
            let size = component.0.size() * kind.multiplicity();
            let count = self.count(i, &|| pointer("count"))?;
            if let Some(view) = accessor.buffer_view {
                let offset = accessor.byte_offset.map_or(0, |o| o.0);
                self.check_range(view, offset, count, size, &|| pointer("bufferView"))?;
            }
            let Some(sparse) = &accessor.sparse else { continue };
            let stored = usize::try_from(sparse.count.0)
                .ok()
                .filter(|n| *n <= count)
                .ok_or_else(|| invalid(pointer("sparse/count"), format!("{} of {count} elements", sparse.count.0)))?;
            if let Checked::Valid(index) = sparse.indices.component_type {
                let (view, offset) = (sparse.indices.buffer_view, sparse.indices.byte_offset.0);
                self.check_range(view, offset, stored, index.0.size(), &|| pointer("sparse/indices"))?;
            }
            let (view, offset) = (sparse.values.buffer_view, sparse.values.byte_offset.0);
            self.check_range(view, offset, stored, size, &|| pointer("sparse/values"))?;
        }
        Ok(())
    }

    fn check_range(
        &self,
        view: json::Index<json::buffer::View>,
        offset: u64,
        count: usize,
        size: usize,
        from: &dyn Fn() -> String,
    ) -> Result<(), ImportError> {
        let views = &self.root.buffer_views;
        let Some(found) = views.get(view.value()) else {
            return Err(invalid(from(), format!("buffer view {view} of {}", views.len())));
        };
        let len = usize::try_from(found.byte_length.0).unwrap_or(usize::MAX);
        let stride = found.byte_stride.map_or(size, |s| s.0);
        extent(view.value(), len, stride, offset, count, size, from).map(|_| ())
    }
}
