//! Which of a texture's images is shown, and what is known of images that are not decoded.

mod gltf_common;

use gltf_common::{Builder, png, triangle};
use kiln_formats::scene::{Pixels, Surface};
use kiln_formats::{Control, ImportOptions, Touched, import, open, survey};
use serde_json::{Value, json};

/// A triangle whose base colour is texture 0, of the images given.
fn textured(images: &[&[u8]], texture: Value) -> Builder {
    let mut b = triangle();
    let normals = b.floats("VEC3", &[0.0, 0.0, 1.0].repeat(3));
    b.doc["meshes"][0]["primitives"][0]["attributes"]["NORMAL"] = json!(normals);
    let uvs = b.floats("VEC2", &[0.0, 0.0, 1.0, 0.0, 0.0, 1.0]);
    b.doc["meshes"][0]["primitives"][0]["attributes"]["TEXCOORD_0"] = json!(uvs);
    b.doc["meshes"][0]["primitives"][0]["material"] = json!(0);
    let (base, normal) = (json!({"baseColorTexture": {"index": 0}}), json!({"index": 0}));
    b.doc["materials"] = json!([{"pbrMetallicRoughness": base, "normalTexture": normal}]);
    b.doc["textures"] = json!([texture]);
    let views: Vec<Value> = images.iter().map(|bytes| json!({"bufferView": b.view(bytes)})).collect();
    b.doc["images"] = json!(views);
    b
}

#[test]
fn the_next_image_of_a_texture_is_shown_where_one_cannot_be() {
    let sound = png();
    let broken = &sound[..sound.len() / 2];
    let photoshop = b"8BPS\0\x01 of layers";
    for (images, shown) in [
        ([&sound[..], &sound, photoshop], true),
        ([&sound, broken, photoshop], true),
        ([&sound, photoshop, broken], true),
        ([broken, photoshop, &sound], true),
        ([broken, photoshop, broken], false),
    ] {
        let both = json!({"EXT_texture_webp": {"source": 1}, "MSFT_texture_dds": {"source": 2}});
        let mut b = textured(&images, json!({"source": 0, "extensions": both}));
        let (scene, warnings) = b.import().expect("a triangle");
        let Surface::MetalRough(surface) = &scene.materials[0].surface else { panic!("not a plain material") };
        assert_eq!(surface.base_color.texture.is_some(), shown, "{warnings:?}");
        let told = |code: &str| -> Vec<String> {
            warnings.iter().filter(|w| w.code == code).map(|w| w.place.to_string()).collect()
        };
        if shown {
            // The image of the first extension comes first, then `source`, then DDS.
            let before = [1, 0, 2].iter().take_while(|image| images[**image] != sound).count();
            assert_eq!(told("texture-fallback"), vec!["/textures/0"; before], "{warnings:?}");
            assert_eq!((told("broken-texture").len(), told("unsupported-texture").len()), (0, 0), "{warnings:?}");
            assert_eq!(scene.images.len(), 1);
        } else {
            assert_eq!(told("unsupported-texture"), ["/images/1"]);
            assert_eq!(told("broken-texture"), ["/images/0", "/images/2"]);
        }
    }
}

#[test]
fn a_survey_knows_sizes_and_kinds_without_decoding() {
    let folder = tempfile::tempdir().expect("a folder");
    let mut deep = std::io::Cursor::new(Vec::new());
    let pixels = image::ImageBuffer::from_pixel(5, 3, image::Rgb([1000_u16, 2000, 3000]));
    image::DynamicImage::from(pixels).write_to(&mut deep, image::ImageFormat::Png).expect("a picture");
    let sound = deep.into_inner();
    for (name, bytes, whole) in [("whole", &sound[..], true), ("damaged", &sound[..sound.len() - 30], false)] {
        let path = folder.path().join(format!("{name}.gltf"));
        let mut b = textured(&[bytes], json!({"source": 0}));
        b.finish();
        std::fs::write(&path, b.doc.to_string()).expect("a file");
        let (options, control) = (ImportOptions::default(), Control::default());
        let survey = survey(&path, &options, &control).expect("a triangle");
        let found = &survey.found().scene;
        let image = &found.images[0];
        assert_eq!((image.width, image.height, found.textures.len()), (5, 3, 2));
        assert!(matches!(&image.pixels, Pixels::Rgba16(p) if p.is_empty()), "{name}");
        assert_eq!(survey.found().warnings.len(), 0, "{name}");
        let imported = import(&path, &options, &control).expect("a triangle");
        assert_eq!(imported.scene.images.len(), usize::from(whole));
        assert_eq!((imported.scene.meshes[0].tangents.len(), found.meshes[0].tangents.len()), (3, 0));
        let equal = imported.scene.meshes[0].positions == found.meshes[0].positions;
        assert!(equal && imported.scene.instances.len() == found.instances.len());
    }
}

#[test]
fn a_survey_has_the_limits_of_an_import() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("a.gltf");
    let mut b = textured(&[&png()], json!({"source": 0}));
    b.finish();
    std::fs::write(&path, b.doc.to_string()).expect("a file");
    let mut options = ImportOptions::default();
    options.limits.max_texels = 3;
    assert!(survey(&path, &options, &Control::default()).is_err());
    options.limits.max_texels = 4;
    assert!(survey(&path, &options, &Control::default()).is_ok());
}

#[test]
fn what_is_opened_has_its_files_and_can_be_finished_without_them() {
    let folder = tempfile::tempdir().expect("a folder");
    let mut b = textured(&[&png()], json!({"source": 0}));
    b.doc["images"][0] = json!({"uri": "a.png"});
    let (asset, image) = (folder.path().join("a.glb"), folder.path().join("a.png"));
    std::fs::write(&asset, b.glb()).expect("a file");
    std::fs::write(&image, png()).expect("a file");
    let (options, control, mut touched) = (ImportOptions::default(), Control::default(), Touched::default());
    let whole = import(&asset, &options, &control).expect("a triangle");
    let opened = open(&asset, &options, &control, &mut touched).expect("a triangle");
    assert_eq!(touched.read.len(), 2, "the image's file has been read");
    std::fs::remove_file(&image).expect("its file");
    let finished = opened.finish(&control, &mut touched).expect("a triangle");
    let shown = |scene: &kiln_formats::Scene| format!("{:?} {:?} {:?}", scene.images, scene.meshes, scene.materials);
    assert_eq!(shown(&finished.scene), shown(&whole.scene));
    assert_eq!((finished.scene.images.len(), finished.scene.meshes[0].tangents.len()), (1, 3));
    assert_eq!(finished.files, whole.files);
}
