use super::{Appearance, Lower, Result};
use crate::Control;
use crate::ray::source::{At, Offset};
use crate::ray::tree::{Faces, MeshBlock};
use crate::repair::tangents;
use crate::scene::{MaterialId, Mesh, MeshId, UvTransform};
use glam::DVec3;

/// Faces between two looks at the stop signal.
const POLL_EVERY: usize = 1 << 16;
/// Bad faces that one message names.
const FACES_NAMED: usize = 2;

impl Lower<'_, '_> {
    /// Adds a mesh; `None` when it has nothing to draw.
    pub(super) fn mesh(
        &mut self,
        mut block: MeshBlock,
        at: Offset,
        name: &str,
        material: MaterialId,
        own: &Appearance,
        vertex_materials: &[Appearance],
    ) -> Result<Option<MeshId>> {
        if let Some(At { at, value: file }) = block.objfile.take() {
            (block.points, block.faces) = self.objfile(&file, at)?;
        }
        let MeshBlock { points, normals, uvs, faces, .. } = block;
        let lists =
            [("normals", normals.len()), ("texture coordinates", uvs.len()), ("materials", vertex_materials.len())];
        for (what, count) in lists {
            if count != 0 && count != points.len() {
                return Err(self.invalid(at, format!("the mesh has {count} {what} for {} points", points.len())));
            }
        }
        self.check_faces(&faces, points.len())?;
        let triangles = fans(&faces, &points, self.control)?;
        if triangles.is_empty() {
            self.notes.warn("empty-mesh", at, || "this mesh has no triangle to draw".into());
            return Ok(None);
        }
        let normals =
            if block.generate_normals { generate_normals(&points, &triangles, self.control)? } else { normals };
        // In the file v = 0 is the lowest row of the image.
        let mut uvs: Vec<[f32; 2]> = uvs.into_iter().map(|[u, v]| [u, 1.0 - v]).collect();
        if uvs.is_empty() && (own.is_textured() || vertex_materials.iter().any(Appearance::is_textured)) {
            self.warn_about_missing_uvs(at);
            uvs = vec![NO_UV; points.len()];
        }
        if vertex_materials.iter().any(|m| m.emission.0 != own.emission.0) {
            self.notes.warn("vertex-emission", at, || {
                "`emissive` differs between the vertices of this mesh; the mesh's own holds everywhere".into()
            });
        }
        let mut vertex_ids = Vec::with_capacity(vertex_materials.len());
        for appearance in vertex_materials {
            let mut appearance = *appearance;
            appearance.emission = own.emission;
            vertex_ids.push(self.material(&appearance, at));
        }
        let mut mesh = Mesh {
            name: name.into(),
            positions: points,
            normals,
            uvs: [uvs, Vec::new()],
            triangles,
            material,
            vertex_materials: vertex_ids,
            ..Mesh::default()
        };
        self.bend(&mut mesh, own, at);
        Ok(Some(self.add_mesh(mesh)))
    }

    /// Gives a mesh the tangents that bumps need; where it can have none, another material without them.
    pub(super) fn bend(&mut self, mesh: &mut Mesh, own: &Appearance, at: Offset) {
        if own.bumps.is_none() {
            return;
        }
        let first = mesh.uvs[0].first();
        let anywhere = mesh.uvs[0].iter().any(|uv| Some(uv) != first);
        let made = if anywhere {
            tangents::generate(mesh, 0, &UvTransform::IDENTITY)
        } else {
            Err(tangents::NoTangents::TextureCoordinates)
        };
        if let Err(why) = made {
            self.notes.warn("normal-map-ignored", at, || format!("{why}: its bumps are left out"));
            mesh.material = self.material(&own.without_bumps(), at);
        }
    }

    pub(super) fn warn_about_missing_uvs(&mut self, at: Offset) {
        self.notes.warn("missing-uvs", at, || {
            "a texture on a shape without texture coordinates: its lower left corner is read everywhere".into()
        });
    }

