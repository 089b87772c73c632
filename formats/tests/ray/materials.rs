//! Materials: inheritance, names, and what the importer says about them.

use super::{assert_fails, diffuse_of_instances, phong, read_body, scene, warnings};
use kiln_formats::ErrorCode::{Invalid, Io, Syntax};

const RED: [f32; 3] = [1.0, 0.0, 0.0];
const BLUE: [f32; 3] = [0.0, 0.0, 1.0];

#[test]
fn every_field_reaches_the_scene() {
    let scene = scene(
        "sphere { material = { emissive=(1,2,3); ambient=(.1,.2,.3) diffuse=(.2,.3,.4); specular=(.3,.4,.5); \
         reflective=(.01,.02,.03); transmissive=(.5,.6,.7); shininess=25.6; index=1.5 } }",
    );
    let material = &scene.materials[0];
    let phong = phong(material);
    assert_eq!(material.emission.factor, [1.0, 2.0, 3.0]);
    assert!(material.emission_two_sided && material.double_sided);
    assert_eq!(phong.ambient.factor, [0.1, 0.2, 0.3]);
    assert_eq!(phong.diffuse.factor, [0.2, 0.3, 0.4]);
    assert_eq!(phong.specular.factor, [0.3, 0.4, 0.5]);
    assert_eq!(phong.mirror.factor, [0.01, 0.02, 0.03]);
    assert_eq!(phong.transmission.factor, [0.5, 0.6, 0.7]);
    assert_eq!((phong.exponent.factor, phong.ior.factor), (25.6, 1.5));
}

#[test]
fn the_default_is_black_and_does_not_mirror_its_highlight() {
    let scene = scene("sphere { material = { specular = (0.5,0.5,0.5); } }");
    let phong = phong(&scene.materials[0]);
    assert_eq!(phong.diffuse.factor, [0.0; 3]);
    assert_eq!(phong.mirror.factor, [0.0; 3]);
    assert_eq!((phong.exponent.factor, phong.ior.factor), (0.0, 1.0));
}

#[test]
fn objects_start_from_the_current_default_which_accumulates() {
    let scene = scene(
        "sphere {} \
         material = { diffuse = (1,0,0); } material = { specular = (0,1,0); } \
         sphere { material = { shininess = 7; } } \
         box {} \
         material = { diffuse = (0,0,1); }",
    );
    assert_eq!(diffuse_of_instances(&scene), [[0.0; 3], RED, RED]);
    let changed = phong(&scene.materials[1]);
    assert_eq!((changed.specular.factor, changed.exponent.factor), ([0.0, 1.0, 0.0], 7.0));
    assert_eq!(phong(&scene.materials[2]).exponent.factor, 0.0);
}

#[test]
fn the_last_of_several_materials_holds_and_starts_from_the_context() {
    let scene = scene("sphere { material = { diffuse=(1,0,0); specular=(1,1,1) }; material = { diffuse=(0,0,1) } }");
    assert_eq!(diffuse_of_instances(&scene), [BLUE]);
    assert_eq!(phong(scene.materials.last().expect("one")).specular.factor, [0.0; 3]);
    assert_eq!(diffuse_of_instances(&super::scene("box { material={ diffuse=(1,0,0); diffuse=(0,0,1) } }")), [BLUE]);
}

#[test]
fn a_groups_material_ends_with_the_group() {
    let scene = scene(
        "material = { diffuse = (1,0,0) } \
         { sphere {} material = { diffuse = (0,0,1) }; sphere {} translate(1,0,0, { box {} }) } \
         sphere {}",
    );
    assert_eq!(diffuse_of_instances(&scene), [RED, BLUE, BLUE, RED]);
}

#[test]
fn names_are_defined_with_and_without_an_equals_sign_and_can_be_referred_to() {
    for definition in [
        "material = { name = \"m\"; diffuse = (1,0,0); }",
        "material = { diffuse = (1,0,0); name \"m\"; }",
        "material { name = m diffuse = (1,0,0) }",
    ] {
        for reference in ["\"m\"", "m"] {
            let text = format!(
                "{definition} material = {{ diffuse = (0,0,1) }} sphere {{ material = {reference}; }} box {{}}"
            );
            let scene = scene(&text);
            assert_eq!(diffuse_of_instances(&scene), [RED, BLUE], "{text}");
            assert_eq!(scene.materials[0].name, "m");
        }
    }
    let default = scene("sphere { material = { name=\"m\" diffuse=(1,0,0) } } material = m; box {}");
    assert_eq!(diffuse_of_instances(&default), [RED, RED]);
    let modified = scene("material = { name=\"m\" } sphere { material = { diffuse=(1,0,0) } }");
    assert_eq!(modified.materials[0].name, "", "a changed copy has no name");
}

