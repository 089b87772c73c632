//! Every scene of the collection in `$KILN_SHARED/scenes/ray`, counted against its inventory, which an independent
//! strict parser made. Without `KILN_SHARED` these tests say so and pass, unless
//! `KILN_REQUIRE_SHARED` is set.

use kiln_formats::ray::{Dialect, RayOptions};
use kiln_formats::scene::{LightKind, Mesh};
use kiln_formats::{Control, ErrorCode, ImportError, ImportOptions, Imported, Place, Scene, import};
use serde_json::{Map, Value};
use std::path::{Path, PathBuf};

fn collection() -> Option<PathBuf> {
    crate::shared::shared("scenes/ray")
}

fn read(path: &Path) -> Result<Imported, ImportError> {
    import(path, &ImportOptions::default(), &Control::default())
}

fn read_inventory(folder: &Path) -> Map<String, Value> {
    let text = std::fs::read_to_string(folder.join("inventory.json")).expect("the collection has an inventory");
    serde_json::from_str(&text).expect("the inventory is a JSON object")
}

/// Whether a mesh came from a `polymesh` rather than from a primitive: primitives share meshes with these signs.
fn counted(scene: &Scene, is_it: impl Fn(&Mesh) -> bool) -> u64 {
    scene.instances.iter().filter(|i| is_it(&scene.meshes[i.mesh as usize])).count() as u64
}

fn is_sphere(mesh: &Mesh) -> bool {
    mesh.normals == mesh.positions && mesh.positions.len() >= 162
}

fn is_box(mesh: &Mesh) -> bool {
    mesh.positions.len() == 24 && mesh.triangles.len() == 12 && !mesh.uvs[0].is_empty()
}

fn is_square(mesh: &Mesh) -> bool {
    mesh.positions.len() == 4 && mesh.triangles.len() == 2 && !mesh.uvs[0].is_empty()
}

fn is_body(mesh: &Mesh) -> bool {
    mesh.positions.len() >= 512 && mesh.normals.len() == mesh.positions.len() && is_round(mesh)
}

/// Whether the first vertices form the lower rim of a cone or cylinder.
fn is_round(mesh: &Mesh) -> bool {
    let radius = |p: &[f32; 3]| (p[0] * p[0] + p[1] * p[1]).sqrt();
    let first = radius(&mesh.positions[0]);
    mesh.positions[..256].iter().all(|p| p[2] == 0.0 && (radius(p) - first).abs() <= 1e-6 * first.max(1.0))
}

#[test]
fn the_inventory_and_the_scenes_agree() {
    let Some(folder) = collection() else { return };
    let mut compared = 0;
    for (name, facts) in &read_inventory(&folder) {
        let sound = ["strict_ut", "seed_2018"].iter().any(|key| facts[key] == "ok");
        if !sound || name.starts_with("malformed/") {
            continue;
        }
        let Imported { scene, .. } = read(&folder.join(name)).unwrap_or_else(|e| panic!("{name}: {e}"));
        let want = |key: &str| facts[key].as_u64().unwrap_or(0);
        let lights = |is_it: fn(&LightKind) -> bool| scene.lights.iter().filter(|l| is_it(&l.kind)).count() as u64;
        let directional = lights(|kind| matches!(kind, LightKind::Directional));
        let points = lights(|kind| matches!(kind, LightKind::Point { .. }));
        assert_eq!(directional, want("directional_light"), "{name}: directional lights");
        assert_eq!(points, want("point_light") + want("area_light"), "{name}: point and area lights");
        assert_eq!(scene.ambient != [0.0; 3], want("ambient_light") > 0, "{name}: ambient light");
        assert_eq!(scene.cameras.len(), 1, "{name}: cameras");

        assert_eq!(counted(&scene, is_sphere), want("sphere"), "{name}: spheres");
        assert_eq!(counted(&scene, is_box), want("box"), "{name}: boxes");
        assert_eq!(counted(&scene, is_square), want("square"), "{name}: squares");
        assert_eq!(counted(&scene, is_body), want("cylinder") + want("cone"), "{name}: cylinders and cones");

        let is_mesh = |m: &Mesh| !is_sphere(m) && !is_box(m) && !is_square(m) && !is_body(m);
        let meshes: Vec<&Mesh> = scene.meshes.iter().filter(|m| is_mesh(m)).collect();
        assert_eq!(counted(&scene, is_mesh), want("trimesh"), "{name}: meshes");
        let vertices: u64 = meshes.iter().map(|m| m.positions.len() as u64).sum();
        let triangles: u64 = meshes.iter().map(|m| m.triangles.len() as u64).sum();
        assert_eq!(vertices, want("vertices"), "{name}: vertices");
        assert_eq!(triangles, want("triangles") - want("degenerate_triangles"), "{name}: triangles");
        let coloured = meshes.iter().filter(|m| !m.vertex_materials.is_empty()).count() as u64;
        assert_eq!(coloured, want("vertex_materials"), "{name}: meshes with materials per vertex");
        let textures = facts["textures"].as_array().map_or(0, Vec::len);
        assert_eq!(scene.textures.len(), textures, "{name}: textures");
        compared += 1;
    }
    assert!(compared > 60, "only {compared} scenes were compared");
}

