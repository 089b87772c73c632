//! KHR_draco_mesh_compression: primitives decoded by the `draco-core` crate into accessors of their own.

use super::buffers::Buffers;
use super::document::invalid;
use super::report::Report;
use crate::{Control, ErrorCode, ImportError, Limits, Place};
use draco_core::geometry_indices::PointIndex;
use draco_core::{DataType, DecodeLimits, DecoderBuffer, Mesh, MeshDecoder, PointAttribute};
use gltf::json;
use gltf::json::accessor::{ComponentType, GenericComponentType, Type};
use gltf::json::mesh::Mode;
use gltf::json::validation::{Checked, USize64};
use serde::Deserialize;
use std::collections::{BTreeMap, BTreeSet};
use std::panic::{AssertUnwindSafe, catch_unwind};

/// The extension's name.
pub(super) const NAME: &str = "KHR_draco_mesh_compression";

/// Decoded bytes that need no justification by the size of the stream, and how many each of its bytes justifies.
/// Constant attributes take no room in a stream, so real ones reach ratios of some hundreds.
const FREE_BYTES: u64 = 128 << 20;
const BYTES_PER_BYTE: u64 = 256;

#[derive(Clone, Deserialize)]
#[serde(rename_all = "camelCase")]
struct Extension {
    buffer_view: u32,
    attributes: BTreeMap<String, u32>,
}

/// Decodes the compressed primitives of the meshes that the nodes `shown` name, and points the primitives to new
/// accessors with the data. A primitive whose stream is broken and that has uncompressed data keeps these.
///
/// # Errors
/// [`ErrorCode::Invalid`] at the JSON pointer of a stream or description that does not fit, [`ErrorCode::TooLarge`]
/// by `limits`; [`ErrorCode::Stopped`].
pub(super) fn expand(
    root: &mut json::Root,
    buffers: &mut Buffers,
    shown: &[usize],
    limits: &Limits,
    report: &mut Report,
    control: &Control,
) -> Result<(), ImportError> {
    let meshes: BTreeSet<usize> = shown.iter().filter_map(|n| Some(root.nodes.get(*n)?.mesh?.value())).collect();
    // Primitives may share a stream; it is decoded once for each set of attributes asked of it.
    let mut known = BTreeMap::<_, Decoded>::new();
    let mut left = Allowance { triangles: limits.max_triangles, bytes: FREE_BYTES };
    for m in meshes {
        for p in 0..root.meshes.get(m).map_or(0, |mesh| mesh.primitives.len()) {
            let Some(primitive) = root.meshes.get(m).and_then(|mesh| mesh.primitives.get(p)) else { continue };
            let Some(value) = primitive.extensions.as_ref().and_then(|e| e.others.get(NAME)) else { continue };
            control.check()?;
            let at = format!("/meshes/{m}/primitives/{p}");
            let place = format!("{at}/extensions/{NAME}");
            let parsed = Extension::deserialize(value).map_err(|e| invalid(place.as_str(), e.to_string()));
            let wanted = parsed.map(|e| (e.buffer_view, wanted(primitive, &e)));
            let decoded = wanted.and_then(|key| match known.get(&key) {
                Some(decoded) => Ok(decoded.clone()),
                None => {
                    let decoded = decode(root, buffers, &key.1, key.0, &mut left, &place)?;
                    Ok(known.entry(key).or_insert(decoded).clone())
                }
            });
            match decoded {
                Ok(decoded) => apply(root, (m, p), &decoded),
                Err(error) if error.code == ErrorCode::Invalid && has_fallback(root, (m, p)) => {
                    let message = format!("{}; the uncompressed fallback is used", error.message);
                    report.warn("fallback-used", place, message);
                }
                Err(error) => return Err(error),
            }
        }
    }
    Ok(())
}

struct Allowance {
    triangles: u64,
    bytes: u64,
}

/// Accessors that hold a decoded stream: the corners, and the attributes by name.
#[derive(Clone)]
struct Decoded {
    indices: json::Index<json::Accessor>,
    attributes: Vec<(String, json::Index<json::Accessor>)>,
}

