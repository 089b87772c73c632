//! MTL files at the level of meaning.

#![allow(clippy::disallowed_methods, reason = "expected values may come from std's functions")]

use image::{Rgba, RgbaImage};
use kiln_formats::scene::{AlphaMode, Channel, ColorSpace, Material, MetalRough, Pixels, Surface, Wrap};
use kiln_formats::{Control, ErrorCode, ImportOptions, Imported, Limits, import};
use std::path::Path;

const OBJ: &str = "mtllib a.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl m\nf 1 2 3\n";

fn import_in(folder: &Path, obj: &str, mtl: &str) -> Imported {
    let folder = folder.join("asset");
    std::fs::create_dir_all(&folder).unwrap();
    std::fs::write(folder.join("asset.obj"), obj).unwrap();
    std::fs::write(folder.join("a.mtl"), mtl).unwrap();
    import(&folder.join("asset.obj"), &ImportOptions::default(), &Control::default()).unwrap()
}

fn with(statements: &str) -> Imported {
    let folder = tempfile::tempdir().unwrap();
    import_in(folder.path(), OBJ, &format!("newmtl m\n{statements}"))
}

fn codes(imported: &Imported) -> Vec<&str> {
    imported.warnings.iter().map(|w| w.code.as_str()).collect()
}

fn material(imported: &Imported) -> (&Material, &MetalRough) {
    let material = &imported.scene.materials[0];
    let Surface::MetalRough(surface) = &material.surface else { panic!("{material:?}") };
    (material, surface)
}

fn close(a: f32, b: f32) -> bool {
    (a - b).abs() < 1e-5
}

#[test]
fn without_specular_colour_it_is_exactly_lambert() {
    for statements in ["Kd 0.5 0.25 1", "Kd 0.5 0.25 1\nKs 0 0 0\nNs 100", "Kd 0.5 0.25 1\nKs 1 1 1\nillum 1"] {
        let imported = with(statements);
        let (material, surface) = material(&imported);
        assert_eq!(surface.base_color.factor, [0.5, 0.25, 1.0]);
        assert_eq!((surface.specular.factor, surface.metallic.factor), (0.0, 0.0), "{statements}");
        assert_eq!(surface.transmission.factor, 0.0);
        assert!(material.double_sided && !material.emission_two_sided);
        assert_eq!(codes(&imported), [] as [&str; 0]);
    }
}

#[test]
fn legal_oddities_do_no_harm() {
    let imported = with("Ka\nKd\t0.5 # grey\nKs\nNs\nillum\nd\nmap_Kd\nKe  \nNi x");
    assert_eq!(material(&imported).1.base_color.factor, [0.5; 3]);
    assert_eq!(codes(&imported), [] as [&str; 0]);
    let unknown = with("Kd 1 0 0\nfrobnicate 3\nfrobnicate 4\nKa 1 1 1\nsharpness 60\nPs 0\nKd spectral x.rfl");
    assert_eq!(codes(&unknown), ["unsupported-statement", "unsupported-statement"]);
    assert_eq!(material(&unknown).1.base_color.factor, [1.0, 0.0, 0.0]);
}

#[test]
fn phong_exponents_become_roughness() {
    let imported = with("Kd 0 0 0\nKs 0.4 0.2 0\nNs 6");
    let (_, surface) = material(&imported);
    // α = √(2/8) = 1/2, roughness = √α.
    assert!(close(surface.roughness.factor, 0.5_f32.sqrt()));
    assert!(close(surface.specular.factor, 0.4));
    assert!(close(surface.specular_color.factor[1], 0.5) && surface.specular_color.factor[2] == 0.0);
}

#[test]
fn mirrors_and_metals() {
    let mirror = with("Kd 0.01 0.01 0.01\nKs 0.95 0.9 0.5\nNs 1000\nillum 5");
    let (_, surface) = material(&mirror);
    assert_eq!((surface.metallic.factor, surface.roughness.factor), (1.0, 0.0));
    assert_eq!(surface.base_color.factor, [0.95, 0.9, 0.5]);
    let metal = with("Kd 0.9 0.6 0.2\nPr 0.3\nPm 1\nNs 10\nKs 1 1 1");
    let (_, surface) = material(&metal);
    assert_eq!((surface.metallic.factor, surface.roughness.factor), (1.0, 0.3));
    assert_eq!(surface.base_color.factor, [0.9, 0.6, 0.2]);
}

