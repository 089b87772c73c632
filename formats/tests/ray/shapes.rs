//! Primitives as triangles: closed, turned outward, and as near to the true shapes as nobody sees.

use super::{diffuse_of_instances, scene, warnings};
use glam::{DVec3, Vec3};
use kiln_formats::scene::Mesh;
use std::collections::HashMap;
use std::f64::consts::PI;

fn shape(text: &str) -> Mesh {
    let mut scene = scene(text);
    assert_eq!(scene.meshes.len(), 1);
    scene.meshes.remove(0)
}

fn corners(mesh: &Mesh) -> impl Iterator<Item = [DVec3; 3]> + '_ {
    let point = |i: u32| Vec3::from_array(mesh.positions[i as usize]).as_dvec3();
    mesh.triangles.iter().map(move |t| t.map(point))
}

/// The volume inside a closed mesh; negative when it is turned inside out.
fn volume(mesh: &Mesh) -> f64 {
    corners(mesh).map(|[a, b, c]| a.dot(b.cross(c)) / 6.0).sum()
}

/// Edges, by position, that have no partner running the other way.
fn open_edges(mesh: &Mesh) -> usize {
    let mut balance: HashMap<[[u32; 3]; 2], i64> = HashMap::new();
    // −0 and 0 are one place.
    let key = |i: u32| mesh.positions[i as usize].map(|x| (x + 0.0).to_bits());
    for t in &mesh.triangles {
        for (i, j) in [(t[0], t[1]), (t[1], t[2]), (t[2], t[0])] {
            let (p, q) = (key(i), key(j));
            *balance.entry([p.min(q), p.max(q)]).or_default() += if p < q { 1 } else { -1 };
        }
    }
    balance.into_values().filter(|n| *n != 0).count()
}

/// Every vertex normal agrees with the sides of its triangles.
fn normals_agree(mesh: &Mesh) -> bool {
    mesh.triangles.iter().zip(corners(mesh)).all(|(t, [a, b, c])| {
        let face = (b - a).cross(c - a).normalize();
        t.iter().all(|i| {
            let normal = Vec3::from_array(mesh.normals[*i as usize]).as_dvec3();
            (normal.length() - 1.0).abs() < 1e-6 && normal.dot(face) > 0.999
        })
    })
}

fn near(a: f64, b: f64, tolerance: f64) -> bool {
    (a - b).abs() <= tolerance * b.abs()
}

#[test]
fn the_sphere_is_one_to_a_part_in_three_thousand() {
    let sphere = shape("sphere {}");
    assert_eq!((sphere.positions.len(), sphere.triangles.len()), (10242, 20480));
    assert_eq!(open_edges(&sphere), 0);
    assert!(near(volume(&sphere), 4.0 / 3.0 * PI, 1e-3), "{}", volume(&sphere));
    assert!(sphere.positions.iter().all(|p| near(Vec3::from_array(*p).as_dvec3().length(), 1.0, 1e-7)));
    assert_eq!(sphere.normals, sphere.positions);
    assert!(normals_agree(&sphere));
    let lowest = corners(&sphere).map(|[a, b, c]| a.dot((b - a).cross(c - a).normalize())).fold(1.0, f64::min);
    assert!(lowest > 1.0 - 3e-4, "{lowest}");
}

#[test]
fn the_box_is_closed_and_its_faces_carry_the_texture_upright() {
    let cube = shape("box {}");
    assert_eq!((open_edges(&cube), volume(&cube)), (0, 1.0));
    assert!(normals_agree(&cube));
    for (i, p) in cube.positions.iter().enumerate() {
        let normal = cube.normals[i];
        let axis = normal.iter().position(|x| *x != 0.0).expect("a unit vector");
        let [along_p, along_q] = [[1, 2], [0, 2], [0, 1]][axis].map(|k: usize| p[k]);
        // In the file v grows upwards.
        assert_eq!(cube.uvs[0][i], [0.5 + normal[axis] * along_p, 1.0 - (0.5 + along_q)], "{p:?} {normal:?}");
    }
}

