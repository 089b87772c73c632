//! Cameras.

use super::report::Report;
use crate::scene::{Camera, Projection};
use glam::{DAffine3, DVec3};
use gltf::json;
use gltf::json::camera::Type;
use gltf::json::validation::Checked;

/// The camera at a node, if it has one that is sound. Clipping planes are left out: rays need none.
pub(super) fn at_node(root: &json::Root, index: usize, world: &DAffine3, report: &mut Report) -> Option<Camera> {
    let node = root.nodes.get(index)?;
    let id = node.camera?.value();
    let Some(source) = root.cameras.get(id) else {
        report.warn("invalid-camera", format!("/nodes/{index}/camera"), format!("there is no camera {id}"));
        return None;
    };
    let name = source.name.clone().filter(|n| !n.is_empty()).or_else(|| node.name.clone()).unwrap_or_default();
    let camera = build(source, world).map(|camera| Camera { name, ..camera });
    if camera.is_none() {
        report.warn("invalid-camera", format!("/cameras/{id}"), "has no sound projection and is left out");
    }
    camera
}

fn build(source: &json::Camera, world: &DAffine3) -> Option<Camera> {
    let origin = world.translation;
    // The camera looks along −Z with +Y up. Scale is removed: the axes become orthonormal.
    let forward = (-world.matrix3.z_axis).try_normalize()?;
    let right = forward.cross(world.matrix3.y_axis.try_normalize()?).try_normalize()?;
    let up = right.cross(forward);
    let camera = match source.type_ {
        Checked::Valid(Type::Perspective) => {
            let lens = source.perspective.as_ref()?;
            let aspect = lens.aspect_ratio.filter(|a| *a > 0.0 && a.is_finite());
            let fov = f64::from(lens.yfov);
            if !(fov > 0.0 && fov < std::f64::consts::PI) {
                return None;
            }
            let camera = Camera::perspective(origin, forward, up, fov, aspect.map_or(1.0, f64::from));
            Camera { aspect: aspect.map(f64::from), ..camera }
        }
        Checked::Valid(Type::Orthographic) => {
            let lens = source.orthographic.as_ref()?;
            let (x, y) = (f64::from(lens.xmag).abs(), f64::from(lens.ymag).abs());
            Camera {
                name: String::new(),
                projection: Projection::Orthographic,
                origin,
                forward,
                right: right * x,
                up: up * y,
                aspect: Some(x / y),
            }
        }
        Checked::Invalid => return None,
    };
    let finite = |v: DVec3| v.is_finite();
    let volume = camera.forward.dot(camera.right.cross(camera.up));
    let sound = finite(camera.origin) && finite(camera.right) && finite(camera.up);
    (sound && volume != 0.0 && volume.is_finite()).then_some(camera)
}