#[test]
fn unknown_and_repeated_names_are_refused() {
    assert_fails("sphere { material = m }", Invalid, 2, 21, "no material `m` before this line");
    let twice = "material = { name=\"m\" }\nmaterial = { name=\"m\" }";
    assert_fails(twice, Invalid, 3, 20, "`m` is defined twice");
}

#[test]
fn equal_materials_are_one() {
    let scene = scene("sphere { material={diffuse=(1,0,0)} } box { material={diffuse=(1,0,0)} } cone {}");
    assert_eq!(scene.materials.len(), 2);
}

#[test]
fn a_number_for_a_colour_is_grey_and_a_colour_for_a_number_is_refused() {
    assert_eq!(diffuse_of_instances(&scene("sphere { material = { diffuse = .5 } }")), [[0.5; 3]]);
    assert_fails("sphere { material = { index = (1,1,1) } }", Syntax, 2, 31, "a number or `map(\"file\")`");
    assert_fails("sphere { material = { diffuse = red } }", Syntax, 2, 33, "a colour `(r,g,b)`");
    assert_fails("sphere { material = 7 }", Syntax, 2, 21, "a material in `{ }`");
}

#[test]
fn values_that_surfaces_cannot_have_are_mended() {
    let body = "sphere { material = { diffuse = (-1,0.5,0); shininess = -3; index = 0; } }";
    let scene = scene(body);
    let phong = phong(&scene.materials[0]);
    assert_eq!(phong.diffuse.factor, [0.0, 0.5, 0.0]);
    assert_eq!((phong.exponent.factor, phong.ior.factor), (0.0, 1.0));
    assert_eq!(warnings(body), ["negative-value", "negative-value", "invalid-ior"]);
}

#[test]
fn materials_that_make_light_are_told_once() {
    let body = |fields: &str| format!("sphere {{ material={{ {fields} }} }} box {{ material={{ {fields} }} }}");
    assert_eq!(warnings(&body("diffuse=(.7,.7,.7); reflective=(.3,.3,.3)")), [""; 0]);
    assert_eq!(warnings(&body("diffuse=(.2,.9,.2); reflective=(.3,.3,.3)")), ["energy-scaled"]);
    // The highlight's albedo is 2 k_s / (n + 1).
    assert_eq!(warnings(&body("diffuse=(.8,.8,.8); specular=(1,1,1); shininess=99")), [""; 0]);
    assert_eq!(warnings(&body("diffuse=(.8,.8,.8); specular=(1,1,1); shininess=3")), ["energy-scaled"]);
    let (_, told) = read_body(&body("diffuse=(1,1,.5); specular=(.15,.15,.15)")).expect("sound");
    assert!(told[0].message.contains("1.30 times"), "{}", told[0].message);
    assert_eq!(told[0].place, "1:19");
}

#[test]
fn a_flood_of_warnings_is_counted() {
    let body: String = (0..100).map(|i| format!("sphere {{ material={{ diffuse=(9,9,{i}) }} }}\n")).collect();
    let (_, told) = read_body(&body).expect("sound");
    assert_eq!(told.len(), 17);
    assert_eq!(told[16].message, "and 84 more of this kind");
}

#[test]
fn small_exponents_hint_at_the_other_dialect() {
    assert_eq!(
        warnings("sphere { material={ shininess=.6 } } box { material={ shininess=0 } }"),
        ["shininess-dialect"]
    );
    assert_eq!(warnings("sphere { material={ shininess=.6 } } box { material={ shininess=20 } }"), [""; 0]);
    assert_eq!(warnings("sphere { material={ shininess=0 } }"), [""; 0]);
}

#[test]
fn what_only_ambient_light_shows_is_named() {
    let scene = |ambient: &str, material: &str| {
        warnings(&format!("ambient_light {{ color = {ambient}; }} sphere {{ material = {{ {material} }} }}"))
    };
    assert_eq!(scene("(1,1,1)", "ambient = (0.5,0,0);"), ["ambient-ignored"]);
    assert!(scene("(0,0,0)", "ambient = (0.5,0,0);").is_empty());
    assert!(scene("(1,1,1)", "ambient = (0.5,0,0); diffuse = (0,0,1);").is_empty());
}

#[test]
fn a_bump_map_that_is_missing_stops_the_scene_as_any_texture_does() {
    assert_fails(
        "box { material={ bump_mapping = bump(\"none.png\"); } }",
        Io,
        2,
        18,
        "cannot read texture `none.png`",
    );
}