#[test]
fn the_square_faces_z() {
    let square = shape("square {}");
    assert_eq!(square.positions.len(), 4);
    assert!(normals_agree(&square) && square.normals.iter().all(|n| *n == [0.0, 0.0, 1.0]));
    for (p, uv) in square.positions.iter().zip(&square.uvs[0]) {
        assert_eq!(*uv, [p[0] + 0.5, 1.0 - (p[1] + 0.5)]);
        assert_eq!(p[2], 0.0);
    }
}

#[test]
fn cylinders_are_capped_unless_they_say_otherwise() {
    let capped = shape("cylinder {}");
    assert_eq!((open_edges(&capped), capped.triangles.len()), (0, 1024));
    assert!(near(volume(&capped), PI, 1e-3) && normals_agree(&capped));
    let open = shape("cylinder { capped = false; }");
    assert_eq!((open_edges(&open), open.triangles.len()), (512, 512));
    assert!(normals_agree(&open));
    assert!(open.positions.iter().all(|p| p[2] == 0.0 || p[2] == 1.0));
}

#[test]
fn cones_have_the_volume_of_their_radii() {
    let frustum = |h: f64, a: f64, b: f64| PI * h / 3.0 * (a * a + a * b + b * b);
    let cases = [
        ("", frustum(1.0, 1.0, 0.0)),
        ("height = 3; bottom_radius = 0.5; top_radius = 2;", frustum(3.0, 0.5, 2.0)),
        ("bottom_radius = 0; top_radius = 1;", frustum(1.0, 1.0, 0.0)),
        ("bottom_radius = -2; top_radius = 2;", frustum(1.0, 2.0, 2.0)),
        ("bottom_radius = 0; top_radius = 0;", frustum(1.0, 1e-4, 1e-4)),
    ];
    for (fields, expected) in cases {
        let cone = shape(&format!("cone {{ {fields} }}"));
        assert_eq!(open_edges(&cone), 0, "{fields}");
        assert!(near(volume(&cone), expected, 1e-3), "{fields}: {} {expected}", volume(&cone));
        assert!(normals_agree(&cone), "{fields}");
    }
    let open = shape("cone { capped = false; top_radius = 0.5 }");
    assert_eq!(open_edges(&open), 512);
}

#[test]
fn a_cone_of_negative_height_hangs_down_and_one_of_no_height_is_left_out() {
    let scene = scene("cone { height = -2; }");
    let tip = scene.instances[0].transform.transform_point3(DVec3::new(0.0, 0.0, 2.0));
    assert_eq!(tip, DVec3::new(0.0, 0.0, -2.0));
    assert_eq!(warnings("sphere {} cone { height = 0; }"), ["empty-shape"]);
}

#[test]
fn equal_shapes_of_equal_material_share_a_mesh() {
    let scene = scene(
        "sphere {} sphere {} cone { height=2 } cone { height=2 } cone { height=3 } cylinder {} \
         cylinder { capped=false } sphere { material={ diffuse=(1,0,0) } }",
    );
    let meshes: Vec<u32> = scene.instances.iter().map(|i| i.mesh).collect();
    assert_eq!(meshes, [0, 0, 1, 1, 2, 3, 4, 5]);
    assert_eq!(diffuse_of_instances(&scene)[7], [1.0, 0.0, 0.0]);
}

#[test]
fn very_many_round_shapes_are_cut_more_coarsely() {
    let triangles = |count: usize, text: &str| {
        let scene = scene(&text.repeat(count));
        assert_eq!((scene.meshes.len(), scene.instances.len()), (1, count));
        scene.meshes[0].triangles.len()
    };
    assert_eq!(triangles(195, "sphere {}"), 20480);
    assert_eq!(triangles(196, "sphere {}"), 5120);
    assert_eq!(triangles(100_000, "sphere {}"), 320);
    assert_eq!(triangles(3900, "cylinder {}"), 1024);
    assert_eq!(triangles(100_000, "cylinder {}"), 128);
}
