//! From the sound text to meshes, through `tobj`.

use super::scan::{Part, Scan};
use super::smooth::smooth;
use crate::repair::triangulate::Triangulator;
use crate::scene::Mesh;
use crate::{Control, ErrorCode, ImportError};
use glam::{DAffine3, DVec3};
use std::io::{self, BufRead, Read};

/// Meshes, one per part of the scan and in that order, and the placement that all share.
pub(super) struct Geometry {
    pub(super) meshes: Vec<Mesh>,
    pub(super) transform: DAffine3,
}

/// Hands pieces of text to `tobj` and stops it when asked.
struct Pieces<'a> {
    pieces: std::vec::IntoIter<&'a [u8]>,
    current: &'a [u8],
    control: &'a Control,
}

impl Read for Pieces<'_> {
    fn read(&mut self, out: &mut [u8]) -> io::Result<usize> {
        let n = self.fill_buf()?.read(out)?;
        self.consume(n);
        Ok(n)
    }
}

impl BufRead for Pieces<'_> {
    fn fill_buf(&mut self) -> io::Result<&[u8]> {
        if self.control.is_stopped() {
            return Err(io::Error::other("stopped"));
        }
        while self.current.is_empty() {
            match self.pieces.next() {
                Some(piece) => self.current = piece,
                None => break,
            }
        }
        Ok(self.current.get(..64 << 10).unwrap_or(self.current))
    }

    fn consume(&mut self, amount: usize) {
        self.current = self.current.get(amount..).unwrap_or_default();
    }
}

/// A model for each part: what plain statements said already, or else what `tobj` makes of them.
///
/// # Errors
/// [`ErrorCode::Stopped`]; [`ErrorCode::Syntax`] should `tobj` refuse the text after all.
pub(super) fn parse(scan: &mut Scan, control: &Control) -> Result<Vec<tobj::Model>, ImportError> {
    if let Some(numbers) = scan.numbers.take() {
        return numbers.into_models(control);
    }
    let mut pieces: Vec<&[u8]> = scan.vertices.iter().collect();
    for faces in &scan.faces {
        // tobj ends a model at every `o`. All vertices stand before the first face, so none is out of its reach.
        pieces.push(b"o part\n");
        pieces.extend(faces.iter());
    }
    let mut reader = Pieces { pieces: pieces.into_iter(), current: &[], control };
    let options = tobj::LoadOptions { single_index: true, ..tobj::LoadOptions::default() };
    let no_materials = |_: &std::path::Path| Ok((Vec::new(), Default::default()));
    let loaded = tobj::load_obj_buf(&mut reader, &options, no_materials);
    control.check()?;
    let (models, _) = loaded.map_err(|e| ImportError::new(ErrorCode::Syntax, format!("cannot be parsed: {e}")))?;
    Ok(models)
}

/// Triangulates, and moves the coordinates near the origin if they are far from it.
///
/// # Errors
/// [`ErrorCode::Stopped`].
pub(super) fn build(models: Vec<tobj::Model>, parts: &[Part], control: &Control) -> Result<Geometry, ImportError> {
    let origin = far_centre(models.iter().flat_map(|m| points(&m.mesh.positions)));
    let color_scale = color_scale(&models);
    let mut triangulator = Triangulator::default();
    let mut meshes = Vec::with_capacity(models.len());
    let mut groups = Vec::with_capacity(models.len());
    for (model, part) in models.into_iter().zip(parts) {
        let (mesh, of_triangles) = to_mesh(model.mesh, &part.groups, origin, color_scale, &mut triangulator, control)?;
        meshes.push(mesh);
        groups.push(of_triangles);
    }
    smooth(&mut meshes, &groups);
    Ok(Geometry { meshes, transform: DAffine3::from_translation(origin) })
}

fn points(flat: &[f64]) -> impl Iterator<Item = DVec3> {
    flat.as_chunks().0.iter().map(|p| DVec3::from_array(*p))
}

