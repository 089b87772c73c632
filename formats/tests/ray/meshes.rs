//! `polymesh` and `trimesh`.

use super::{assert_fails, phong, read_in, scene, warnings};
use kiln_formats::ErrorCode::{Invalid, Refused, Syntax};
use kiln_formats::scene::Mesh;
use kiln_formats::{Limits, Scene};

const SQUARE: &str = "points = ((0,0,0),(1,0,0),(1,1,0),(0,1,0));";

fn mesh(fields: &str) -> Mesh {
    let mut scene = scene(&format!("polymesh {{ {fields} }}"));
    assert_eq!((scene.meshes.len(), scene.instances.len()), (1, 1));
    scene.meshes.remove(0)
}

#[test]
fn polygons_become_fans_from_their_first_corner() {
    let points = "points = ((0,0,0),(1,0,0)); points = ((2,1,0),(1,2,0),(0,1,0));";
    let mesh = mesh(&format!("faces = ((1,2,3,4,0)); {points} name = \"house\""));
    assert_eq!(mesh.positions.len(), 5, "repeated lists are appended");
    assert_eq!(mesh.triangles, [[1, 2, 3], [1, 3, 4], [1, 4, 0]]);
    assert_eq!(mesh.name, "house");
    assert!(mesh.normals.is_empty() && mesh.uvs[0].is_empty());
}

#[test]
fn triangles_with_two_equal_corners_are_dropped() {
    let body =
        format!("polymesh {{ {SQUARE} points=((0,0,0)); faces = ((0,0,1),(0,1,2),(1,2,1),(0,1,4),(0,1,1,2)); }}");
    assert_eq!(scene(&body).meshes[0].triangles, [[0, 1, 2], [0, 1, 2]]);
    assert_eq!(warnings(&body), [""; 0]);
    assert_eq!(warnings(&format!("sphere{{}} polymesh {{ {SQUARE} faces=((0,0,1)); }}")), ["empty-mesh"]);
}

#[test]
fn bad_faces_are_refused_with_their_line() {
    let fail = |faces: &str, words: &str| {
        assert_fails(&format!("polymesh {{\n{SQUARE}\nfaces = (\n(0,1,2),\n {faces}); }}"), Invalid, 6, 2, words);
    };
    fail("(0,1,4)", "face (0,1,4) names vertex 4, the mesh has 4 vertices (0..3)");
    fail("(-1,1,2)", "face (-1,1,2) has a negative index");
    fail("(0,1,2,99999999999)", "names vertex 99999999999");
    let syntax = |faces: &str, column, words: &str| {
        assert_fails(&format!("polymesh {{ faces = ({faces}); }}"), Syntax, 2, column, words);
    };
    syntax("(0,1)", 21, "three vertices or more");
    syntax("(0,1,1.5)", 26, "`1.5` is not a vertex index");
    syntax("(0,1,1e300)", 26, "is not a vertex index");
    syntax("(0,1,2),", 29, "`(` was expected, found `)`");
}

#[test]
fn normals_stay_as_they_are() {
    let mesh = mesh(&format!("{SQUARE} normals = ((0,0,.07),(0,1,1),(0,0,1),(0,0,1)); faces=((0,1,2));"));
    assert_eq!(mesh.normals[..2], [[0.0, 0.0, 0.07], [0.0, 1.0, 1.0]]);
    let few = format!("polymesh {{ {SQUARE} normals = ((0,0,1)); faces=((0,1,2)); }}");
    assert_fails(&few, Invalid, 2, 1, "the mesh has 1 normals for 4 points");
}

#[test]
fn generated_normals_are_means_of_unit_face_normals() {
    // A roof ridge: one side in z = 0 (large), the other in x = 0 (small); the ridge lies along y.
    let roof = "points = ((0,0,0),(0,1,0),(9,0,0),(0,0,1),(5,5,5)); faces = ((0,2,1),(0,1,3),(0,1,1));";
    for word in [
        "gennormals;",
        "gennormals",
        "gennormals = true;",
        "normals=((1,0,0),(1,0,0),(1,0,0),(1,0,0),(1,0,0)); gennormals;",
    ] {
        let mesh = mesh(&format!("{word} {roof}"));
        assert_eq!(mesh.normals[0], [0.5, 0.0, 0.5], "not weighted by area");
        assert_eq!(mesh.normals[2], [0.0, 0.0, 1.0]);
        assert_eq!(mesh.normals[3], [1.0, 0.0, 0.0]);
        assert!(mesh.normals[4].iter().all(|x| x.is_finite()), "a point without faces");
    }
    assert!(mesh(&format!("gennormals = false; {roof}")).normals.is_empty());
}

