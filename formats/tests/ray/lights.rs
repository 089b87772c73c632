//! Lights in the units of the scene IR.

use super::{assert_fails, scene, warnings};
use glam::DVec3;
use kiln_formats::ErrorCode::{Invalid, Syntax};
use kiln_formats::scene::{Extent, Falloff, Light, LightKind};
use std::f32::consts::PI;

fn light(text: &str) -> Light {
    let mut lights = scene(&format!("{text} sphere {{}}")).lights;
    assert_eq!(lights.len(), 1, "{text}");
    lights.remove(0)
}

fn extent(fields: &str) -> (Extent, DVec3) {
    let light = light(&format!("area_light {{ position=(1,2,3); color=(1,1,1); {fields} }}"));
    match light.kind {
        LightKind::Point { extent, .. } => (extent, light.position),
        other => panic!("{other:?}"),
    }
}

fn falloff(fields: &str) -> [f64; 3] {
    match light(&format!("point_light {{ position=(0,0,0); color=(1,1,1); {fields} }}")).kind {
        LightKind::Point { falloff: Falloff::Clamped { constant, linear, quadratic }, extent: Extent::Point } => {
            [constant, linear, quadratic]
        }
        other => panic!("{other:?}"),
    }
}

#[test]
fn a_lambert_surface_gets_the_brightness_of_the_course_tracers() {
    // Theirs: k_d · color · cos. The IR's: k_d/π · Light::color · cos.
    for text in [
        "point_light { position=(0,0,0); color=(1,2,0.5) }",
        "directional_light { colour=(1,2,0.5) direction=(0,0,1) }",
    ] {
        let light = light(text);
        let file = [1.0, 2.0, 0.5];
        for (have, want) in light.color.iter().zip(file) {
            assert!((have / PI - want).abs() < 1e-6, "{text}");
        }
        assert!(light.through_glass);
    }
}

#[test]
fn directions_become_unit_vectors_along_the_light() {
    let light = light("directional_light { direction = (0,-3,4); color = (1,1,1); }");
    assert_eq!(light.kind, LightKind::Directional);
    assert!((light.direction - DVec3::new(0.0, -0.6, 0.8)).length() < 1e-15);
    let nowhere = "directional_light { direction = (0,0,0); color = (1,1,1); } sphere {}";
    assert_fails(nowhere, Invalid, 2, 33, "points nowhere");
}

#[test]
fn fall_off_is_inverse_square_unless_the_file_says_otherwise() {
    assert_eq!(falloff(""), [0.0, 0.0, 1.0]);
    let all = "constant_attenuation_coeff= 0.25; linear_attenuation_coeff = 0.5; quadratic_attenuation_coeff = 2;";
    assert_eq!(falloff(all), [0.25, 0.5, 2.0]);
    assert_eq!(falloff("constant_attenuation_coeff = 1;"), [1.0, 0.0, 1.0]);
}

#[test]
fn ambient_lights_add_up() {
    let scene = scene("ambient_light { color=(0.25,0.5,0) } ambient_light { colour=(0.25,0,1); } sphere {}");
    assert_eq!(scene.ambient, [0.5, 0.5, 1.0]);
    assert!(scene.lights.is_empty());
}

#[test]
fn every_forks_area_light_is_understood() {
    let at = DVec3::new(1.0, 2.0, 3.0);
    assert_eq!(extent(""), (Extent::Disc { radius: 1.0 }, at));
    assert_eq!(extent("light_radius = 2.5;"), (Extent::Disc { radius: 2.5 }, at));
    assert_eq!(extent("bottom_radius = 0.5;"), (Extent::Disc { radius: 0.5 }, at));
    assert_eq!(extent("light_radius = 0;"), (Extent::Point, at));
    let square = Extent::Parallelogram { u: DVec3::X * 0.25, v: DVec3::Z * 0.25 };
    assert_eq!(extent("area = 0.5"), (square, at));
    let edges = Extent::Parallelogram { u: DVec3::NEG_X, v: DVec3::Y * 2.0 };
    assert_eq!(extent("u = (-2,0,0); v = (0,4,0);"), (edges, DVec3::new(0.0, 4.0, 3.0)));
}

#[test]
fn broken_lights_are_refused() {
    assert_fails("\npoint_light { position=(0,0,0) }", Syntax, 3, 1, "`point_light` has no `color`");
    assert_fails("point_light { color=(0,0,0) }", Syntax, 2, 1, "`point_light` has no `position`");
    assert_fails("directional_light { color=(0,0,0) }", Syntax, 2, 1, "`directional_light` has no `direction`");
    let twice = "point_light { color=(0,0,0); colour=(1,1,1); }";
    assert_fails(twice, Syntax, 2, 30, "`colour` is given twice");
    assert_fails("ambient_light { position=(0,0,0) }", Syntax, 2, 17, "`ambient_light` has no field `position`");
    assert_fails("point_light { light_radius=1 }", Syntax, 2, 15, "`point_light` has no field `light_radius`");
    assert_fails("area_light { position=(0,0,0) color=(1,1,1) u=(1,0,0) }", Syntax, 2, 1, "has no `v`");
    let negative = "area_light { position=(0,0,0) color=(1,1,1) light_radius = -1 } sphere {}";
    assert_fails(negative, Invalid, 2, 60, "must not be negative");
    assert_fails("translate(0,0,0, point_light {})", Syntax, 2, 18, "cannot stand inside a transform");
}

#[test]
fn negative_colours_and_coefficients_become_zero() {
    let text = "point_light { position=(0,0,0); color=(-1,1,0); linear_attenuation_coeff=-1 }";
    let light = light(text);
    assert_eq!(light.color[0], 0.0);
    assert!(light.color[1] > 3.0);
    assert_eq!(falloff("linear_attenuation_coeff=-1"), [0.0, 0.0, 1.0]);
    assert_eq!(warnings(&format!("{text} sphere {{}}")), ["negative-value", "negative-value"]);
}