/// The attributes that the primitive and the stream have in common: name, number in the stream, accessor.
fn wanted(primitive: &json::mesh::Primitive, extension: &Extension) -> Vec<(String, u32, usize)> {
    let named = primitive.attributes.iter().filter_map(|(semantic, accessor)| match semantic {
        Checked::Valid(semantic) => Some((semantic.to_string(), accessor.value())),
        Checked::Invalid => None,
    });
    named.filter_map(|(name, accessor)| Some((name.clone(), *extension.attributes.get(&name)?, accessor))).collect()
}

fn has_fallback(root: &json::Root, (m, p): (usize, usize)) -> bool {
    let primitive = root.meshes.get(m).and_then(|mesh| mesh.primitives.get(p));
    let position = primitive.and_then(|p| p.attributes.get(&Checked::Valid(json::mesh::Semantic::Positions)));
    position.and_then(|a| root.accessors.get(a.value())).is_some_and(|a| a.buffer_view.is_some())
}

fn apply(root: &mut json::Root, (m, p): (usize, usize), decoded: &Decoded) {
    let Some(primitive) = root.meshes.get_mut(m).and_then(|mesh| mesh.primitives.get_mut(p)) else { return };
    // Draco knows whole triangles only; strips are for those who feed a graphics card.
    primitive.mode = Checked::Valid(Mode::Triangles);
    primitive.indices = Some(decoded.indices);
    for (semantic, accessor) in &mut primitive.attributes {
        let Checked::Valid(semantic) = semantic else { continue };
        let name = semantic.to_string();
        if let Some((_, own)) = decoded.attributes.iter().find(|(n, _)| *n == name) {
            *accessor = *own;
        }
    }
}

fn decode(
    root: &mut json::Root,
    buffers: &mut Buffers,
    wanted: &[(String, u32, usize)],
    view: u32,
    left: &mut Allowance,
    place: &str,
) -> Result<Decoded, ImportError> {
    let stream = buffers.view(root, json::Index::new(view), &|| format!("{place}/bufferView"))?.bytes;
    left.bytes = left.bytes.saturating_add((stream.len() as u64).saturating_mul(BYTES_PER_BYTE));
    let mesh = decode_stream(stream, left).map_err(|e| e.at(Place::Json(place.into())))?;
    let points = mesh.num_points();
    let corners: Vec<u32> = mesh.faces().iter().flatten().map(|corner| corner.0).collect();
    let bytes = corners.iter().flat_map(|i| i.to_le_bytes()).collect();
    left.triangles = left.triangles.saturating_sub(mesh.num_faces() as u64);
    let mut read = Vec::new();
    for (name, id, accessor) in wanted {
        let pointer = || format!("{place}/attributes/{name}");
        let attribute = mesh
            .attribute_by_unique_id(*id)
            .ok_or_else(|| invalid(pointer(), format!("the stream has no attribute {id}")))?;
        let stated = root
            .accessors
            .get(*accessor)
            .ok_or_else(|| invalid(pointer(), format!("accessor {accessor} of {}", root.accessors.len())))?;
        let components = usize::from(attribute.num_components());
        let fits = matches!(stated.type_, Checked::Valid(kind) if kind.multiplicity() == components);
        if !fits {
            return Err(invalid(pointer(), format!("the stream has {components} components, the accessor has not")));
        }
        let size = (points * components * 4) as u64;
        left.bytes = left.bytes.checked_sub(size).ok_or_else(|| out_of_proportion().at(Place::Json(pointer())))?;
        let (component, bytes) = values(attribute, points, stated);
        let float = matches!(stated.component_type, Checked::Valid(GenericComponentType(ComponentType::F32)));
        let normalized = if float { attribute.normalized() } else { stated.normalized };
        let accessor = json::Accessor { normalized, ..accessor_of(component, points, stated.type_) };
        read.push((name.clone(), accessor, bytes));
    }
    let indices = accessor_of(ComponentType::U32, corners.len(), Checked::Valid(Type::Scalar));
    let indices = store(root, buffers, indices, bytes);
    let attributes = read.into_iter().map(|(name, accessor, bytes)| (name, store(root, buffers, accessor, bytes)));
    Ok(Decoded { indices, attributes: attributes.collect() })
}

