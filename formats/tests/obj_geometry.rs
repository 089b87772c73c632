//! OBJ geometry at the level of meaning: small files, and what the scene says of them.

#![allow(clippy::disallowed_methods, reason = "expected values may come from std's functions")]

use kiln_formats::scene::{Mesh, Scene};
use kiln_formats::{Control, ErrorCode, ImportError, ImportOptions, Imported, Limits, import};

fn import_bytes(bytes: &[u8]) -> Result<Imported, ImportError> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("asset.obj");
    std::fs::write(&path, bytes).unwrap();
    import(&path, &ImportOptions::default(), &Control::default())
}

fn read(text: &str) -> Imported {
    import_bytes(text.as_bytes()).unwrap_or_else(|e| panic!("{e}\n{text}"))
}

fn error(text: &str) -> ImportError {
    import_bytes(text.as_bytes()).unwrap_err()
}

fn codes(imported: &Imported) -> Vec<(&str, &str)> {
    imported.warnings.iter().map(|w| (w.code.as_str(), w.place.as_str())).collect()
}

/// World positions of the corners of all triangles.
fn corners(scene: &Scene) -> Vec<[f64; 3]> {
    let corners = scene.instances.iter().flat_map(|instance| {
        let mesh = &scene.meshes[instance.mesh as usize];
        let place = |i: &u32| glam::Vec3::from(mesh.positions[*i as usize]).as_dvec3();
        mesh.triangles.iter().flatten().map(move |i| instance.transform.transform_point3(place(i)).to_array())
    });
    corners.collect()
}

fn only_mesh(imported: &Imported) -> &Mesh {
    assert_eq!(imported.scene.meshes.len(), 1);
    &imported.scene.meshes[0]
}

const TRIANGLE: &str = "v 0 0 0\nv 1 0 0\nv 0 1 0\n";

#[test]
fn every_way_to_write_an_index_means_the_same() {
    let data = "v 9 9 9\nv 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 0 1\nvn 0 0 1\n";
    let want = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
    let faces = [
        ("f 2 3 4", false, false),
        ("f -3 -2 -1", false, false),
        ("f 2/1 3/2 4/3", true, false),
        ("f 2//1 3//1 4//1", false, true),
        ("f 2/1/1 3/2/1 4/3/1", true, true),
        ("f -3/-3/-1 -2/-2/-1 -1/-1/-1", true, true),
        ("f 2/ 3/ 4/", false, false),
        ("f 2// 3// 4// # comment", false, false),
        ("f\t+2  3\t4\r", false, false),
        ("fo 2 3 4", false, false),
        ("f 2 \\\n3 \\\n4", false, false),
    ];
    for (face, uvs, normals) in faces {
        let imported = read(&format!("{data}{face}"));
        assert_eq!(corners(&imported.scene), want, "{face}");
        let mesh = only_mesh(&imported);
        assert_eq!((!mesh.uvs[0].is_empty(), !mesh.normals.is_empty()), (uvs, normals), "{face}");
        assert_eq!(codes(&imported), [], "{face}");
    }
    // Forward references are legal too, and negative ones count from where they stand.
    let ahead = read("v 0 0 0\nf 1 2 3\nf -1 2 3\ng other\nv 1 0 0\nv 0 1 0\n");
    assert_eq!(corners(&ahead.scene), [want, want].concat());
}

#[test]
fn texture_coordinates_are_turned_downwards() {
    let imported = read(&format!("{TRIANGLE}vt 0 0\nvt 1 0.25\nvt 0.5\nf 1/1 2/2 3/3"));
    assert_eq!(only_mesh(&imported).uvs[0], [[0.0, 1.0], [1.0, 0.75], [0.5, 1.0]]);
}

