//! `map("file")`, with pictures drawn here.

use super::{phong, read_in, scene};
use image::{Rgb, RgbImage};
use kiln_formats::scene::{ColorSpace, Pixels, Scene, Wrap};
use kiln_formats::{ErrorCode, Limits, Place, Warning};
use tempfile::TempDir;

/// A folder with a picture of 2 × 2 texels: red, green over blue, grey.
fn folder() -> TempDir {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let mut picture = RgbImage::new(2, 2);
    picture.put_pixel(0, 0, Rgb([255, 0, 0]));
    picture.put_pixel(1, 0, Rgb([0, 255, 0]));
    picture.put_pixel(0, 1, Rgb([0, 0, 255]));
    picture.put_pixel(1, 1, Rgb([100, 100, 100]));
    for name in ["a.png", "a.bmp"] {
        picture.save(folder.path().join(name)).expect("a picture");
    }
    folder
}

fn read(body: &str) -> (Scene, Vec<Warning>) {
    let text = format!("SBT-raytracer 1.0\n{body}");
    read_in(folder().path(), text.as_bytes(), Limits::default()).unwrap_or_else(|e| panic!("{body}: {e}"))
}

#[test]
fn colours_are_taken_as_stored_and_clamped_at_the_edges() {
    let (scene, warnings) = read("box { material = { diffuse = map(\"a.png\"); specular = map(\"a.png\"); } }");
    let phong = phong(&scene.materials[0]);
    assert_eq!(phong.diffuse.factor, [1.0; 3]);
    assert_eq!(phong.diffuse.texture, phong.specular.texture, "one file, one texture");
    let texture = scene.textures[phong.diffuse.texture.expect("a texture").texture as usize];
    assert_eq!((texture.color_space, texture.wrap_u, texture.wrap_v), (ColorSpace::Linear, Wrap::Clamp, Wrap::Clamp));
    let image = &scene.images[texture.image as usize];
    assert!(matches!(&image.pixels, Pixels::Rgba8(p) if p[..8] == [255, 0, 0, 255, 0, 255, 0, 255]));
    assert_eq!(warnings.iter().map(|w| w.code.as_str()).collect::<Vec<_>>(), ["energy-scaled"]);
}

#[test]
fn names_of_any_case_and_with_backslashes_are_found() {
    let (scene, _) = read("box { material={ diffuse=map(\".\\A.PNG\"); emissive=map( \"a.BMP\" ) } }");
    assert_eq!(scene.textures.len(), 2);
    assert_eq!(scene.materials[0].emission.texture.map(|t| t.texture), Some(1));
}

#[test]
fn a_shininess_map_is_luma_times_128() {
    let (scene, _) =
        read("square { material = { shininess = map(\"a.png\"); diffuse = map(\"a.png\"); index = map(\"a.png\") } }");
    let phong = phong(&scene.materials[0]);
    assert_eq!((phong.exponent.factor, phong.ior.factor), (128.0, 1.0));
    let grey = phong.exponent.texture.expect("a texture").texture;
    assert_eq!(phong.ior.texture.map(|t| t.texture), Some(grey));
    assert_ne!(phong.diffuse.texture.map(|t| t.texture), Some(grey));
    let Pixels::Rgba16(pixels) = &scene.images[scene.textures[grey as usize].image as usize].pixels else {
        panic!("luma has 16 bits");
    };
    let luma: Vec<f64> = pixels.chunks(4).map(|p| f64::from(p[0]) / 65535.0).collect();
    for (have, want) in luma.iter().zip([0.299, 0.587, 0.114, 100.0 / 255.0]) {
        assert!((have - want).abs() < 1e-5, "{luma:?}");
    }
    assert!(pixels.chunks(4).all(|p| p[0] == p[1] && p[1] == p[2]));
}

#[test]
fn a_texture_that_cannot_be_read_stops_the_scene() {
    let folder = folder();
    std::fs::write(folder.path().join("broken.png"), b"\x89PNG\r\n\x1a\nno more").expect("a file");
    let fail = |file: &str, limits| {
        let text = format!("SBT-raytracer 1.0\nbox {{\n material = {{ diffuse = map(\"{file}\"); }} }}");
        let error = read_in(folder.path(), text.as_bytes(), limits).expect_err(file);
        assert_eq!(error.place, Place::Text { line: 3, column: 15 }, "{error}");
        assert!(error.message.starts_with(&format!("cannot read texture `{file}`")), "{error}");
        assert!(error.message.contains("looked in "), "{error}");
        error.code
    };
    assert_eq!(fail("none.png", Limits::default()), ErrorCode::Io);
    assert_eq!(fail("broken.png", Limits::default()), ErrorCode::Invalid);
    assert_eq!(fail("/etc/passwd", Limits::default()), ErrorCode::Refused);
    assert_eq!(fail("a.png", Limits { max_texels: 3, ..Limits::default() }), ErrorCode::TooLarge);
}

