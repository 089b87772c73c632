//! One primitive of a mesh in its rest pose.

use super::accessor::Accessors;
use super::document::invalid;
use super::pose::{self, Pose, Target};
use super::report::Report;
use super::triangles;
use super::uv_sets::UvSets;
use crate::scene::Mesh;
use crate::{Control, ImportError, repair};
use gltf::json::mesh::{Mode, Primitive, Semantic};
use gltf::json::validation::Checked;

/// Reads primitives and counts what is not drawn.
pub(super) struct Reader<'a, 'r> {
    pub(super) accessors: Accessors<'a>,
    pub(super) report: &'a mut Report<'r>,
    pub(super) control: &'a Control,
    /// Whether nobody is to render what is read.
    pub(super) survey: bool,
    /// Primitives of points or lines seen, and the first one's place.
    pub(super) points_or_lines: usize,
    pub(super) first_points_or_lines: String,
    /// Why the first primitive that came to nothing did, and its place.
    pub(super) first_nothing: Option<(String, &'static str)>,
    /// Meshes that want tangents once all are read.
    pub(super) without_tangents: Vec<Tangents>,
}

/// What is needed to give a mesh of the scene its tangents.
pub(super) struct Tangents {
    pub(super) mesh: usize,
    /// JSON pointer of its primitive.
    pub(super) place: String,
    pub(super) source: crate::scene::TextureRef,
    /// Its material in the document.
    pub(super) material: Option<usize>,
}

/// What was read: the mesh without name and material, and whether its pose is in world space about `Pose::origin`.
pub(super) struct Posed {
    pub(super) mesh: Mesh,
    pub(super) skinned: bool,
}

fn attribute(primitive: &Primitive, semantic: Semantic) -> Option<usize> {
    primitive.attributes.get(&Checked::Valid(semantic)).map(|i| i.value())
}

impl Reader<'_, '_> {
    fn nothing(&mut self, place: String, why: &'static str) {
        self.report.warn("nothing-to-draw", place.clone(), why);
        self.first_nothing.get_or_insert((place, why));
    }

    /// Reads a primitive; `None` when it has nothing to draw. `tangents`: whether given tangents are wanted, `sets`: which
    /// texture coordinates.
    ///
    /// # Errors
    /// [`crate::ErrorCode::Invalid`] at the JSON pointer of what cannot be read; [`crate::ErrorCode::Stopped`].
    pub(super) fn read(
        &mut self,
        primitive: &Primitive,
        place: &str,
        pose: &Pose,
        tangents: bool,
        sets: UvSets,
    ) -> Result<Option<Posed>, ImportError> {
        self.control.check()?;
        let Checked::Valid(mode) = primitive.mode else {
            return Err(invalid(format!("{place}/mode"), "is no mode"));
        };
        if triangles::upper_bound(mode, 3) == 0 {
            if self.points_or_lines == 0 {
                self.first_points_or_lines = place.to_owned();
            }
            self.points_or_lines += 1;
            return Ok(None);
        }
        let Some(position) = attribute(primitive, Semantic::Positions) else {
            self.nothing(format!("{place}/attributes"), "there is no POSITION");
            return Ok(None);
        };
        let position_at = || format!("{place}/attributes/POSITION");
        let count = self.accessors.count(position, &position_at)?;
        if self.accessors.is_blank(position) {
            self.nothing(position_at(), "all positions are zero");
            return Ok(None);
        }
        if primitive.indices.is_none() {
            self.accessors.check_backed(position, &position_at)?;
        }
        let mut triangles = self.triangles(primitive, mode, count, place)?;
        if triangles.is_empty() {
            self.nothing(place.to_owned(), "there are no triangles");
            return Ok(None);
        }
        let select = triangles::compact(&mut triangles, count);
        let select = select.as_deref();
        let mut mesh = Mesh {
            positions: self.accessors.floats(position, select, &position_at)?,
            normals: self.optional(primitive, Semantic::Normals, count, select, place)?,
            triangles,
            ..Mesh::default()
        };
        self.control.check()?;
        // Tangents without normals are to be ignored (glTF 2.0, 3.7.2.1).
        if tangents && !mesh.normals.is_empty() {
            mesh.tangents = self.optional(primitive, Semantic::Tangents, count, select, place)?;
        }
        for (set, uvs) in sets.into_iter().zip(&mut mesh.uvs) {
            *uvs = self.optional(primitive, Semantic::TexCoords(set), count, select, place)?;
        }
        mesh.colors = self.colors(primitive, count, select, place)?;
        self.control.check()?;
        let target = Target { primitive, place, select, count };
        pose::morph(&self.accessors, &target, &pose.weights, &mut mesh, self.report)?;
        let mut skinned = false;
        if !pose.joints.is_empty() {
            skinned = pose::skin(&self.accessors, &target, &pose.joints, &mut mesh, self.report)?;
            if !skinned {
                let message = "JOINTS_0 or WEIGHTS_0 are missing: the primitive is shown without its skin";
                self.report.warn("skin-ignored", format!("{place}/attributes"), message);
            }
        }
        super::mend::mend(&mut mesh, place, self.report);
        if mesh.triangles.is_empty() {
            self.nothing(place.to_owned(), "no triangle is left");
            return Ok(None);
        }
        Ok(Some(Posed { mesh, skinned }))
    }