fn out_of_proportion() -> ImportError {
    ImportError::new(ErrorCode::TooLarge, "the Draco stream holds more than its size and the limits allow")
}

/// Decodes a stream to triangles whose corners name points that exist.
fn decode_stream(stream: &[u8], left: &Allowance) -> Result<Mesh, ImportError> {
    let wrong = |message: String| ImportError::new(ErrorCode::Invalid, message);
    let limits = DecodeLimits::default()
        .with_max_faces(left.triangles)
        .with_max_points(left.triangles.saturating_mul(3))
        .with_max_decoded_bytes(left.bytes);
    // The decoder is young: should it panic, then the stream is at fault as far as the user is concerned.
    let decoded = catch_unwind(AssertUnwindSafe(|| {
        let mut mesh = Mesh::new();
        MeshDecoder::new().decode(&mut DecoderBuffer::new(stream).with_limits(limits), &mut mesh).map(|()| mesh)
    }));
    let mesh = match decoded {
        Ok(Ok(mesh)) => mesh,
        Ok(Err(error)) if error.kind() == draco_core::ErrorKind::LimitExceeded => return Err(out_of_proportion()),
        Ok(Err(error)) => return Err(wrong(format!("the Draco stream is not sound: {error}"))),
        Err(_) => return Err(wrong("the Draco stream is not sound: its decoder panicked".into())),
    };
    let points = mesh.num_points();
    if mesh.faces().iter().flatten().any(|corner| corner.0 as usize >= points) {
        return Err(wrong(format!("the Draco stream names points beyond its {points}")));
    }
    Ok(mesh)
}

/// The values of all points, as stored where glTF has such a type, else as floats.
fn values(attribute: &PointAttribute, points: usize, stated: &json::Accessor) -> (ComponentType, Vec<u8>) {
    let integer = matches!(stated.component_type, Checked::Valid(c) if c.0 != ComponentType::F32);
    let component = match attribute.data_type() {
        DataType::Int8 => ComponentType::I8,
        DataType::Uint8 => ComponentType::U8,
        DataType::Int16 => ComponentType::I16,
        DataType::Uint16 => ComponentType::U16,
        DataType::Uint32 if integer => ComponentType::U32,
        _ => {
            let floats = attribute.read_f32s(points, usize::from(attribute.num_components()));
            return (ComponentType::F32, floats.iter().flat_map(|x| x.to_le_bytes()).collect());
        }
    };
    let size = component.size() * usize::from(attribute.num_components());
    let stride = usize::try_from(attribute.byte_stride()).unwrap_or(size);
    let data = attribute.buffer().data();
    let mut bytes = vec![0; points * size];
    for (point, out) in bytes.chunks_exact_mut(size.max(1)).enumerate() {
        let value = attribute.mapped_index(PointIndex(point as u32)).0 as usize;
        let start = value.checked_mul(stride);
        let stored = start.and_then(|start| data.get(start..start.checked_add(size)?));
        if let Some(stored) = stored {
            out.copy_from_slice(stored);
        }
    }
    (component, bytes)
}

fn accessor_of(component: ComponentType, count: usize, kind: Checked<Type>) -> json::Accessor {
    json::Accessor {
        buffer_view: None,
        byte_offset: None,
        count: USize64(count as u64),
        component_type: Checked::Valid(GenericComponentType(component)),
        extensions: None,
        extras: None,
        type_: kind,
        min: None,
        max: None,
        name: None,
        normalized: false,
        sparse: None,
    }
}

/// Adds a buffer, a view of it and an accessor of that.
fn store(
    root: &mut json::Root,
    buffers: &mut Buffers,
    accessor: json::Accessor,
    bytes: Vec<u8>,
) -> json::Index<json::Accessor> {
    let byte_length = USize64(bytes.len() as u64);
    buffers.push(bytes);
    let buffer = json::Buffer { byte_length, name: None, uri: None, extensions: None, extras: None };
    let view = json::buffer::View {
        buffer: root.push(buffer),
        byte_length,
        byte_offset: None,
        byte_stride: None,
        name: None,
        target: None,
        extensions: None,
        extras: None,
    };
    let view = root.push(view);
    root.push(json::Accessor { buffer_view: Some(view), ..accessor })
}