#[test]
fn glass_is_solid_and_bends() {
    let d = with("Kd 0.5 1 1\nKs 1 1 1\nNi 1.4\nd 0.25\nillum 7");
    let (material_d, surface) = material(&d);
    assert!(close(surface.transmission.factor, 0.75) && surface.ior == 1.4 && surface.volume.is_some());
    assert_eq!(surface.base_color.factor, [0.5, 1.0, 1.0]);
    assert_eq!(material_d.alpha.mode, AlphaMode::Opaque);
    // Tf is the share of the light that comes through.
    let filter = with("Kd 0.1 0.1 0.1\nTf 0 0.3 0.3\nNi 2.5\nillum 7");
    let (_, surface) = material(&filter);
    let through: Vec<f32> = surface.base_color.factor.iter().map(|b| b * surface.transmission.factor).collect();
    assert!(close(through[1], 0.3) && close(surface.transmission.factor, 0.75));
    // Maya writes this for opaque bodies.
    let maya = with("illum 4\nKd 0.5 0.5 0.5\nTf 1.00 1.00 1.00\nNi 1.00");
    assert_eq!(material(&maya).1.transmission.factor, 0.0);
    assert_eq!(material(&maya).0.alpha.mode, AlphaMode::Opaque);
}

#[test]
fn dissolve_and_its_opposite() {
    for (statements, alpha) in [
        ("d 0.25", 0.25),
        ("Tr 0.75", 0.25),
        ("d 0.25\nTr 0.25", 0.25),
        ("d -halo 0.25", 0.25),
        ("Tr 0", 1.0),
        ("d 1\nTr 1", 1.0),
        ("Tr 1", 1.0),
    ] {
        let imported = with(&format!("Kd 1 1 1\n{statements}"));
        let (material, _) = material(&imported);
        let mode = if alpha < 1.0 { AlphaMode::Blend } else { AlphaMode::Opaque };
        assert_eq!((material.alpha.mode, material.alpha.value.factor), (mode, alpha), "{statements}");
    }
}

fn picture(path: &Path, pixel: [u8; 4]) {
    RgbaImage::from_pixel(2, 2, Rgba(pixel)).save(path).unwrap();
}

