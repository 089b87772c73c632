use super::*;
use crate::geometry::textures::color;
use crate::geometry::{Geometry, coverage, world_bounds};
use glam::{DAffine3, Vec3};
use kiln_formats::scene::{ColorInput, ColorSpace, Filter, Instance, ScalarInput, UvTransform, Wrap};

/// Edges of an image in texels.
const SIZE: u32 = 64;

/// In [0, 1), from two words (the hash of `sampling`, which geometry knows nothing of).
fn number(i: u32, k: u32) -> f32 {
    let pcg = |x: u32| {
        let state = x.wrapping_mul(747_796_405).wrapping_add(2_891_336_453);
        let word = ((state >> ((state >> 28) + 4)) ^ state).wrapping_mul(277_803_737);
        (word >> 22) ^ word
    };
    (pcg(pcg(k).wrapping_add(i.rotate_left(5)) ^ i) >> 8) as f32 * (1.0 / 16_777_216.0)
}

/// Squares of 16 texels: alpha and colour full, empty, or noise.
fn image() -> Image {
    let texel = |i: u32| {
        let (x, y) = (i % SIZE, i / SIZE);
        let noise = (number(i, 7) * 256.0) as u8;
        [255, 0, noise][((x / 16 + y / 16) % 3) as usize]
    };
    let pixels = (0..SIZE * SIZE).flat_map(|i| [texel(i); 4]).collect();
    Image { name: String::new(), width: SIZE, height: SIZE, pixels: Pixels::Rgba8(pixels) }
}

/// Small triangles all over the image and beyond, under a material.
fn scene(alpha: AlphaMode, factor: f32, wrap: Wrap, filter: Filter) -> Scene {
    let turn = UvTransform { linear: [[0.8, 0.3], [-0.3, 0.8]], offset: [0.1, -0.2] };
    let reference = TextureRef { transform: turn, ..TextureRef::new(0) };
    let material = Material {
        alpha: kiln_formats::scene::Alpha {
            mode: alpha,
            value: ScalarInput { factor, texture: Some(reference), channel: Channel::A, bias: 0.0 },
        },
        emission: ColorInput { factor: [1.0, 0.0, 2.0], texture: Some(reference) },
        ..Material::default()
    };
    let count = 4000;
    let corner = |t: u32, k: u32| [0, 1].map(|c| number(t, c) * 3.0 - 1.0 + number(t, 2 + 2 * k + c) * 0.05);
    let mesh = Mesh {
        positions: (0..3 * count).map(|v| [number(v, 20), number(v, 21), number(v, 22)]).collect(),
        triangles: (0..count).map(|t| [0, 1, 2].map(|k| 3 * t + k)).collect(),
        uvs: [(0..count).flat_map(|t| [0, 1, 2].map(|k| corner(t, k))).collect(), Vec::new()],
        material: 0,
        ..Mesh::default()
    };
    Scene {
        materials: vec![material],
        meshes: vec![mesh],
        images: vec![image()],
        textures: vec![Texture { image: 0, wrap_u: wrap, wrap_v: wrap, filter, color_space: ColorSpace::Srgb }],
        instances: vec![Instance { name: String::new(), mesh: 0, transform: DAffine3::IDENTITY }],
        ..Scene::default()
    }
}

#[test]
fn what_is_known_of_a_triangle_holds_at_all_its_points() {
    let cutoff = AlphaMode::Mask { cutoff: 0.5 };
    for (alpha, factor, wrap, filter) in [
        (AlphaMode::Blend, 1.0, Wrap::Repeat, Filter::Linear),
        (AlphaMode::Blend, 1.0, Wrap::Mirror, Filter::Nearest),
        (AlphaMode::Blend, 1.5, Wrap::Clamp, Filter::Linear),
        (cutoff, 1.0, Wrap::Repeat, Filter::Nearest),
        (cutoff, 0.6, Wrap::Clamp, Filter::Linear),
        (cutoff, 1.0, Wrap::Mirror, Filter::Linear),
    ] {
        let scene = scene(alpha, factor, wrap, filter);
        let frame = crate::geometry::WorldFrame::new(&scene, world_bounds(&scene));
        let geometry = Geometry::new(&scene, &frame);
        let mut counts = [0; 4];
        for triangle in 0..geometry.len() as u32 {
            let point = |k: u32| match k {
                0..3 => std::array::from_fn(|corner| f32::from(u8::from(corner as u32 == k))),
                _ => {
                    let [a, b] =
                        crate::math::warp::uniform_triangle([number(triangle, 2 * k), number(triangle, 2 * k + 1)]);
                    [a, b, 1.0 - a - b]
                }
            };
            let points: Vec<[f32; 3]> = (0..40).map(point).collect();
            let covered = |b: &[f32; 3]| coverage(&scene, &geometry, triangle, *b);
            let known = geometry.known_coverage(triangle);
            match known {
                Some(true) => assert!(points.iter().all(|b| covered(b) >= 1.0)),
                Some(false) => assert!(points.iter().all(|b| covered(b) <= 0.0)),
                None => {}
            }
            let shown = |b: &[f32; 3]| color(&scene, &scene.materials[0].emission, &geometry.uv(&scene, triangle, *b));
            let glows = points.iter().any(|b| shown(b) != Vec3::ZERO);
            assert!(!(glows && geometry.is_dark(triangle)));
            counts[0] += u32::from(known == Some(true));
            counts[1] += u32::from(known == Some(false));
            counts[2] += u32::from(known.is_none());
            counts[3] += u32::from(geometry.is_dark(triangle));
        }
        assert!(counts.iter().all(|count| *count > 40), "{counts:?}");
    }
}

#[test]
fn vertex_alpha_leaves_nothing_known_of_coverage() {
    let mut scene = scene(AlphaMode::Blend, 1.0, Wrap::Repeat, Filter::Linear);
    scene.meshes[0].colors = vec![[1.0, 1.0, 1.0, 0.5]; scene.meshes[0].positions.len()];
    let geometry = Geometry::new(&scene, &crate::geometry::WorldFrame::new(&scene, world_bounds(&scene)));
    assert!((0..geometry.len() as u32).all(|triangle| geometry.known_coverage(triangle).is_none()));
    assert!((0..geometry.len() as u32).any(|triangle| geometry.is_dark(triangle)));
}

#[test]
fn images_of_all_kinds_are_marked_alike() {
    let bytes = scene(AlphaMode::Blend, 1.0, Wrap::Repeat, Filter::Linear);
    let Pixels::Rgba8(eight) = &bytes.images[0].pixels else { unreachable!() };
    let wide = Pixels::Rgba16(eight.iter().map(|byte| u16::from(*byte) * 257).collect());
    let float = Pixels::RgbaF32(eight.iter().map(|byte| f32::from(*byte) / 255.0).collect());
    let known = |scene: &Scene| {
        let geometry = Geometry::new(scene, &crate::geometry::WorldFrame::new(scene, world_bounds(scene)));
        let of = |t: u32| (geometry.known_coverage(t), geometry.is_dark(t));
        (0..geometry.len() as u32).map(of).collect::<Vec<_>>()
    };
    for pixels in [wide, float] {
        let mut other = bytes.clone();
        other.images[0].pixels = pixels;
        assert_eq!(known(&other), known(&bytes));
    }
}