#[test]
fn attributes_that_some_corners_lack_are_left_out_of_that_face() {
    let text = format!("{TRIANGLE}vt 0 0\nvn 0 0 2\nvn 0 0 0\nf 1/1/1 2/1/1 3/1/1\nf 1/1/1 2//1 3/1\nf 1//1 2//1 3//2");
    let imported = read(&text);
    let kinds: Vec<(bool, bool, usize)> =
        imported.scene.meshes.iter().map(|m| (m.uvs[0].is_empty(), m.normals.is_empty(), m.triangles.len())).collect();
    assert_eq!(kinds, [(false, false, 1), (true, true, 2)]);
    assert_eq!(imported.scene.meshes[0].normals[0], [0.0, 0.0, 1.0]);
}

#[test]
fn broken_statements_cost_their_faces_and_name_their_lines() {
    let good = format!("{TRIANGLE}v nan 0 0\nv 1 2\nv 1e39 0 0\nf 1 2 3\n");
    let vertices = [("bad-vertex", "4"), ("bad-vertex", "5"), ("bad-vertex", "6")];
    let faces = [
        ("f 1 2 7", "bad-index"),
        ("f 0 1 2", "bad-index"),
        ("f 1 2 -7", "bad-index"),
        ("f 1 2 99999999999999999999999", "bad-index"),
        ("f 1 2 4", "bad-index"),
        ("f 3 2 5", "bad-index"),
        ("f 3 2 6", "bad-index"),
        ("f 1 2 x", "bad-index"),
        ("f 1 2 3.0", "bad-index"),
        ("f 1/2/3/4 2 3", "bad-face"),
        ("f 1 2", "bad-face"),
        ("f", "bad-face"),
    ];
    for (face, code) in faces {
        let imported = read(&format!("{good}{face}\n"));
        assert_eq!(codes(&imported), [&vertices[..], &[(code, "8")]].concat(), "{face}");
        assert_eq!(imported.scene.triangle_count(), 1, "{face}");
    }
    let without_uv = read(&format!("{TRIANGLE}vt 0 0\nf 1/1 2/5 3/1"));
    assert_eq!(codes(&without_uv), [("bad-index", "5")]);
    assert!(only_mesh(&without_uv).uvs[0].is_empty());
}

#[test]
fn a_million_faults_give_few_warnings() {
    let mut text = format!("{TRIANGLE}f 1 2 3\n");
    text.push_str(&"f 1 2 9\n".repeat(100_000));
    let imported = read(&text);
    assert!(imported.warnings.len() < 12);
    assert!(imported.warnings.last().unwrap().message.contains("99992 more"));
}

#[test]
fn errors_say_what_and_where() {
    assert_eq!(error("").code, ErrorCode::Empty);
    assert_eq!(error("# nothing\nv 0 0 0\np 1\n").code, ErrorCode::Empty);
    let invalid = error(&format!("{TRIANGLE}\nf 1 2 4\nf 1 2 5\n"));
    assert_eq!((invalid.code, invalid.place.to_string().as_str()), (ErrorCode::Invalid, "5"));
    let ahead = error("v 0 0 0\nf 1 2 4\nf x\n");
    assert_eq!((ahead.code, ahead.place.to_string().as_str()), (ErrorCode::Invalid, "2"));
    assert_eq!(import_bytes(&[0, 1, 2, 3, 255, 254].repeat(50)).unwrap_err().code, ErrorCode::Syntax);
}

#[test]
fn limits_and_stop_are_obeyed() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("asset.obj");
    std::fs::write(&path, format!("{TRIANGLE}{}", "f 1 2 3 1 2 3 1 2 3 1\n".repeat(20_000))).unwrap();
    let limits = Limits { max_triangles: 1000, ..Limits::default() };
    let options = ImportOptions { limits, ..ImportOptions::default() };
    assert_eq!(import(&path, &options, &Control::default()).unwrap_err().code, ErrorCode::TooLarge);
    let control = Control::default();
    control.stop();
    assert_eq!(import(&path, &ImportOptions::default(), &control).unwrap_err().code, ErrorCode::Stopped);
}

