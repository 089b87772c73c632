//! EXT_mesh_gpu_instancing: many instances of a node's mesh by accessors of transforms.

use super::accessor::Accessors;
use super::document::invalid;
use crate::ImportError;
use glam::{DAffine3, DQuat, DVec3, DVec4};
use gltf::json;
use serde_json::Value;

/// The extension's name.
pub(super) const NAME: &str = "EXT_mesh_gpu_instancing";

/// The accessors of a node's instances, and how many there are.
pub(super) struct Instances {
    node: usize,
    translation: Option<usize>,
    rotation: Option<usize>,
    scale: Option<usize>,
    /// How many instances the node has.
    pub(super) count: usize,
}

/// The instances of a node, unless it has the mesh once only.
///
/// # Errors
/// [`crate::ErrorCode::Invalid`] at the JSON pointer of an attribute that is no accessor, has another count than the
/// others, or claims more than the file stores.
pub(super) fn of_node(
    accessors: &Accessors,
    node: &json::Node,
    index: usize,
) -> Result<Option<Instances>, ImportError> {
    let extension = node.extensions.as_ref().and_then(|e| e.others.get(NAME));
    let Some(attributes) = extension.and_then(|e| e.get("attributes")).and_then(Value::as_object) else {
        return Ok(None);
    };
    let mut count = None;
    let mut accessor = |name: &str| {
        let Some(value) = attributes.get(name) else { return Ok(None) };
        let place = || attribute_at(index, name);
        let Some(accessor) = value.as_u64().and_then(|i| usize::try_from(i).ok()) else {
            return Err(invalid(place(), "is no index"));
        };
        accessors.check_backed(accessor, &place)?;
        let own = accessors.count(accessor, &place)?;
        let first = *count.get_or_insert(own);
        if own != first {
            return Err(invalid(place(), format!("{own} values where another attribute has {first}")));
        }
        Ok(Some(accessor))
    };
    let (translation, rotation, scale) = (accessor("TRANSLATION")?, accessor("ROTATION")?, accessor("SCALE")?);
    Ok(count.map(|count| Instances { node: index, translation, rotation, scale, count }))
}

fn attribute_at(node: usize, name: &str) -> String {
    format!("/nodes/{node}/extensions/{NAME}/attributes/{name}")
}

impl Instances {
    /// Instance to node, for every instance.
    ///
    /// # Errors
    /// Those of reading the accessors.
    pub(super) fn transforms(&self, accessors: &Accessors) -> Result<Vec<DAffine3>, ImportError> {
        let vectors = |accessor: Option<usize>, name: &str| match accessor {
            Some(accessor) => accessors.floats::<3>(accessor, None, &|| attribute_at(self.node, name)),
            None => Ok(Vec::new()),
        };
        let translations = vectors(self.translation, "TRANSLATION")?;
        let scales = vectors(self.scale, "SCALE")?;
        let rotations = match self.rotation {
            Some(accessor) => accessors.floats::<4>(accessor, None, &|| attribute_at(self.node, "ROTATION"))?,
            None => Vec::new(),
        };
        let vector = |[x, y, z]: &[f32; 3]| DVec3::new((*x).into(), (*y).into(), (*z).into());
        let rotation = |q: &[f32; 4]| {
            let q = DVec4::from_array(q.map(f64::from));
            // A quaternion without direction turns nothing; one that is not finite leaves the instance out later.
            if q == DVec4::ZERO { DQuat::IDENTITY } else { DQuat::from_vec4(q / q.length()) }
        };
        let transform = |i| {
            DAffine3::from_scale_rotation_translation(
                scales.get(i).map_or(DVec3::ONE, vector),
                rotations.get(i).map_or(DQuat::IDENTITY, rotation),
                translations.get(i).map_or(DVec3::ZERO, vector),
            )
        };
        Ok((0..self.count).map(transform).collect())
    }
}