#[test]
fn textures_of_all_kinds() {
    let folder = tempfile::tempdir().unwrap();
    let asset = folder.path().join("asset");
    std::fs::create_dir_all(asset.join("tex tures")).unwrap();
    picture(&asset.join("tex tures/my color.png"), [255, 0, 0, 255]);
    picture(&asset.join("normal.png"), [128, 127, 255, 255]);
    picture(&asset.join("height.png"), [90, 90, 90, 255]);
    picture(&asset.join("leaf.png"), [0, 255, 0, 128]);
    std::fs::write(asset.join("broken.png"), b"\x89PNG\r\n\x1a\nnothing").unwrap();
    let face = "f 1/1/1 2/2/1 3/3/1";
    let obj = format!(
        "mtllib a.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 0 1\nvn 0 0 1\nusemtl a\n{face}\nusemtl b\n{face}\nusemtl c\n{face}\nusemtl d\n{face}\n"
    );
    let mtl =
        "newmtl a\nKd 0 0 0\nmap_Kd -s 2 2 -clamp on tex tures\\my color.png\nmap_Bump normal.png\nmap_Ke MY COLOR.PNG
newmtl b\nmap_Kd C:\\somewhere\\else\\leaf.png\nbump height.png\nmap_d -imfchan g leaf.png
newmtl c\nmap_Kd leaf.png\nmap_Pr -imfchan b normal.png\nnorm -bm 0.5 normal.png
newmtl d\nmap_Kd missing.png\nmap_Ks broken.png\nmap_d height.png\nd 0.5
newmtl unused\nmap_Kd nobody.png\n";
    // A second name of the first image.
    std::fs::hard_link(asset.join("tex tures/my color.png"), asset.join("my color.png")).unwrap();
    let imported = import_in(folder.path(), &obj, mtl);
    let mut told = codes(&imported);
    told.sort_unstable();
    assert_eq!(told, ["broken-texture", "missing-texture"]);
    let scene = &imported.scene;
    let image_of = |reference: kiln_formats::scene::TextureRef| {
        let texture = scene.textures[reference.texture as usize];
        (scene.images[texture.image as usize].name.as_str(), texture.color_space, texture.wrap_u)
    };
    let surface = |i: usize| match &scene.materials[i].surface {
        Surface::MetalRough(surface) => *surface,
        other => panic!("{other:?}"),
    };
    let [a, b, c, d] = [0, 1, 2, 3].map(|i| &scene.materials[i]);
    assert_eq!([a, b, c, d].map(|m| m.name.as_str()), ["a", "b", "c", "d"]);
    // a: black Kd before a texture is white; options; a normal map under the name of a bump map.
    let base = surface(0).base_color;
    assert_eq!(base.factor, [1.0; 3]);
    assert_eq!(image_of(base.texture.unwrap()), ("tex tures\\my color.png", ColorSpace::Srgb, Wrap::Clamp));
    assert_eq!(base.texture.unwrap().transform.apply([0.5, 0.5]), [1.0, 0.0]);
    assert_eq!(image_of(a.normal_map.unwrap().texture).1, ColorSpace::Linear);
    assert_eq!((a.emission.factor, a.alpha.mode), ([1.0; 3], AlphaMode::Opaque));
    // b: a foreign folder; alpha by the channel named.
    assert_eq!(image_of(surface(1).base_color.texture.unwrap()).0, "C:\\somewhere\\else\\leaf.png");
    assert_eq!((b.alpha.mode, b.alpha.value.channel), (AlphaMode::Blend, Channel::G));
    // A level height map bends nothing.
    let normals = &scene.images[scene.textures[b.normal_map.unwrap().texture.texture as usize].image as usize];
    let Pixels::Rgba16(normals) = &normals.pixels else { panic!("normals have 16 bits") };
    assert_eq!(normals[..4], [32768, 32768, 65535, 65535]);
    // c: the colour's own alpha; PBR maps.
    assert_eq!((c.alpha.mode, c.alpha.value.channel, c.alpha.value.factor), (AlphaMode::Blend, Channel::A, 1.0));
    assert_eq!((surface(2).roughness.channel, surface(2).roughness.factor), (Channel::B, 1.0));
    assert_eq!(c.normal_map.unwrap().scale, 0.5);
    // d: what cannot be loaded leaves the factor; a grey map_d counts by its red.
    assert_eq!((surface(3).base_color.factor, surface(3).base_color.texture), ([0.8; 3], None));
    assert_eq!((d.alpha.value.channel, d.alpha.value.factor), (Channel::R, 0.5));
    // Each file is decoded once (the hard link is a file of its own), those of unused materials not at all.
    // The normals of the height map are one more.
    assert_eq!(scene.images.len(), 6);
}

#[test]
fn pbr_fields_are_layers() {
    let mtl = "newmtl m\nPr 0.3\nPm 0.1\nPs 0.4\nPc 0.5\nPcr 0.03\naniso 0.6\nanisor 0.25\n";
    let folder = tempfile::tempdir().unwrap();
    let imported = import_in(
        folder.path(),
        "mtllib a.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 0 1\nusemtl m\nf 1/1 2/2 3/3\n",
        mtl,
    );
    assert_eq!(codes(&imported), [] as [&str; 0]);
    let layers = imported.scene.materials[0].layers().expect("has some");
    assert_eq!((layers.clearcoat.factor, layers.clearcoat_roughness.factor), (0.5, 0.03));
    assert_eq!((layers.sheen_color.factor, layers.sheen_roughness.factor), ([0.4; 3], 0.3));
    assert_eq!((layers.anisotropy, layers.anisotropy_rotation), (0.6, std::f32::consts::FRAC_PI_2));
    // A grain needs tangents, and those need normals: the file's flat face gets both.
    let mesh = &imported.scene.meshes[0];
    assert_eq!((mesh.normals[0], mesh.tangents[0]), ([0.0, 0.0, 1.0], [1.0, 0.0, 0.0, 1.0]));
    let plain = with("Ps 0\nPc 0\naniso 0\n");
    assert!(plain.scene.materials[0].layers().is_none());
}

