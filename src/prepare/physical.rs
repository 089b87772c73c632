use glam::{DAffine3, DVec3};
use kiln_formats::Scene;
use kiln_formats::repair::shapes::icosphere;
use kiln_formats::scene::{ColorInput, Extent, Instance, LightKind, Material, Mesh, MetalRough, ScalarInput, Surface};
use std::f64::consts::PI;

/// Replaces `area_light`s by surfaces that emit: spheres, and two-sided parallelograms, with the radiance that gives
/// the same irradiance far away where the fall-off is 1/d² (ray-format.md, section 11.8).
///
/// With `radius`, point lights become spheres of that radius too.
pub(super) fn replace_soft_lights(scene: &mut Scene, radius: Option<f64>) {
    let mut sphere = None;
    for light in std::mem::take(&mut scene.lights) {
        let LightKind::Point { extent, .. } = light.kind else {
            scene.lights.push(light);
            continue;
        };
        let extent = match (extent, radius) {
            (Extent::Point, Some(radius)) if radius > 0.0 => Extent::Disc { radius },
            _ => extent,
        };
        // Intensity over projected area.
        let projected = match extent {
            Extent::Point => {
                scene.lights.push(light);
                continue;
            }
            Extent::Disc { radius } => PI * radius * radius,
            Extent::Parallelogram { u, v } => 4.0 * u.cross(v).length(),
        };
        let radiance = light.color.map(|c| (f64::from(c) / projected) as f32);
        let material = scene.materials.len() as u32;
        scene.materials.push(Material {
            name: light.name.clone(),
            surface: Surface::MetalRough(MetalRough {
                base_color: ColorInput::BLACK,
                specular: ScalarInput::constant(0.0),
                ..MetalRough::default()
            }),
            emission: ColorInput::constant(radiance),
            emission_two_sided: matches!(extent, Extent::Parallelogram { .. }),
            ..Material::default()
        });
        let (mesh, transform) = match extent {
            Extent::Parallelogram { u, v } => {
                let corner = |a: f64, b: f64| (u * a + v * b).as_vec3().to_array();
                let positions = vec![corner(-1.0, -1.0), corner(1.0, -1.0), corner(1.0, 1.0), corner(-1.0, 1.0)];
                let triangles = vec![[0, 1, 2], [0, 2, 3]];
                (Mesh { positions, triangles, ..Mesh::default() }, DAffine3::from_translation(light.position))
            }
            Extent::Disc { .. } | Extent::Point => {
                let (positions, triangles) = sphere.get_or_insert_with(|| icosphere(4)).clone();
                let radius = (projected / PI).sqrt();
                let transform = DAffine3::from_translation(light.position) * DAffine3::from_scale(DVec3::splat(radius));
                let normals = positions.clone();
                (Mesh { positions, normals, triangles, ..Mesh::default() }, transform)
            }
        };
        let mesh = Mesh { name: light.name.clone(), material, ..mesh };
        scene.instances.push(Instance { name: light.name, mesh: scene.meshes.len() as u32, transform });
        scene.meshes.push(mesh);
    }
}