#[test]
fn one_mesh_for_each_material_over_the_whole_file() {
    let text = format!(
        "{TRIANGLE}v 1 1 0\no chair\nusemtl wood\nf 1 2 3\nusemtl steel\nf 1 2 4\no table\nusemtl wood\nf 2 3 4\nusemtl steel\nf 1 3 4"
    );
    let imported = read(&text);
    let scene = &imported.scene;
    let told: Vec<(&str, &str, usize)> = scene
        .meshes
        .iter()
        .map(|m| (m.name.as_str(), scene.materials[m.material as usize].name.as_str(), m.triangles.len()))
        .collect();
    assert_eq!(told, [("chair", "wood", 2), ("chair", "steel", 2)]);
    // Vertices are shared within a mesh.
    assert_eq!(scene.meshes[0].positions.len(), 4);
}

#[test]
fn what_is_not_drawn_is_told() {
    let text = format!(
        "{TRIANGLE}f 1 2 3\nl 1 2 3\nl 1 2\np 1 2\ncstype bezier\nsurf 0 1 0 1 1 2 3\nend\nfrobnicate 1\nfrobnicate 2\n"
    );
    let imported = read(&text);
    let mut told = codes(&imported);
    told.sort_unstable();
    let want = [
        ("points-or-lines-not-drawn", "5"),
        ("points-or-lines-not-drawn", "7"),
        ("unknown-statement", "11"),
        ("unsupported-element", "9"),
    ];
    assert_eq!(told, want);
}

#[test]
fn far_coordinates_keep_their_fractions() {
    let text = "v 500000.25 0.5 -4000000.125\nv 500001.375 0.5 -4000000.125\nv 500000.25 1.5 -4000000.125\nf 1 2 3";
    let imported = read(text);
    let want = [[500000.25, 0.5, -4000000.125], [500001.375, 0.5, -4000000.125], [500000.25, 1.5, -4000000.125]];
    for (got, want) in corners(&imported.scene).iter().zip(want) {
        assert!(got.iter().zip(want).all(|(g, w)| (g - w).abs() < 1e-6), "{got:?} {want:?}");
    }
    let largest = imported.scene.meshes[0].positions.as_flattened().iter().fold(0.0_f32, |a, b| a.max(b.abs()));
    assert!(largest < 1.0);
    let near = read(&format!("{TRIANGLE}f 1 2 3"));
    assert_eq!(near.scene.instances[0].transform, glam::DAffine3::IDENTITY);
}