#[test]
fn libraries_are_found_by_their_names() {
    let folder = tempfile::tempdir().unwrap();
    let asset = folder.path().join("asset");
    std::fs::create_dir_all(asset.join("sub")).unwrap();
    std::fs::write(asset.join("my red.mtl"), "newmtl red\nKd 1 0 0").unwrap();
    std::fs::write(asset.join("sub/green.mtl"), "newmtl green\nKd 0 1 0\nmap_Kd t.png").unwrap();
    picture(&asset.join("sub/t.png"), [1, 2, 3, 255]);
    let faces = "v 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl red\nf 1 2 3\nusemtl green\nf 1 2 3\nusemtl blue\nf 1 2 3\n";
    for libraries in [
        "mtllib my red.mtl sub/green.mtl a.mtl",
        "mtllib my\\ red.mtl\nmtllib C:\\x\\sub\\a.mtl\nmtllib sub\\green.mtl",
    ] {
        let imported = import_in(folder.path(), &format!("{libraries}\n{faces}"), "newmtl blue\nKd 0 0 1");
        assert_eq!(codes(&imported), [] as [&str; 0], "{libraries}");
        let base = |i: usize| match &imported.scene.materials[i].surface {
            Surface::MetalRough(surface) => surface.base_color.factor,
            other => panic!("{other:?}"),
        };
        assert_eq!([base(0), base(1), base(2)], [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]], "{libraries}");
        assert_eq!(imported.scene.images.len(), 1);
    }
    let missing = import_in(folder.path(), &format!("mtllib gone.mtl\n{faces}"), "");
    assert_eq!(codes(&missing), ["missing-material-library"]);
    let names: Vec<&str> = missing.scene.materials.iter().map(|m| m.name.as_str()).collect();
    assert_eq!(names, ["red", "green", "blue"]);
    std::fs::write(asset.join("asset.mtl"), "newmtl RED\nKd 1 0 0\nnewmtl green\nnewmtl blue").unwrap();
    let renamed = import_in(folder.path(), &format!("mtllib gone.mtl\n{faces}"), "");
    assert_eq!(codes(&renamed), ["missing-material-library"]);
    let names: Vec<&str> = renamed.scene.materials.iter().map(|m| m.name.as_str()).collect();
    assert_eq!(names, ["RED", "green", "blue"], "of the file that has the asset's name, in any case");
    let unknown = import_in(folder.path(), &format!("mtllib my red.mtl\n{faces}"), "");
    assert_eq!(codes(&unknown), ["missing-material", "missing-material"]);
}

#[test]
fn texel_limits_hold_for_all_images_together() {
    let folder = tempfile::tempdir().unwrap();
    picture(&folder.path().join("a.png"), [1, 2, 3, 255]);
    picture(&folder.path().join("b.png"), [1, 2, 3, 255]);
    let path = folder.path().join("asset.obj");
    std::fs::write(&path, OBJ).unwrap();
    std::fs::write(folder.path().join("a.mtl"), "newmtl m\nmap_Kd a.png\nmap_Ke b.png").unwrap();
    let run = |max_texels| {
        let limits = Limits { max_texels, ..Limits::default() };
        import(&path, &ImportOptions { limits, ..ImportOptions::default() }, &Control::default())
    };
    assert_eq!(run(7).unwrap_err().code, ErrorCode::TooLarge);
    let sound = run(8).unwrap();
    assert_eq!(sound.scene.images.len(), 2);
    // The asset, its library and its images, for whoever wants to know when to render anew.
    assert_eq!(sound.files.len(), 4);
}
