//! The sample scenes of the repository are read without a complaint.

use kiln_formats::scene::{Extent, LightKind, Surface};
use kiln_formats::{Control, ImportOptions, Scene, import};
use std::path::Path;

fn sample(name: &str) -> Scene {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../scenes/samples").join(name);
    let imported = import(&path, &ImportOptions::default(), &Control::default()).unwrap_or_else(|e| panic!("{e}"));
    assert!(imported.warnings.is_empty(), "{name}: {:?}", imported.warnings);
    imported.scene
}

#[test]
fn the_still_life_has_two_soft_lights() {
    let scene = sample("soft_shadows.ray");
    let soft = |kind: &LightKind| matches!(kind, LightKind::Point { extent: Extent::Disc { .. }, .. });
    assert_eq!(scene.lights.iter().filter(|l| soft(&l.kind)).count(), 2);
    assert_eq!((scene.lights.len(), scene.instances.len()), (2, 14));
}

#[test]
fn the_orrery_is_lit_by_its_sun_and_a_soft_box_and_has_glass() {
    let scene = sample("orrery.ray");
    assert!(scene.lights.is_empty());
    assert_eq!(scene.materials.iter().filter(|m| !m.emission.is_black()).count(), 2);
    let glass = |s: &Surface| matches!(s, Surface::Phong(p) if !p.transmission.is_black() && p.ior.factor == 1.5);
    assert_eq!(scene.materials.iter().filter(|m| glass(&m.surface)).count(), 2);
}
