//! The rest pose: morph targets by their initial weights, skins by their joints' initial transforms.

use super::accessor::Accessors;
use super::report::Report;
use crate::ImportError;
use crate::scene::Mesh;
use glam::{DAffine3, DMat3, DVec3};
use gltf::json;
use gltf::json::mesh::Semantic;
use gltf::json::validation::Checked;

/// What bends a mesh at one node.
#[derive(Default)]
pub(super) struct Pose {
    /// Weights of the morph targets; those beyond its end are zero.
    pub(super) weights: Vec<f32>,
    /// Skin space (about `origin`) by joint, or empty.
    pub(super) joints: Vec<DAffine3>,
    /// The world-space point about which skinned vertices are given, so that floats hold them well.
    pub(super) origin: DVec3,
}

/// Where a primitive is in the file, and which of its vertices are read.
pub(super) struct Target<'a> {
    pub(super) primitive: &'a json::mesh::Primitive,
    pub(super) place: &'a str,
    pub(super) select: Option<&'a [u32]>,
    /// Vertices in the file.
    pub(super) count: usize,
}

/// The joint matrices of a skin (glTF 2.0, 3.7.3.1), or `None`, with a warning, when the skin is not sound.
///
/// # Errors
/// Those of reading the inverse bind matrices.
pub(super) fn joints(
    accessors: &Accessors,
    skin: usize,
    world: &[DAffine3],
    report: &mut Report,
) -> Result<Option<(Vec<DAffine3>, DVec3)>, ImportError> {
    let place = format!("/skins/{skin}");
    let joints = accessors.root.skins.get(skin).map_or(&[][..], |s| &s.joints);
    let Some(worlds) = joints.iter().map(|j| world.get(j.value()).copied()).collect::<Option<Vec<_>>>() else {
        report.warn(
            "skin-ignored",
            format!("{place}/joints"),
            "a joint is no node: the mesh is shown without the skin",
        );
        return Ok(None);
    };
    let origin = worlds.first().map_or(DVec3::ZERO, |w| w.translation);
    let inverse_bind = accessors.root.skins.get(skin).and_then(|s| s.inverse_bind_matrices);
    let at = || format!("{place}/inverseBindMatrices");
    let binds = match inverse_bind {
        Some(index) if accessors.count(index.value(), &at)? >= worlds.len() => {
            let select: Vec<u32> = (0..worlds.len() as u32).collect();
            accessors.floats::<16>(index.value(), Some(&select), &at)?
        }
        _ => Vec::new(),
    };
    if worlds.is_empty() || (inverse_bind.is_some() && binds.len() < worlds.len()) || !origin.is_finite() {
        report.warn("skin-ignored", place, "lacks joints or matrices: the mesh is shown without the skin");
        return Ok(None);
    }
    let bind = |k: usize| binds.get(k).map_or(DAffine3::IDENTITY, affine);
    let to_origin = DAffine3::from_translation(-origin);
    let matrices = worlds.iter().enumerate().map(|(k, w)| to_origin * *w * bind(k)).collect();
    Ok(Some((matrices, origin)))
}

fn affine(m: &[f32; 16]) -> DAffine3 {
    let [a, b, c, _, d, e, f, _, g, h, i, _, x, y, z, _] = m.map(f64::from);
    DAffine3::from_mat3_translation(DMat3::from_cols_array(&[a, b, c, d, e, f, g, h, i]), DVec3::new(x, y, z))
}

/// Says so where morph targets change what is not morphed: colours and texture coordinates.
pub(super) fn warn_about_other_targets(document: &serde_json::Value, report: &mut Report) {
    for (m, mesh) in document.get("meshes").and_then(|v| v.as_array()).into_iter().flatten().enumerate() {
        let primitives = mesh.get("primitives").and_then(|v| v.as_array());
        for (p, primitive) in primitives.into_iter().flatten().enumerate() {
            let targets = primitive.get("targets").and_then(|v| v.as_array());
            for (t, target) in targets.into_iter().flatten().enumerate() {
                for name in target.as_object().into_iter().flat_map(|o| o.keys()) {
                    if name.starts_with("COLOR_") || name.starts_with("TEXCOORD_") {
                        let place = format!("/meshes/{m}/primitives/{p}/targets/{t}/{name}");
                        report.warn("morph-ignored", place, "colours and texture coordinates are not morphed");
                    }
                }
            }
        }
    }
}

