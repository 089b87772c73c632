//! Transforms and groups.

use super::{assert_fails, read_in, scene, warnings};
use glam::{DAffine3, DVec3};
use kiln_formats::ErrorCode::{Invalid, Syntax, TooLarge};
use kiln_formats::Limits;

fn transforms(body: &str) -> Vec<DAffine3> {
    scene(body).instances.iter().map(|i| i.transform).collect()
}

#[track_caller]
fn assert_maps(body: &str, from: [f64; 3], to: [f64; 3]) {
    let image = transforms(body)[0].transform_point3(DVec3::from_array(from));
    assert!((image - DVec3::from_array(to)).length() < 1e-12, "{body}: {image}");
}

#[test]
fn each_transform_does_what_its_name_says() {
    assert_maps("translate(1,2,3, box{})", [1.0, 1.0, 1.0], [2.0, 3.0, 4.0]);
    assert_maps("scale(2, box{})", [1.0, 2.0, 3.0], [2.0, 4.0, 6.0]);
    assert_maps("scale(2,-3,4, box{})", [1.0, 1.0, 1.0], [2.0, -3.0, 4.0]);
    // Radians, right-handed, about an axis of any length: x goes to y about z.
    assert_maps("rotate(0,0,7, 1.5707963267948966, box{})", [1.0, 0.0, 0.5], [0.0, 1.0, 0.5]);
    assert_maps("rotate(1,1,1, 2.0943951023931953, box{})", [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]);
    let rows = "transform((0,-1,0,10),(1,0,0,20),(0,0,1,30),(0,0,0,1), box{})";
    assert_maps(rows, [1.0, 2.0, 3.0], [8.0, 21.0, 33.0]);
    assert_eq!(warnings(rows), [""; 0]);
    assert_eq!(warnings("transform((1,0,0,0),(0,1,0,0),(0,0,1,0),(0,0,1,1), box{})"), ["ignored-field"]);
}

#[test]
fn the_outermost_is_applied_last() {
    assert_maps("translate(1,0,0, scale(2, box{}))", [1.0, 0.0, 0.0], [3.0, 0.0, 0.0]);
    assert_maps("scale(2, translate(1,0,0, box{}))", [1.0, 0.0, 0.0], [4.0, 0.0, 0.0]);
}

#[test]
fn a_group_puts_many_elements_where_one_may_stand() {
    let body = "translate(1,0,0, { box{} scale(2, { sphere{} cone{} }); {} translate(1,0,0,box{}) }) sphere{}";
    let places: Vec<(f64, f64)> = transforms(body).iter().map(|t| (t.translation.x, t.matrix3.x_axis.x)).collect();
    assert_eq!(places, [(1.0, 1.0), (1.0, 2.0), (1.0, 2.0), (2.0, 1.0), (0.0, 1.0)]);
}

#[test]
fn a_transform_takes_exactly_one_element() {
    assert_fails("scale(2, sphere{} sphere{})", Syntax, 2, 19, "`)` was expected, found `sphere`");
    assert_fails("scale(2, )", Syntax, 2, 10, "an object, a transform or a group was expected");
    assert_fails("scale(2, camera {})", Syntax, 2, 10, "`camera` cannot stand inside a transform or group");
    assert_fails("scale(2, material = {})", Syntax, 2, 10, "an object, a transform or a group was expected");
    assert_fails("translate(1,2, sphere{})", Syntax, 2, 16, "a number was expected, found `sphere`");
    assert_fails("scale(1,2, sphere{})", Syntax, 2, 12, "a number was expected");
}

#[test]
fn singular_transforms_are_refused() {
    assert_fails("translate(0,0,0,\n  scale(0, sphere{}))", Invalid, 3, 3, "scale by 0 gives a singular transform");
    assert_fails("scale(1,0,1, sphere{})", Invalid, 2, 1, "singular");
    assert_fails("rotate(0,0,0,1, sphere{})", Invalid, 2, 1, "axis of length 0");
    let flat = "transform((1,0,0,0),(0,1,0,0),(0,0,0,0),(0,0,0,1), sphere{})";
    assert_fails(flat, Invalid, 2, 1, "this matrix gives a singular transform");
    assert_fails("scale(1e200, sphere{})", Invalid, 2, 1, "leaves the range of numbers");
    let product = "translate(1e300,0,0,\nscale(1e90,scale(1e90,scale(1e90,translate(1e300,0,0,sphere{})))))";
    assert_fails(product, Invalid, 3, 34, "leaves the range of numbers");
}

#[test]
fn nesting_is_bounded_without_using_the_stack() {
    let nested = |depth: usize, opening: &str, closing: &str| {
        let text = format!("SBT-raytracer 1.0 {}sphere{{}}{}", opening.repeat(depth), closing.repeat(depth));
        move |max_nesting| read_in(&std::env::temp_dir(), text.as_bytes(), Limits { max_nesting, ..Limits::default() })
    };
    for (opening, closing) in [("translate(0,0,0,", ")"), ("{", "}"), ("scale(1,{", "})")] {
        let deep = nested(100_000, opening, closing);
        assert_eq!(deep(1000).expect_err(opening).code, TooLarge);
        assert_eq!(deep(u32::MAX).expect("one sphere").0.instances.len(), 1);
    }
    assert!(nested(1000, "{", "}")(1000).is_ok());
    assert_eq!(nested(1001, "{", "}")(1000).expect_err("one too many").code, TooLarge);
    let unclosed = format!("SBT-raytracer 1.0 {}", "translate(0,0,0,".repeat(100_000));
    assert!(read_in(&std::env::temp_dir(), unclosed.as_bytes(), Limits::default()).is_err());
}