#[test]
fn shapes_without_coordinates_read_the_lower_left_corner() {
    let (scene, warnings) = read("sphere { material = { ambient = map(\"a.png\"); } }");
    assert!(scene.meshes[0].uvs[0].iter().all(|uv| *uv == [0.0, 1.0]));
    assert_eq!(warnings[0].code, "missing-uvs");
    let body = "polymesh { points=((0,0,0),(1,0,0),(0,1,0)); faces=((0,1,2)); material={ ambient=map(\"a.png\") } }";
    let (scene, warnings) = read(body);
    assert_eq!(scene.meshes[0].uvs[0], [[0.0, 1.0]; 3]);
    assert_eq!(warnings[0].code, "missing-uvs");
}

#[test]
fn bumps_bend_the_normals_of_shapes_with_coordinates() {
    let bumpy = "material = { bump_mapping = bump(\"a.png\"); diffuse = (1,1,1) }";
    for shape in ["square", "box", "sphere"] {
        let (scene, warnings) = read(&format!("{shape} {{ {bumpy} }}"));
        assert_eq!(warnings, [], "{shape}");
        let map = scene.materials[scene.meshes[0].material as usize].normal_map.expect("bumps");
        assert_eq!(scene.meshes[0].tangents.len(), scene.meshes[0].positions.len());
        let image = &scene.images[scene.textures[map.texture.texture as usize].image as usize];
        // Red over blue: luma falls downwards, so the normal leans down, which is +v.
        assert!(matches!(&image.pixels, Pixels::Rgba16(p) if p[1] != 32768 && p[2] > 60000), "{shape}");
    }
    let (scene, warnings) = read(&format!("cone {{ {bumpy} }}"));
    assert_eq!(warnings.iter().map(|w| w.code.as_str()).collect::<Vec<_>>(), ["missing-uvs", "normal-map-ignored"]);
    assert!(scene.meshes[0].tangents.is_empty());
    assert_eq!(scene.materials[scene.meshes[0].material as usize].normal_map, None);
}

#[test]
fn objects_have_textures_and_emission_of_their_own_in_some_dialects() {
    let body = "material = { diffuse = (.5,.5,.5); emissive = (.25,0,0) }
        sphere { diffuse_map = \"a.png\"; } box { normal_map = \".\\a.png\" } sphere_light { emission = (3,2,1) } square {}";
    let (scene, warnings) = read(body);
    assert_eq!(warnings, []);
    let material = |k: usize| &scene.materials[scene.meshes[k].material as usize];
    let diffuse = phong(material(0)).diffuse;
    assert_eq!((diffuse.factor, diffuse.texture.is_some()), ([1.0; 3], true));
    assert!(material(1).normal_map.is_some() && phong(material(1)).diffuse.texture.is_none());
    assert_eq!((material(2).emission.factor, material(3).emission.factor), ([3.0, 2.0, 1.0], [0.25, 0.0, 0.0]));
    // The whole texture lies around the sphere, upright: the top of the picture at the top, its middle at +z.
    let globe = &scene.meshes[0];
    for (position, [u, v]) in globe.positions.iter().zip(&globe.uvs[0]) {
        assert!((position[1] - libm::cosf(std::f32::consts::PI * v)).abs() < 1e-6);
        assert!(position[2] > -1e-6 || !(0.25..0.75).contains(u), "{position:?} {u}");
    }
    let outward = |t: &[u32; 3]| {
        let [a, b, c] = t.map(|i| glam::Vec3::from(globe.positions[i as usize]));
        let area = (b - a).cross(c - a);
        assert!(area.dot(a + b + c) > 0.0, "{t:?}");
        0.5 * area.length()
    };
    let area: f32 = globe.triangles.iter().map(outward).sum();
    assert!((area / (4.0 * std::f32::consts::PI) - 1.0).abs() < 2e-3, "{area}");
}

#[test]
fn scenes_without_textures_have_none() {
    let scene = scene("sphere {}");
    assert!(scene.textures.is_empty() && scene.images.is_empty() && scene.meshes[0].uvs[0].is_empty());
}