    fn triangles(
        &mut self,
        primitive: &Primitive,
        mode: Mode,
        count: usize,
        place: &str,
    ) -> Result<Vec<[u32; 3]>, ImportError> {
        let indices_at = || format!("{place}/indices");
        let mut restart = None;
        let indices: Vec<u32> = match primitive.indices {
            Some(index) => {
                self.accessors.check_backed(index.value(), &indices_at)?;
                // The largest value of an index type restarts a strip in graphics hardware. glTF forbids it, and an extension
                // allows it; where there are so many vertices it is one of them.
                restart = self.accessors.largest(index.value()).filter(|largest| *largest as usize >= count);
                self.accessors.integers::<1>(index.value(), None, &indices_at)?.into_flattened()
            }
            // `count` fits 32 bits.
            None => (0..count as u32).collect(),
        };
        if mode == Mode::Triangles && !indices.len().is_multiple_of(3) {
            let message = format!("{} corners are no whole triangles; the last are left out", indices.len());
            self.report.warn("incomplete-triangle", place, message);
        }
        let mut triangles = triangles::assemble_pieces(mode, &indices, restart).unwrap_or_default();
        drop(indices);
        let dropped = triangles::drop_out_of_range(&mut triangles, count);
        if dropped > 0 && triangles.is_empty() {
            return Err(invalid(indices_at(), format!("every triangle names a vertex beyond the {count} there are")));
        }
        if dropped > 0 {
            let message = format!("{dropped} triangles name vertices beyond the {count} there are and are left out");
            self.report.warn("index-out-of-range", indices_at(), message);
        }
        Ok(triangles)
    }

    /// An attribute that a primitive may lack; one of another length is left out.
    fn optional<const N: usize>(
        &mut self,
        primitive: &Primitive,
        semantic: Semantic,
        count: usize,
        select: Option<&[u32]>,
        place: &str,
    ) -> Result<Vec<[f32; N]>, ImportError> {
        let Some(index) = attribute(primitive, semantic.clone()) else {
            return Ok(Vec::new());
        };
        let at = || format!("{place}/attributes/{}", semantic.to_string());
        let own = self.accessors.count(index, &at)?;
        if own != count {
            let message = format!("{own} values for {count} positions; the attribute is left out");
            self.report.warn("attribute-ignored", at(), message);
            return Ok(Vec::new());
        }
        self.accessors.floats(index, select, &at)
    }

    fn colors(
        &mut self,
        primitive: &Primitive,
        count: usize,
        select: Option<&[u32]>,
        place: &str,
    ) -> Result<Vec<[f32; 4]>, ImportError> {
        let semantic = Semantic::Colors(0);
        let three = attribute(primitive, semantic.clone()).is_some_and(|i| self.accessors.has_components(i, 3));
        if !three {
            return self.optional(primitive, semantic, count, select, place);
        }
        let rgb = self.optional::<3>(primitive, semantic, count, select, place)?;
        Ok(rgb.into_iter().map(|[r, g, b]| [r, g, b, 1.0]).collect())
    }
}

/// Gives a mesh its tangents where it has none, for the texture coordinates that `source` reads. A mesh without normals is
/// flat (glTF 2.0, 3.7.2.1).
///
/// # Errors
/// Why there can be none; the mesh is as it was.
pub(super) fn complete_tangents(
    mesh: &mut Mesh,
    source: &crate::scene::TextureRef,
) -> Result<(), repair::tangents::NoTangents> {
    if mesh.tangents.is_empty() {
        repair::tangents::generate(mesh, usize::from(source.uv_set), &source.transform)?;
    }
    Ok(())
}
