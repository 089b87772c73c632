//! The OBJ + MTL importer.

mod faces;
mod geometry;
mod log;
mod number;
mod scan;
mod text;

use crate::scene::{Instance, Material};
use crate::{Control, ImportError, Resources, Scene, Warning};

/// Reads the bytes of an OBJ file and the MTL and image files that it refers to.
///
/// # Errors
/// [`ImportError`] when nothing can be shown.
pub fn import(
    bytes: Vec<u8>,
    resources: &mut Resources,
    warnings: &mut Vec<Warning>,
    control: &Control,
) -> Result<Scene, ImportError> {
    let mut log = log::Log::new(warnings);
    let text = text::decode(bytes)?;
    let result = scan::scan(&text, resources.limits().max_triangles, &mut log, control);
    drop(text);
    let result = result.and_then(|scan| {
        let geometry = geometry::build(&scan, control)?;
        let mut scene = Scene { materials: vec![Material::default()], ..Scene::default() };
        for (part, mut mesh) in scan.parts.into_iter().zip(geometry.meshes) {
            mesh.name = part.name;
            let (id, name) = (scene.meshes.len() as u32, mesh.name.clone());
            scene.instances.push(Instance { name, mesh: id, transform: geometry.transform });
            scene.meshes.push(mesh);
        }
        Ok(scene)
    });
    log.finish();
    result
}
