use super::*;
use crate::effects::Knowledge;
use crate::prepare::{EnvironmentSource, prepare_knowing};
use crate::settings::{EffectSet, PrepareSettings};
use glam::DAffine3;
use kiln_formats::Control;
use kiln_formats::scene::*;

/// A square in the plane z = `z`.
fn square(material: MaterialId, z: f32) -> Mesh {
    let corners = [[-1.0, -1.0, z], [1.0, -1.0, z], [1.0, 1.0, z], [-1.0, 1.0, z]];
    Mesh { positions: corners.to_vec(), triangles: vec![[0, 1, 2], [0, 2, 3]], material, ..Mesh::default() }
}

fn prepared(meshes: Vec<Mesh>, know: Knowledge) -> PreparedScene {
    let masked = |alpha| Material {
        alpha: Alpha { mode: AlphaMode::Mask { cutoff: 0.5 }, value: ScalarInput::constant(alpha) },
        ..Material::default()
    };
    let both = Material { double_sided: true, ..Material::default() };
    let front = Material { double_sided: false, ..Material::default() };
    let instances = (0..meshes.len() as u32)
        .map(|mesh| Instance { name: String::new(), mesh, transform: DAffine3::IDENTITY })
        .collect();
    let scene = Scene { materials: vec![both, front, masked(0.25)], meshes, instances, ..Scene::default() };
    scene.validate().expect("a valid scene");
    prepare_knowing(scene, &EnvironmentSource::None, &PrepareSettings::default(), know, &Control::default())
        .expect("not stopped")
}

const BOTH: MaterialId = 0;
const FRONT: MaterialId = 1;
const OPEN: MaterialId = 2;

#[test]
fn what_lets_every_ray_through_is_not_in_the_tree() {
    let meshes = || vec![square(OPEN, 1.0), square(BOTH, 0.0), square(OPEN, -1.0)];
    let pruned = prepared(meshes(), Knowledge::default());
    assert_eq!(pruned.unmet(), Unmet { open: 4, ..Unmet::default() });
    assert_eq!(pruned.kdtree_statistics().triangles, 2);
    // Numbers stay those of the geometry.
    let down = crate::math::Ray { origin: Vec3::Z * 1.5, dir: -Vec3::Z, t_max: f32::INFINITY };
    let hit = pruned.tree.closest(&down, |_| true).expect("the square between");
    assert!([2, 3].contains(&hit.triangle), "{hit:?}");
    // The full renderer takes no surface to be like that.
    let full = prepared(meshes(), Knowledge { forced: EffectSet::all(), ..Knowledge::default() });
    assert_eq!((full.unmet().open, full.kdtree_statistics().triangles), (0, 6));
    // Two thirds of the triangles let rays pass, but none that a ray meets: nobody asks on the way. The full renderer does.
    assert!(!pruned.questions.mostly() && full.questions.mostly());
}

#[test]
fn twins_behind_others_are_counted_where_they_are_hidden_from_all() {
    let count = |meshes: Vec<Mesh>| {
        let Unmet { open: 0, without_area: 0, behind_twin, behind_turned_twin } =
            prepared(meshes, Knowledge::default()).unmet()
        else {
            panic!("open or without area")
        };
        [behind_twin, behind_turned_twin]
    };
    let turned = |mut mesh: Mesh| {
        mesh.triangles.iter_mut().for_each(|t| t.rotate_left(1));
        mesh
    };
    let flipped = |mut mesh: Mesh| {
        mesh.triangles.iter_mut().for_each(|t| t.swap(0, 1));
        mesh
    };
    assert_eq!(count(vec![square(BOTH, 0.0), square(BOTH, 0.0)]), [2, 0]);
    assert_eq!(count(vec![square(BOTH, 0.0), square(FRONT, 0.0), square(BOTH, 0.5)]), [2, 0]);
    assert_eq!(count(vec![square(BOTH, 0.0), turned(square(BOTH, 0.0))]), [0, 2]);
    assert_eq!(count(vec![square(FRONT, 0.0), turned(square(FRONT, 0.0))]), [0, 2]);
    // The camera sees the second one from behind, and each from its own side.
    assert_eq!(count(vec![square(FRONT, 0.0), square(BOTH, 0.0)]), [0, 0]);
    assert_eq!(count(vec![square(FRONT, 0.0), flipped(square(FRONT, 0.0))]), [0, 0]);
}