    fn check_faces(&self, faces: &Faces, points: usize) -> Result<()> {
        if faces.indices.iter().all(|i| usize::try_from(*i).is_ok_and(|i| i < points)) {
            return Ok(());
        }
        let mut first = None;
        let mut complaints = Vec::new();
        for (at, face) in each(faces) {
            let Some(bad) = face.iter().find(|i| usize::try_from(**i).map_or(true, |i| i >= points)) else {
                continue;
            };
            first.get_or_insert(at);
            let corners: Vec<String> = face.iter().take(8).map(i64::to_string).collect();
            let dots = if face.len() > 8 { ",…" } else { "" };
            let corners = format!("face ({}{dots})", corners.join(","));
            complaints.push(match (bad, points) {
                (..0, _) => format!("{corners} has a negative index"),
                (_, 0) => format!("{corners} names vertex {bad}, the mesh has none"),
                _ => format!("{corners} names vertex {bad}, the mesh has {points} vertices (0..{})", points - 1),
            });
            if complaints.len() == FACES_NAMED {
                break;
            }
        }
        Err(self.invalid(first.unwrap_or(0), complaints.join("; ")))
    }
}

/// Where shapes without texture coordinates read textures: (0, 0) of the file, the lower left corner.
pub(super) const NO_UV: [f32; 2] = [0.0, 1.0];

fn each(faces: &Faces) -> impl Iterator<Item = (Offset, &[i64])> {
    let begins = std::iter::once(0).chain(faces.ends.iter().map(|(_, end)| *end));
    begins.zip(&faces.ends).map(|(begin, (at, end))| (*at, faces.indices.get(begin..*end).unwrap_or_default()))
}

/// Cuts every face into a fan around its first corner. Triangles with two equal corners are left out: exporters
/// write them by the hundred. The indices have been checked.
fn fans(faces: &Faces, points: &[[f32; 3]], control: &Control) -> Result<Vec<[u32; 3]>> {
    let mut triangles = Vec::with_capacity(faces.indices.len().saturating_sub(2 * faces.ends.len()));
    let point = |i: u32| points.get(i as usize);
    for (count, (_, face)) in each(faces).enumerate() {
        if count.is_multiple_of(POLL_EVERY) {
            control.check()?;
        }
        let [first, rest @ ..] = face else { continue };
        for pair in rest.windows(2) {
            let [a, b, c] = [*first, pair[0], pair[1]].map(|i| i as u32);
            if point(a) != point(b) && point(b) != point(c) && point(c) != point(a) {
                triangles.push([a, b, c]);
            }
        }
    }
    Ok(triangles)
}

/// Per vertex the mean of the unit normals of its faces, whatever their areas; faces without area do not count.
fn generate_normals(points: &[[f32; 3]], triangles: &[[u32; 3]], control: &Control) -> Result<Vec<[f32; 3]>> {
    let mut sums = vec![(DVec3::ZERO, 0_u32, DVec3::Z); points.len()];
    let point = |i: u32| points.get(i as usize).map_or(DVec3::ZERO, |p| DVec3::from_array(p.map(f64::from)));
    for (count, triangle) in triangles.iter().enumerate() {
        if count.is_multiple_of(POLL_EVERY) {
            control.check()?;
        }
        let [a, b, c] = triangle.map(point);
        let cross = (b - a).cross(c - a);
        // Not `normalize`: products of single precision coordinates may be as small as 1e-90.
        let Some(normal) = (cross / cross.abs().max_element()).try_normalize() else { continue };
        for i in triangle {
            if let Some((sum, count, last)) = sums.get_mut(*i as usize) {
                *sum += normal;
                *count += 1;
                *last = normal;
            }
        }
    }
    let mean = |(sum, count, last): (DVec3, u32, DVec3)| {
        let mean = sum / f64::from(count.max(1));
        // Opposite faces cancel out, and points without a face have no normal at all.
        let usable = if mean.length_squared() > 1e-12 { mean } else { last };
        usable.as_vec3().to_array()
    };
    Ok(sums.into_iter().map(mean).collect())
}