#[test]
fn cameras_are_as_written() {
    let Some(folder) = collection() else { return };
    for (name, facts) in &read_inventory(&folder) {
        let Some(camera) = facts.get("camera").filter(|_| !name.starts_with("malformed/")) else { continue };
        let scene = read(&folder.join(name)).unwrap_or_else(|e| panic!("{name}: {e}")).scene;
        let vector = |key: &str, default: [f64; 3]| match &camera[key] {
            Value::Array(a) => glam::DVec3::from_iter(a),
            _ => glam::DVec3::from_array(default),
        };
        let view = &scene.cameras[0];
        let (viewdir, updir) = (vector("viewdir", [0.0, 0.0, -1.0]), vector("updir", [0.0, 1.0, 0.0]));
        assert_eq!(view.origin, vector("position", [0.0; 3]), "{name}");
        assert_eq!(view.forward, viewdir, "{name}");
        #[allow(clippy::disallowed_methods, reason = "compared with a tolerance")]
        let height = camera["fov"].as_f64().map_or(1.0, |fov| 2.0 * (fov.to_radians() / 2.0).tan());
        let aspect = camera["aspectratio"].as_f64().unwrap_or(1.0);
        assert!((view.up - updir * (height / 2.0)).length() < 1e-12, "{name}");
        assert!((view.right - updir.cross(-viewdir) * (height * aspect / 2.0)).length() < 1e-12, "{name}");
    }
}

trait FromNumbers {
    fn from_iter(values: &[Value]) -> Self;
}

impl FromNumbers for glam::DVec3 {
    fn from_iter(values: &[Value]) -> Self {
        let at = |i: usize| values[i].as_f64().expect("a number");
        Self::new(at(0), at(1), at(2))
    }
}

#[test]
fn malformed_scenes_fail_with_their_line() {
    let Some(folder) = collection() else { return };
    let cases = [
        ("version_too_new", 1, ErrorCode::UnknownFormat, "format version 2.0 is newer than the newest supported (1.1)"),
        (
            "truncated_mesh",
            10,
            ErrorCode::Syntax,
            "end of file inside `faces` list of `polymesh` opened at line 7; a number was expected",
        ),
        (
            "face_index_out_of_range",
            9,
            ErrorCode::Invalid,
            "face (0,2,3) names vertex 3, the mesh has 3 vertices (0..2); face (0,-1,2) has a negative index",
        ),
        ("viewdir_without_updir", 3, ErrorCode::Syntax, "camera has `viewdir` but no `updir` (both or neither)"),
        ("bad_number_and_zero_scale", 6, ErrorCode::Syntax, "`1.2.3` is not a number"),
        ("missing_texture", 7, ErrorCode::Io, "cannot read texture `no_such_file.png`"),
    ];
    for (name, line, code, message) in cases {
        let path = folder.join("malformed").join(name).with_extension("ray");
        let error = read(&path).expect_err(name);
        assert_eq!(error.code, code, "{name}: {error}");
        assert!(error.message.starts_with(message), "{name}: {error}");
        assert!(matches!(error.place, Place::Text { line: l, column: 1.. } if l == line), "{name}: {error}");
    }
}

#[test]
fn other_dialects_are_read_or_refused_by_name() {
    let Some(folder) = collection() else { return };
    let read_well = [
        "dialects/area_light_area.ray",
        "dialects/area_light_bottom_radius.ray",
        "dialects/bump/bump.ray",
        "dialects/map_points/teapot.ray",
        "dialects/obj/objfile_cube.ray",
        "hkust/bonus_soft_shadow.ray",
        "hkust/capped_cylinder.ray",
        "hkust/bonus_cornell_box.ray",
        "hkust/simpleSamples_diffuse_map.ray",
    ];
    for name in read_well {
        if let Err(error) = read(&folder.join(name)) {
            panic!("{name}: {error}");
        }
    }
    // Fields of one fork's own, which the dialect passes over.
    let other = folder.join("hkust/bonus_path_tracing.ray");
    assert!(read(&other).is_err());
    let ray = RayOptions { dialect: Dialect::Hk, ..RayOptions::default() };
    let options = ImportOptions { ray, ..ImportOptions::default() };
    let Imported { warnings, .. } = import(&other, &options, &Control::default()).expect("passed over");
    assert!(warnings.iter().any(|w| w.code == "ignored-field" && w.message.contains("`type`")));
    let refused = [
        ("dialects/quadric_cone.ray", 29, "quadric"),
        ("dialects/secret_spot_light.ray", 9, "spot_light"),
        ("dialects/torus_torii.ray", 22, "torus"),
        ("hkust/bonus_spotlight.ray", 14, "spot_light"),
    ];
    for (name, line, word) in refused {
        let error = read(&folder.join(name)).expect_err(name);
        assert_eq!(error.code, ErrorCode::Unsupported, "{name}: {error}");
        assert!(matches!(error.place, Place::Text { line: l, .. } if l == line), "{name}: {error}");
        assert!(error.message.contains(&format!("`{word}`")), "{name}: {error}");
    }
}
