//! Cut-out and blended surfaces have no colour of what their images say where nothing is.

use super::{View, render};
use crate::prepare::{EnvironmentSource, prepare};
use crate::settings::{Integrator, PrepareSettings, RenderSettings};
use glam::{DAffine3, DVec3};
use kiln_formats::scene::*;
use kiln_formats::{Control, Scene};

/// White leaves on black ground that is not there, with edges of half coverage that are white too, on a square of 2 × 2.
fn leaves(mode: AlphaMode, filter: Filter) -> Scene {
    let texel = |k: u32| match (k % 32 % 8, k / 32 % 6) {
        (2..=4, 1..=3) => [255; 4],
        (5, 1..=3) => [255, 255, 255, 128],
        _ => [0; 4],
    };
    let pixels = Pixels::Rgba8((0..32 * 32).flat_map(texel).collect());
    let (wrap_u, wrap_v) = (Wrap::Repeat, Wrap::Clamp);
    let image = TextureRef::new(0);
    let corners = [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]];
    let white = MetalRough {
        base_color: ColorInput { factor: [1.0; 3], texture: Some(image) },
        specular: ScalarInput::constant(0.0),
        ..MetalRough::default()
    };
    let coverage = ScalarInput { factor: 1.0, texture: Some(image), channel: Channel::A, bias: 0.0 };
    let scene = Scene {
        meshes: vec![Mesh {
            positions: corners.map(|[x, y]| [x, y, 0.0]).to_vec(),
            uvs: [corners.map(|c| c.map(|x| 0.5 + 0.5 * x)).to_vec(), Vec::new()],
            triangles: vec![[0, 1, 2], [0, 2, 3]],
            ..Mesh::default()
        }],
        instances: vec![Instance { name: String::new(), mesh: 0, transform: DAffine3::IDENTITY }],
        materials: vec![Material {
            surface: Surface::MetalRough(white),
            alpha: Alpha { mode, value: coverage },
            ..Material::default()
        }],
        textures: vec![Texture { image: 0, wrap_u, wrap_v, filter, color_space: ColorSpace::Srgb }],
        images: vec![Image { name: String::new(), width: 32, height: 32, pixels }],
        ..Scene::default()
    };
    scene.validate().expect("a valid scene");
    scene
}

#[test]
fn white_leaves_vanish_in_a_white_world_from_near_and_far() {
    let control = Control::default();
    let world = EnvironmentSource::Constant([1.0; 3]);
    for (mode, filter) in [
        (AlphaMode::Blend, Filter::Linear),
        (AlphaMode::Mask { cutoff: 0.5 }, Filter::Linear),
        (AlphaMode::Mask { cutoff: 0.3 }, Filter::Nearest),
    ] {
        let prepared =
            prepare(leaves(mode, filter), &world, &PrepareSettings::default(), &control).expect("not stopped");
        for (distance, integrator) in
            [0.2, 1.0, 5.0, 20.0].into_iter().flat_map(|d| [(d, Integrator::Path), (d, Integrator::Plain)])
        {
            let camera = Camera {
                name: String::new(),
                projection: Projection::Perspective,
                origin: DVec3::new(0.1, 0.05, distance),
                forward: DVec3::NEG_Z,
                right: DVec3::X * 0.4,
                up: DVec3::Y * 0.4,
                aspect: None,
            };
            let view = View { camera, width: 16, height: 16, show_environment: true };
            let settings = RenderSettings { spp: 16, integrator, ..RenderSettings::default() };
            let film = render(&prepared, &view, &settings, &control).expect("not stopped").film;
            for pixel in &film.pixels {
                let [r, g, b, _] = pixel.mean();
                let off = [r, g, b].map(|x| (x - 1.0).abs()).into_iter().fold(0.0, f64::max);
                assert!(off < 1e-4, "{mode:?}, {filter:?}, {integrator:?} from {distance}: {r} {g} {b}");
            }
        }
    }
}