#[test]
fn generated_normals_survive_faces_without_area() {
    let mesh = mesh("points=((0,0,0),(1,0,0),(2,0,0),(0,1,0)); faces=((0,1,2),(0,1,3),(0,3,1)); gennormals;");
    assert!(mesh.normals.iter().flatten().all(|x| x.is_finite()));
    assert_ne!(mesh.normals[0], [0.0; 3], "opposite faces cancel out, and one of them holds");
    let tiny = self::mesh("points=((0,0,0),(1e-30,0,0),(0,1e-30,0)); faces=((0,1,2)); gennormals;");
    assert_eq!(tiny.normals, [[0.0, 0.0, 1.0]; 3]);
}

#[test]
fn texture_coordinates_of_all_forks_are_turned_upside_down() {
    for word in ["texture_uv", "map_points", "tex_coords"] {
        let mesh =
            mesh(&format!("{SQUARE} has_tex_coords = true; {word} = ((0,0),(1,0),(1,1),(0,.25)); faces=((0,1,2));"));
        assert_eq!(mesh.uvs[0], [[0.0, 1.0], [1.0, 1.0], [1.0, 0.0], [0.0, 0.75]], "{word}");
    }
    let few = format!("polymesh {{ {SQUARE} map_points=((0,0)); faces=((0,1,2)); }}");
    assert_fails(&few, Invalid, 2, 1, "1 texture coordinates for 4 points");
}

fn vertex_diffuse(scene: &Scene) -> Vec<[f32; 3]> {
    scene.meshes[0].vertex_materials.iter().map(|m| phong(&scene.materials[*m as usize]).diffuse.factor).collect()
}

#[test]
fn materials_per_vertex_start_from_the_meshs_material_as_read_so_far() {
    let triangle = "points=((0,0,0),(1,0,0),(0,1,0)); faces=((0,1,2));";
    let scene = scene(&format!(
        "material = {{ diffuse=(1,1,1); shininess=7 }} polymesh {{ {triangle} \
         materials = ( {{}} ); material = {{ diffuse=(1,0,0) }}; \
         materials = ( {{ specular=(0,0,1) }}, {{ diffuse=(0,1,0); }} ); material = {{ diffuse=(0,0,0) }} }}"
    ));
    assert_eq!(vertex_diffuse(&scene), [[1.0, 1.0, 1.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]);
    let own = &scene.materials[scene.meshes[0].material as usize];
    assert_eq!(phong(own).diffuse.factor, [0.0; 3]);
    let shares = |m: &u32| phong(&scene.materials[*m as usize]).exponent.factor == 7.0;
    assert!(scene.meshes[0].vertex_materials.iter().all(shares));
    let few = format!("polymesh {{ {triangle} materials=({{}}); }}");
    assert_fails(&few, Invalid, 2, 1, "1 materials for 3 points");
    assert_fails("polymesh { materials=({},); }", Syntax, 2, 26, "a material in `{ }`");
}

#[test]
fn emission_is_the_meshs_own() {
    let body = "polymesh { material={emissive=(2,2,2)} points=((0,0,0),(1,0,0),(0,1,0)); faces=((0,1,2)); \
                materials=({emissive=(1,0,0)},{emissive=(0,1,0)},{}); }";
    let scene = scene(body);
    assert!(scene.materials.iter().all(|m| m.emission.factor == [2.0; 3]));
    assert_eq!(warnings(body), ["vertex-emission"]);
}

#[test]
fn an_obj_file_gives_points_and_faces() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let obj = "# square\r\nv 0 0 0\r\nv 1 0 0 1.0\nv 1 1 0\nv 0 1 0\nvt 0 0\nusemtl red\nf 1/1 2/1/1 3//1 -1\n";
    std::fs::write(folder.path().join("a.obj"), obj).expect("a file");
    std::fs::write(folder.path().join("bad.obj"), "v 0 0\n").expect("a file");
    std::fs::write(folder.path().join("far.obj"), "v 0 0 0\nf 1 2 3\n").expect("a file");
    let read = |file: &str| {
        let text = format!("SBT-raytracer 1.0\ntranslate(1,0,0,polymesh {{ objfile = \"{file}\"; }})");
        read_in(folder.path(), text.as_bytes(), Limits::default())
    };
    let (scene, _) = read("a.obj").expect("a square");
    assert_eq!(scene.meshes[0].triangles, [[0, 1, 2], [0, 2, 3]]);
    let bad = read("bad.obj").expect_err("two numbers");
    assert!(bad.code == Syntax && bad.message.contains("line 1: a vertex needs three numbers"), "{bad}");
    assert_eq!(read("far.obj").expect_err("no such point").code, Invalid);
    assert_eq!(read("../../../../../../etc/passwd").expect_err("outside").code, Refused);
}
