//! From which side an asset can be seen at all.

use glam::DVec3;
use kiln_formats::Scene;
use kiln_formats::scene::{Instance, Mesh};

/// Whether anything would be seen from far away in the direction `from`: cameras look through the backs of single-sided
/// surfaces.
pub fn is_seen(scene: &Scene, from: DVec3) -> bool {
    let placed = |instance: &Instance| {
        let mesh = scene.meshes.get(instance.mesh as usize)?;
        let double_sided = scene.materials.get(mesh.material as usize).is_none_or(|m| m.double_sided);
        Some((mesh, double_sided))
    };
    scene.instances.iter().any(|instance| {
        placed(instance).is_some_and(|(mesh, double_sided)| double_sided || shows_a_front(mesh, instance, from))
    })
}

fn shows_a_front(mesh: &Mesh, instance: &Instance, from: DVec3) -> bool {
    let linear = instance.transform.matrix3;
    let handedness = if linear.determinant() < 0.0 { -1.0 } else { 1.0 };
    let corner = |i: u32| mesh.positions.get(i as usize).map(|p| linear * DVec3::from_array(p.map(f64::from)));
    mesh.triangles.iter().any(|[a, b, c]| {
        let (Some(a), Some(b), Some(c)) = (corner(*a), corner(*b), corner(*c)) else { return false };
        let normal = (b - a).cross(c - a) * handedness;
        // At a more grazing angle a plate is a line.
        normal.dot(from) > 0.05 * normal.length() * from.length() && normal.length_squared() > 0.0
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DAffine3;
    use kiln_formats::scene::Material;

    #[test]
    fn single_sided_sheets_are_seen_from_the_front() {
        let mesh = Mesh {
            positions: vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]],
            triangles: vec![[0, 1, 2]],
            ..Mesh::default()
        };
        let seen = |double_sided, scale: f64, from| {
            let transform = DAffine3::from_scale(DVec3::splat(scale));
            let scene = Scene {
                meshes: vec![mesh.clone()],
                materials: vec![Material { double_sided, ..Material::default() }],
                instances: vec![Instance { name: String::new(), mesh: 0, transform }],
                ..Scene::default()
            };
            is_seen(&scene, from)
        };
        assert!(seen(false, 1.0, DVec3::Z) && !seen(false, 1.0, DVec3::NEG_Z) && seen(true, 1.0, DVec3::NEG_Z));
        // glTF turns the winding round where a transform mirrors: the front of the mirror image faces the other way.
        assert!(seen(false, -1.0, DVec3::NEG_Z) && !seen(false, -1.0, DVec3::Z));
        assert!(!seen(false, 1.0, DVec3::X), "edge on");
    }
}
