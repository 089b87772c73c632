//! Cameras: the raw basis, and the other ways to say where to look.

use super::{assert_fails, read_body, scene, warnings};
use glam::DVec3;
use kiln_formats::ErrorCode::{Invalid, Syntax};
use kiln_formats::scene::{Camera, Projection, UpAxis};

fn camera(blocks: &str) -> Camera {
    let mut cameras = scene(&format!("{blocks} sphere {{}}")).cameras;
    assert_eq!(cameras.len(), 1);
    cameras.remove(0)
}

#[track_caller]
fn assert_near(a: DVec3, b: DVec3) {
    assert!((a - b).length() < 1e-12, "{a} is not {b}");
}

#[test]
fn the_default_camera_looks_down_z_with_an_image_of_height_one() {
    for blocks in ["", "camera {}"] {
        let camera = camera(blocks);
        assert_eq!(camera.projection, Projection::Perspective);
        assert_eq!((camera.origin, camera.forward), (DVec3::ZERO, DVec3::NEG_Z));
        assert_eq!((camera.right, camera.up), (DVec3::X * 0.5, DVec3::Y * 0.5));
        assert!(camera.aspect.is_some());
    }
}

#[test]
fn the_basis_is_neither_normalised_nor_made_orthogonal() {
    let camera = camera("camera { position = (1,2,3); viewdir = (0,-1,-2); updir = (0,3,0); aspectratio = 2 }");
    assert_eq!((camera.origin, camera.forward), (DVec3::new(1.0, 2.0, 3.0), DVec3::new(0.0, -1.0, -2.0)));
    // cross(up, −view) has length 6; the image is 1 high and 2 wide in these units.
    assert_eq!((camera.right, camera.up), (DVec3::new(6.0, 0.0, 0.0), DVec3::new(0.0, 1.5, 0.0)));
}

#[test]
fn the_field_of_view_is_vertical_and_in_degrees() {
    let camera = camera("camera { fov = 90; aspectratio = 3; }");
    assert_near(camera.up, DVec3::Y);
    assert_near(camera.right, DVec3::X * 3.0);
}

#[test]
fn later_blocks_overwrite_field_by_field() {
    let camera = camera("camera { position = (1,0,0); fov = 90 } camera { position = (2,0,0); position = (3,0,0) }");
    assert_eq!(camera.origin, DVec3::X * 3.0);
    assert_near(camera.up, DVec3::Y);
}

#[test]
fn a_quaternion_turns_the_camera() {
    // A quarter turn about +y: what looked down −z looks down −x.
    let half = std::f64::consts::FRAC_1_SQRT_2;
    for word in ["quaternian", "quaternion"] {
        let camera = camera(&format!("camera {{ {word} = (0,{half},0,{half}); }}"));
        assert_near(camera.forward, DVec3::NEG_X);
        assert_near(camera.right, DVec3::NEG_Z * 0.5);
        assert_near(camera.up, DVec3::Y * 0.5);
    }
    let both = camera(&format!("camera {{ viewdir=(0,0,1); updir=(0,1,0); quaternian=(0,{half},0,{half}); }}"));
    assert_eq!(both.forward, DVec3::Z);
}

#[test]
fn look_at_aims_at_a_point_without_shear() {
    let aimed = camera("camera { look_at = (0,0,-10); position = (0,10,0); }");
    let half = std::f64::consts::FRAC_1_SQRT_2;
    assert_near(aimed.forward, DVec3::new(0.0, -half, -half));
    assert_near(aimed.right, DVec3::X * 0.5);
    assert_near(aimed.up, DVec3::new(0.0, half, -half) * 0.5);
    let tilted = camera("camera { look_at = (0,0,-1); updir = (5,0,0); }");
    assert_near(tilted.up, DVec3::X * 0.5);
    assert_fails("camera { look_at = (0,0,0); } sphere {}", Invalid, 2, 1, "parallel, zero or out of range");
}

#[test]
fn the_up_axis_is_the_cameras() {
    let up = |updir: &str| scene(&format!("camera {{ viewdir=(1,0,0); updir={updir}; }} box{{}}")).up;
    assert_eq!(up("(0,1,0)"), UpAxis::Y);
    assert_eq!(up("(0,0.3,0.9)"), UpAxis::Z);
    assert_eq!(scene("box {}").up, UpAxis::Y);
}

#[test]
fn what_makes_no_picture_is_refused() {
    assert_fails("\ncamera { viewdir = (0,0,-1); }", Syntax, 3, 1, "camera has `viewdir` but no `updir`");
    assert_fails("camera { updir = (0,1,0); }", Syntax, 2, 1, "camera has `updir` but no `viewdir`");
    let parallel = "camera { viewdir = (0,2,0); updir = (0,1,0); } sphere {}";
    assert_fails(parallel, Invalid, 2, 1, "parallel, zero or out of range");
    assert_fails("camera { fov = 180; } sphere {}", Invalid, 2, 16, "field of view of 180°");
    assert_fails("camera { aspectratio = 0; } sphere {}", Invalid, 2, 24, "aspect ratio of 0");
    assert!(read_body("camera { viewdir = (1e200,0,0); updir = (0,1e200,0); } sphere {}").is_err());
}

#[test]
fn a_focal_distance_is_ignored_with_a_warning() {
    assert_eq!(warnings("camera { focaldistance = 3; } sphere {}"), ["ignored-field"]);
}