/// Adds the weighted morph targets to positions, normals and tangents.
///
/// # Errors
/// Those of reading accessors.
pub(super) fn morph(
    accessors: &Accessors,
    target: &Target,
    weights: &[f32],
    mesh: &mut Mesh,
    report: &mut Report,
) -> Result<(), ImportError> {
    let targets = target.primitive.targets.as_deref().unwrap_or_default();
    for (k, (morph, weight)) in targets.iter().zip(weights).enumerate().filter(|(_, (_, w))| **w != 0.0) {
        let mut read = |index: Option<json::Index<json::Accessor>>, name: &str| {
            let Some(index) = index.map(|i| i.value()) else { return Ok(Vec::new()) };
            let place = || format!("{}/targets/{k}/{name}", target.place);
            if accessors.count(index, &place)? != target.count {
                report.warn("morph-ignored", place(), "has another number of vertices than the mesh");
                return Ok(Vec::new());
            }
            accessors.floats::<3>(index, target.select, &place)
        };
        let add = |to: &mut [f32], delta: &[f32; 3]| to.iter_mut().zip(delta).for_each(|(x, d)| *x += weight * d);
        let deltas = read(morph.positions, "POSITION")?;
        mesh.positions.iter_mut().zip(&deltas).for_each(|(p, d)| add(p, d));
        if !mesh.normals.is_empty() {
            let deltas = read(morph.normals, "NORMAL")?;
            mesh.normals.iter_mut().zip(&deltas).for_each(|(n, d)| add(n, d));
        }
        if !mesh.tangents.is_empty() {
            let deltas = read(morph.tangents, "TANGENT")?;
            mesh.tangents.iter_mut().zip(&deltas).for_each(|(t, d)| add(t, d));
        }
    }
    Ok(())
}

/// Moves vertices by their joints. `false`: the mesh has no joints or weights and stays as it is.
///
/// # Errors
/// Those of reading accessors.
pub(super) fn skin(
    accessors: &Accessors,
    target: &Target,
    joints: &[DAffine3],
    mesh: &mut Mesh,
    report: &mut Report,
) -> Result<bool, ImportError> {
    let attribute = |semantic| target.primitive.attributes.get(&Checked::Valid(semantic)).map(|i| i.value());
    // Per vertex: the weighted sum of its joint matrices, and the sum of the weights.
    let zero = DAffine3::from_cols_array(&[0.0; 12]);
    let mut blends: Vec<(DAffine3, f64)> = vec![(zero, 0.0); mesh.positions.len()];
    let mut misfits = 0u64;
    for set in 0.. {
        let (Some(j), Some(w)) = (attribute(Semantic::Joints(set)), attribute(Semantic::Weights(set))) else {
            if set == 0 {
                return Ok(false);
            }
            break;
        };
        let joints_at = || format!("{}/attributes/JOINTS_{set}", target.place);
        let weights_at = || format!("{}/attributes/WEIGHTS_{set}", target.place);
        if accessors.count(j, &joints_at)? != target.count || accessors.count(w, &weights_at)? != target.count {
            return Ok(false);
        }
        let indices = accessors.joints(j, target.select, &joints_at)?;
        let weights = accessors.floats::<4>(w, target.select, &weights_at)?;
        for ((blend, indices), weights) in blends.iter_mut().zip(&indices).zip(&weights) {
            for (index, weight) in indices.iter().zip(weights).filter(|(_, w)| **w != 0.0) {
                match joints.get(*index as usize) {
                    Some(matrix) if *weight > 0.0 && weight.is_finite() => {
                        let weight = f64::from(*weight);
                        blend.0.matrix3 += matrix.matrix3 * weight;
                        blend.0.translation += matrix.translation * weight;
                        blend.1 += weight;
                    }
                    _ => misfits += 1,
                }
            }
        }
    }
    if misfits > 0 {
        let message = format!("{misfits} joint indices or weights are out of range and count as zero");
        report.warn("skin-ignored", format!("{}/attributes/JOINTS_0", target.place), message);
    }
    let first = joints.first().copied().unwrap_or(DAffine3::IDENTITY);
    for (v, (blend, sum)) in blends.iter().enumerate() {
        // Weights ought to sum to one; a vertex without any follows the first joint.
        let (linear, translation) = match *sum > 0.0 {
            true => (blend.matrix3 * (1.0 / sum), blend.translation / *sum),
            false => (first.matrix3, first.translation),
        };
        let vector = |[x, y, z]: [f32; 3]| DVec3::new(x.into(), y.into(), z.into());
        if let Some(p) = mesh.positions.get_mut(v) {
            *p = (linear * vector(*p) + translation).as_vec3().to_array();
        }
        if let Some(n) = mesh.normals.get_mut(v) {
            // The cofactor matrix is the inverse transpose times the determinant, and exists always.
            let [a, b, c] = [linear.x_axis, linear.y_axis, linear.z_axis];
            let cofactor = DMat3::from_cols(b.cross(c), c.cross(a), a.cross(b));
            let sign = if linear.determinant() < 0.0 { -1.0 } else { 1.0 };
            *n = (cofactor * vector(*n) * sign).normalize_or_zero().as_vec3().to_array();
        }
        if let Some([x, y, z, w]) = mesh.tangents.get_mut(v).copied() {
            let [x, y, z] = (linear * vector([x, y, z])).normalize_or_zero().as_vec3().to_array();
            if let Some(t) = mesh.tangents.get_mut(v) {
                *t = [x, y, z, w];
            }
        }
    }
    Ok(true)
}
