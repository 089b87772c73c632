//! The node hierarchy: transforms composed over it, and the nodes that a scene shows.

use super::document::invalid;
use super::report::Report;
use crate::{ErrorCode, ImportError, Place};
use glam::{DAffine3, DMat3, DQuat, DVec3};
use gltf::json;
use serde_json::Value;

/// The composed hierarchy.
pub(super) struct Hierarchy {
    /// Node to world, for every node of the file.
    pub(super) world: Vec<DAffine3>,
    /// The visible nodes of the scene shown, parents before children, in the file's order.
    pub(super) shown: Vec<usize>,
}

/// Each node's own transform, read in double precision (the typed model has floats only).
pub(super) fn local_transforms(document: &Value, report: &mut Report) -> Vec<DAffine3> {
    let nodes = document.get("nodes").and_then(Value::as_array);
    nodes.into_iter().flatten().enumerate().map(|(i, node)| local_transform(node, i, report)).collect()
}

fn numbers<const N: usize>(node: &Value, name: &str) -> Option<[f64; N]> {
    let items = node.get(name)?.as_array()?;
    let values: Vec<f64> = items.iter().map_while(Value::as_f64).collect();
    values.try_into().ok()
}

fn local_transform(node: &Value, index: usize, report: &mut Report) -> DAffine3 {
    if let Some(m) = numbers::<16>(node, "matrix") {
        let [a, b, c, x, d, e, f, y, g, h, i, z, tx, ty, tz, w] = m;
        if [x, y, z, w] != [0.0, 0.0, 0.0, 1.0] {
            let message = "the matrix is not affine; its last row is ignored";
            report.warn("bad-transform", format!("/nodes/{index}/matrix"), message);
        }
        let linear = DMat3::from_cols_array(&[a, b, c, d, e, f, g, h, i]);
        return DAffine3::from_mat3_translation(linear, DVec3::new(tx, ty, tz));
    }
    let translation = numbers(node, "translation").map_or(DVec3::ZERO, DVec3::from_array);
    let scale = numbers(node, "scale").map_or(DVec3::ONE, DVec3::from_array);
    let rotation = numbers(node, "rotation").map_or(DQuat::IDENTITY, DQuat::from_array);
    let length = rotation.length();
    let rotation = if length > 0.0 && length.is_finite() {
        DQuat::from_vec4(glam::DVec4::from(rotation) / length)
    } else {
        report.warn("bad-transform", format!("/nodes/{index}/rotation"), "is no rotation and is ignored");
        DQuat::IDENTITY
    };
    DAffine3::from_scale_rotation_translation(scale, rotation, translation)
}

/// Composes the hierarchy and selects the scene to show: the default one, else the first, else all roots.
///
/// # Errors
/// [`ErrorCode::Invalid`] at the JSON pointer of a wrong index, a node with two parents or a cycle;
/// [`ErrorCode::TooLarge`] for deeper nesting than `max_nesting`.
pub(super) fn compose(root: &json::Root, local: &[DAffine3], max_nesting: u32) -> Result<Hierarchy, ImportError> {
    let n = root.nodes.len();
    let children = |node: usize| root.nodes.get(node).and_then(|n| n.children.as_deref()).unwrap_or_default();
    let mut has_parent = vec![false; n];
    for node in 0..n {
        for (k, child) in children(node).iter().enumerate() {
            let place = || format!("/nodes/{node}/children/{k}");
            match has_parent.get_mut(child.value()) {
                None => return Err(invalid(place(), format!("node {child} of {n}"))),
                Some(true) => return Err(invalid(place(), format!("node {child} has two parents"))),
                Some(flag) => *flag = true,
            }
        }
    }
    // Every node has one parent at most, so what the parentless do not reach lies on or below a cycle.
    let roots: Vec<usize> = has_parent.iter().enumerate().filter(|(_, p)| !**p).map(|(i, _)| i).collect();
    let mut world: Vec<Option<DAffine3>> = vec![None; n];
    let mut level: Vec<(usize, DAffine3)> = roots.iter().map(|i| (*i, DAffine3::IDENTITY)).collect();
    let mut depth = 0;
    while !level.is_empty() {
        let mut next = Vec::new();
        for (node, parent) in level {
            let transform = parent * local.get(node).copied().unwrap_or(DAffine3::IDENTITY);
            if let Some(slot) = world.get_mut(node) {
                *slot = Some(transform);
            }
            next.extend(children(node).iter().map(|child| (child.value(), transform)));
        }
        depth += 1;
        if let Some((deep, _)) = next.first().filter(|_| depth > max_nesting) {
            let error = ImportError::new(ErrorCode::TooLarge, format!("nodes nest deeper than {max_nesting}"));
            return Err(error.at(Place::Json(format!("/nodes/{deep}"))));
        }
        level = next;
    }
    if let Some(node) = world.iter().position(Option::is_none) {
        return Err(invalid(format!("/nodes/{node}"), "the node is its own ancestor, or has one that is"));
    }
    let world: Vec<DAffine3> = world.into_iter().flatten().collect();
    Ok(Hierarchy { shown: shown(root, &roots)?, world })
}

fn shown(root: &json::Root, roots: &[usize]) -> Result<Vec<usize>, ImportError> {
    // Without a default, the first scene that has anything in it.
    let first = || root.scenes.iter().position(|scene| !scene.nodes.is_empty()).unwrap_or(0);
    let index = root.scene.map_or_else(first, |s| s.value());
    let mut stack: Vec<usize> = match root.scenes.get(index) {
        Some(scene) => {
            let out = |i: &json::Index<json::Node>| i.value() >= root.nodes.len();
            if let Some(k) = scene.nodes.iter().position(out) {
                let message = format!("index out of range: there are {} nodes", root.nodes.len());
                return Err(invalid(format!("/scenes/{index}/nodes/{k}"), message));
            }
            scene.nodes.iter().map(|i| i.value()).collect()
        }
        None if root.scene.is_some() => {
            return Err(invalid("/scene", format!("scene {index} of {}", root.scenes.len())));
        }
        None => roots.to_vec(),
    };
    // Depth first, with a stack of our own: the last is taken first.
    stack.reverse();
    let mut seen = vec![false; root.nodes.len()];
    let mut shown = Vec::new();
    while let Some(i) = stack.pop() {
        let (Some(node), Some(flag)) = (root.nodes.get(i), seen.get_mut(i)) else {
            continue;
        };
        // A scene may list a node and its ancestor; it is still drawn once.
        if std::mem::replace(flag, true) || is_hidden(node) {
            continue;
        }
        shown.push(i);
        stack.extend(node.children.iter().flatten().rev().map(|c| c.value()));
    }
    Ok(shown)
}

/// KHR_node_visibility.
fn is_hidden(node: &json::Node) -> bool {
    let extension = node.extensions.as_ref().and_then(|e| e.others.get("KHR_node_visibility"));
    extension.and_then(|e| e.get("visible")).and_then(Value::as_bool) == Some(false)
}
