//! Small scenes in code, and statistics of rendered pictures.
#![allow(dead_code)]

pub mod everything;

use glam::{DAffine3, DVec3};
use kiln::formats::scene::{Camera, ColorInput, Instance, Material, Mesh, MetalRough, ScalarInput, Surface};
use kiln::integrate::{Rendered, View, render};
use kiln::prepare::{EnvironmentSource, prepare};
use kiln::settings::{PrepareSettings, RenderSettings};
use kiln::{Control, Scene};

/// A pure Lambert material that may emit.
pub fn lambert(albedo: f32, emission: f32) -> Material {
    Material {
        surface: Surface::MetalRough(MetalRough {
            base_color: ColorInput::constant([albedo; 3]),
            specular: ScalarInput::constant(0.0),
            ..MetalRough::default()
        }),
        emission: ColorInput::constant([emission; 3]),
        ..Material::default()
    }
}

/// Adds a mesh at a place with a new material.
pub fn add(scene: &mut Scene, mesh: Mesh, material: Material, transform: DAffine3) {
    let mesh = Mesh { material: scene.materials.len() as u32, ..mesh };
    scene.materials.push(material);
    scene.instances.push(Instance { name: String::new(), mesh: scene.meshes.len() as u32, transform });
    scene.meshes.push(mesh);
}

/// The unit sphere, with smooth normals.
pub fn sphere(levels: u32) -> Mesh {
    let (positions, triangles) = kiln::formats::repair::shapes::icosphere(levels);
    Mesh { normals: positions.clone(), positions, triangles, ..Mesh::default() }
}

/// The square [−1, 1]² at z = 0, its front towards +z.
pub fn square() -> Mesh {
    let positions = vec![[-1.0, -1.0, 0.0], [1.0, -1.0, 0.0], [1.0, 1.0, 0.0], [-1.0, 1.0, 0.0]];
    Mesh { positions, triangles: vec![[0, 1, 2], [0, 2, 3]], ..Mesh::default() }
}

/// The cube [−1, 1]³ with flat faces, its front outside, or inside.
pub fn cube(inward: bool) -> Mesh {
    let (mut positions, mut triangles) = (Vec::new(), Vec::new());
    for axis in 0..3 {
        for side in [-1.0f32, 1.0] {
            let first = positions.len() as u32;
            for (a, b) in [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)] {
                let mut p = [0.0; 3];
                (p[axis], p[(axis + 1) % 3], p[(axis + 2) % 3]) = (side, a, b);
                positions.push(p);
            }
            let [i, j, k, l] = [first, first + 1, first + 2, first + 3];
            triangles.extend(if (side > 0.0) != inward { [[i, j, k], [i, k, l]] } else { [[i, k, j], [i, l, k]] });
        }
    }
    Mesh { positions, triangles, ..Mesh::default() }
}

/// A square view.
pub fn view(eye: DVec3, target: DVec3, fov_degrees: f64, size: u32) -> View {
    let up = if (target - eye).normalize().y.abs() > 0.99 { DVec3::Z } else { DVec3::Y };
    let camera = Camera::perspective(eye, target - eye, up, fov_degrees.to_radians(), 1.0);
    View { camera, width: size, height: size, show_environment: true }
}

/// Validates, prepares and renders.
pub fn shoot(
    scene: &Scene,
    environment: &EnvironmentSource,
    prepare_settings: &PrepareSettings,
    settings: &RenderSettings,
    view: &View,
) -> Rendered {
    scene.validate().expect("a valid scene");
    let control = Control::default();
    let prepared = prepare(scene.clone(), environment, prepare_settings, &control).expect("not stopped");
    render(&prepared, view, settings, &control).expect("not stopped")
}

/// Mean luminance-free average of all channels, and its standard error from the replicates of all pixels.
pub fn mean_and_error(rendered: &Rendered) -> (f64, f64) {
    let own = rendered.film.estimate(0..rendered.film.pixels.len(), [1.0 / 3.0; 3]);
    (own.mean, own.variance.sqrt())
}

/// The folder of shared assets and references, or `None` when `KILN_SHARED` is unset: then the test says that it
/// skips, and fails where `KILN_REQUIRE_SHARED` forbids that.
pub fn shared(what: &str) -> Option<std::path::PathBuf> {
    let shared = std::env::var_os("KILN_SHARED").map(std::path::PathBuf::from);
    if shared.is_none() {
        println!("skipped: {what} needs KILN_SHARED");
        assert!(std::env::var_os("KILN_REQUIRE_SHARED").is_none(), "KILN_SHARED is not set");
    }
    shared
}