#[test]
fn weights_divide_and_colors_are_decoded() {
    let weighted = read("v 2 4 6 2\nv 1 0 0 1\nv 0 1 0 0\nf 1 2 3");
    assert_eq!(only_mesh(&weighted).positions, [[1.0, 2.0, 3.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]);
    assert!(only_mesh(&weighted).colors.is_empty());
    // IEC 61966-2-1: 0.5 is 0.21404 in linear light. A vertex without a colour, or with a broken one, is white.
    let colored = read("v 0 0 0\nv 1 0 0 0.5 0 1\nv 0 1 0 nan 0 0\nv 2 2 2 2\nf 1 2 3 4");
    let mesh = only_mesh(&colored);
    let want = [[1.0; 4], [0.21404, 0.0, 1.0, 1.0], [1.0; 4], [1.0; 4]];
    for (got, want) in mesh.colors.iter().zip(want) {
        assert!(got.iter().zip(want).all(|(g, w)| (g - w).abs() < 1e-4), "{:?}", mesh.colors);
    }
    assert_eq!(mesh.positions[3], [1.0; 3]);
    let bytes = read("v 0 0 0 255 0 0\nv 1 0 0 255 0 0\nv 0 1 0 255 0 0\nf 1 2 3");
    assert_eq!(only_mesh(&bytes).colors, [[1.0, 0.0, 0.0, 1.0]; 3]);
}

#[test]
fn concave_polygons_keep_their_area() {
    // An arrow of area 1.5 with a notch, in the plane z = 3.
    let imported = read("v 0 0 3\nv 2 0 3\nv 2 2 3\nv 1 0.5 3\nv 0 2 3\nf 1 2 3 4 5");
    let corners = corners(&imported.scene);
    let area: f64 = corners
        .chunks(3)
        .map(|t| {
            let [a, b, c] = [t[0], t[1], t[2]].map(glam::DVec3::from);
            let cross = (b - a).cross(c - a);
            assert!(cross.z >= 0.0, "a triangle is turned over");
            0.5 * cross.length()
        })
        .sum();
    assert!((area - 2.5).abs() < 1e-9, "{area}");
    assert_eq!(imported.scene.triangle_count(), 3);
}

#[test]
fn any_encoding_reads_the_same() {
    let text = format!("{TRIANGLE}o Stühle\nf 1 2 3\n");
    let utf16: Vec<u8> = [0xff, 0xfe].into_iter().chain(text.encode_utf16().flat_map(u16::to_le_bytes)).collect();
    let latin1: Vec<u8> = text.chars().map(|c| c as u8).collect();
    let mac = text.replace('\n', "\r").into_bytes();
    let dos = text.replace('\n', "\r\n").into_bytes();
    for bytes in [text.into_bytes(), utf16, latin1, mac, dos] {
        let imported = import_bytes(&bytes).unwrap();
        assert_eq!(only_mesh(&imported).name, "Stühle");
        assert_eq!(corners(&imported.scene)[1], [1.0, 0.0, 0.0]);
    }
}

/// A ridge of two squares at a right angle, with the texture coordinates of its edge differing between them.
const RIDGE: &str = "v 0 0 0\nv 0 1 0\nv 1 0 0\nv 1 1 0\nv 0 0 -1\nv 0 1 -1\nvt 0 0\nvt 1 0\nvt 0 1\nvt 1 1\n";

#[test]
fn smoothing_groups_make_normals_within_themselves() {
    let normals_on_the_edge = |faces: &str| {
        let scene = read(&format!("{RIDGE}{faces}")).scene;
        let mut found: Vec<[f32; 3]> = Vec::new();
        for mesh in &scene.meshes {
            assert!(mesh.normals.len() == mesh.positions.len() || mesh.normals.is_empty());
            let on_edge = |p: &[f32; 3]| p[0] == 0.0 && p[2] == 0.0;
            found.extend(mesh.positions.iter().zip(&mesh.normals).filter(|(p, _)| on_edge(p)).map(|(_, n)| *n));
        }
        found.sort_by(|a, b| a.partial_cmp(b).unwrap());
        found.dedup();
        found
    };
    let [front, side] = ["f 1/1 3/2 4/4 2/3\n", "f 5/1 1/2 2/4 6/3\n"];
    let half = -std::f32::consts::FRAC_1_SQRT_2;
    let close = |found: &[[f32; 3]], want: &[[f32; 3]]| {
        assert_eq!(found.len(), want.len(), "{found:?}");
        assert!(found.as_flattened().iter().zip(want.as_flattened()).all(|(f, w)| (f - w).abs() < 1e-6), "{found:?}");
    };
    close(&normals_on_the_edge(&format!("s 1\n{front}{side}")), &[[half, 0.0, -half]]);
    // A change of material is no crease; a triangle joins a square.
    let cut = format!("s 7\nusemtl a\n{front}usemtl b\nf 5/1 1/2 2/4\nf 5/1 2/4 6/3\n");
    close(&normals_on_the_edge(&cut), &[[half, 0.0, -half]]);
    // Different groups, of which the second is declared by the word.
    close(&normals_on_the_edge(&format!("s 2\n{front}s on\n{side}")), &[[-1.0, 0.0, 0.0], [0.0, 0.0, 1.0]]);
    assert!(normals_on_the_edge(&format!("{front}{side}")).is_empty(), "none: flat");
    assert!(normals_on_the_edge(&format!("s 1\ns off\n{front}{side}")).is_empty());
    // Given normals win.
    let given = "vn 0 1 0\ns 1\nf 1//1 3//1 4//1 2//1\n";
    close(&normals_on_the_edge(given), &[[0.0, 1.0, 0.0]]);
    let warned = read(&format!("{RIDGE}s soft\n{front}")).warnings;
    assert_eq!(warned.iter().map(|w| w.code.as_str()).collect::<Vec<_>>(), ["bad-smoothing-group"]);
}