/// The centre of the bounds, if it is so far from the origin that `f32` would lose what is there; else zero.
fn far_centre(points: impl Iterator<Item = DVec3>) -> DVec3 {
    let none = (DVec3::INFINITY, DVec3::NEG_INFINITY);
    let (low, high) = points.fold(none, |(low, high), p| (low.min(p), high.max(p)));
    let (centre, extent) = (0.5 * (low + high), (high - low).length());
    if centre.is_finite() && centre.length() > 16.0 * extent { centre } else { DVec3::ZERO }
}

/// Colours are 0 … 1 by habit; files with larger ones count to 255.
fn color_scale(models: &[tobj::Model]) -> f64 {
    let largest = models.iter().flat_map(|m| &m.mesh.vertex_color).fold(0.0_f64, |a, b| a.max(*b));
    if largest > 2.0 { 1.0 / 255.0 } else { 1.0 }
}

/// IEC 61966-2-1, display value to linear.
fn srgb_to_linear(encoded: f64) -> f32 {
    let c = encoded.clamp(0.0, 1.0) as f32;
    if c <= 0.04045 { c / 12.92 } else { libm::powf((c + 0.055) / 1.055, 2.4) }
}

fn to_mesh(
    mesh: tobj::Mesh,
    groups: &[u32],
    origin: DVec3,
    color_scale: f64,
    triangulator: &mut Triangulator,
    control: &Control,
) -> Result<(Mesh, Vec<u32>), ImportError> {
    let (triangles, groups) = triangulate(&mesh, groups, triangulator, control)?;
    let uv = |c: &[f64; 2]| [c[0] as f32, (1.0 - c[1]) as f32];
    let color = |c: &[f64; 3]| {
        let [r, g, b] = c.map(|x| srgb_to_linear(x * color_scale));
        [r, g, b, 1.0]
    };
    let mesh = Mesh {
        positions: points(&mesh.positions).map(|p| (p - origin).as_vec3().to_array()).collect(),
        normals: points(&mesh.normals).map(|n| n.normalize_or(DVec3::Z).as_vec3().to_array()).collect(),
        uvs: [mesh.texcoords.as_chunks().0.iter().map(uv).collect(), Vec::new()],
        colors: mesh.vertex_color.as_chunks().0.iter().map(color).collect(),
        triangles,
        ..Mesh::default()
    };
    Ok((mesh, groups))
}

/// The triangles, and the smoothing group of each where the faces have any.
fn triangulate(
    mesh: &tobj::Mesh,
    groups: &[u32],
    triangulator: &mut Triangulator,
    control: &Control,
) -> Result<(Vec<[u32; 3]>, Vec<u32>), ImportError> {
    if mesh.face_arities.is_empty() {
        return Ok((mesh.indices.as_chunks().0.to_vec(), groups.to_vec()));
    }
    let mut of_triangles = Vec::new();
    let positions = mesh.positions.as_chunks::<3>().0;
    let mut triangles = Vec::with_capacity(mesh.indices.len().saturating_sub(2 * mesh.face_arities.len()));
    let (mut rest, mut corners) = (mesh.indices.as_slice(), Vec::new());
    let mut since_check = 0;
    for (face_index, arity) in mesh.face_arities.iter().enumerate() {
        // Those of the face before.
        if let Some(group) = face_index.checked_sub(1).and_then(|k| groups.get(k)) {
            of_triangles.resize(triangles.len(), *group);
        }
        let Some((face, tail)) = rest.split_at_checked(*arity as usize) else { break };
        rest = tail;
        since_check += face.len();
        if since_check > 8192 {
            since_check = 0;
            control.check()?;
        }
        if let [a, b, c] = face {
            triangles.push([*a, *b, *c]);
            continue;
        }
        corners.clear();
        corners.extend(face.iter().filter_map(|i| positions.get(*i as usize)).map(|p| DVec3::from_array(*p)));
        let corner = |i: u32| face.get(i as usize).copied().unwrap_or_default();
        triangles.extend(triangulator.polygon(&corners).iter().map(|t| t.map(corner)));
    }
    if let Some(group) = groups.last() {
        of_triangles.resize(triangles.len(), *group);
    }
    Ok((triangles, of_triangles))
}
