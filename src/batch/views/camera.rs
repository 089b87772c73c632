use crate::settings::FixedView;
use glam::DVec3;
use kiln_formats::Scene;
use kiln_formats::scene::{Camera, Projection};

/// The asset's camera of this name, else with this index.
///
/// # Errors
/// A sentence that lists the cameras there are.
pub fn find<'a>(scene: &'a Scene, name: &str) -> Result<&'a Camera, String> {
    let by_name = scene.cameras.iter().find(|c| c.name == name);
    let by_index = || name.parse::<usize>().ok().and_then(|i| scene.cameras.get(i));
    by_name.or_else(by_index).ok_or_else(|| {
        let names: Vec<String> = scene.cameras.iter().enumerate().map(|(i, c)| format!("{i} '{}'", c.name)).collect();
        let names = if names.is_empty() { "none".into() } else { names.join(", ") };
        format!("there is no camera '{name}'; cameras of this asset: {names}")
    })
}

/// The camera for a picture of another aspect ratio (width / height): nothing that it shows is lost, one side shows
/// more. Pixels are square.
pub fn fit(camera: &Camera, aspect: f64) -> Camera {
    let mut fitted = camera.clone();
    let (across, up) = (camera.right.length(), camera.up.length());
    match camera.aspect {
        Some(own) if own > aspect => fitted.up *= own / aspect,
        Some(own) => fitted.right *= aspect / own,
        None => fitted.right *= aspect * up / across,
    }
    fitted
}

/// A camera given in numbers.
///
/// # Errors
/// A sentence, when it is degenerate.
pub fn fixed(view: &FixedView, aspect: f64) -> Result<Camera, String> {
    let m = &view.camera_to_world;
    let column = |i: usize| DVec3::new(m[0][i], m[1][i], m[2][i]);
    let half = libm::tan(0.5 * view.vfov_deg.to_radians());
    let camera = Camera {
        name: String::new(),
        projection: Projection::Perspective,
        origin: column(3),
        forward: -column(2),
        right: column(0) * (half * aspect),
        up: column(1) * half,
        aspect: None,
    };
    let volume = camera.forward.dot(camera.right.cross(camera.up));
    if !(view.vfov_deg > 0.0 && view.vfov_deg < 180.0) {
        return Err(format!("the view's vfov_deg of {} is not between 0 and 180", view.vfov_deg));
    }
    if m[3] != [0.0, 0.0, 0.0, 1.0] {
        return Err("the last row of the view's camera_to_world is not 0 0 0 1".into());
    }
    if !camera.origin.is_finite() || !volume.is_finite() || volume == 0.0 {
        return Err("the view's camera_to_world is not finite, or flat".into());
    }
    Ok(camera)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn camera(name: &str, fixed_aspect: bool, aspect: f64) -> Camera {
        let fov = std::f64::consts::FRAC_PI_2;
        let camera = Camera::perspective(DVec3::ZERO, DVec3::NEG_Z, DVec3::Y, fov, aspect);
        Camera { name: name.into(), aspect: fixed_aspect.then_some(aspect), ..camera }
    }

    #[test]
    fn names_come_before_indices() {
        let scene = Scene { cameras: vec![camera("front", false, 1.0), camera("0", false, 1.0)], ..Scene::default() };
        assert_eq!(find(&scene, "0").map(|c| c.name.as_str()), Ok("0"));
        assert_eq!(find(&scene, "1").map(|c| c.name.as_str()), Ok("0"));
        assert_eq!(find(&scene, "front").map(|c| c.name.as_str()), Ok("front"));
        let error = find(&scene, "back").expect_err("no such camera");
        assert!(error.contains("'back'") && error.contains("0 'front', 1 '0'"), "{error}");
    }

    #[test]
    fn a_fixed_aspect_ratio_is_never_cropped() {
        for (own, picture, right, up) in
            [(2.0, 1.0, 2.0, 2.0), (0.5, 1.0, 1.0, 1.0), (1.0, 2.0, 2.0, 1.0), (1.0, 0.5, 1.0, 2.0)]
        {
            let fitted = fit(&camera("", true, own), picture);
            assert!((fitted.right.length() - right).abs() < 1e-12, "{own} in {picture}: {fitted:?}");
            assert!((fitted.up.length() - up).abs() < 1e-12, "{own} in {picture}: {fitted:?}");
        }
        let fitted = fit(&camera("", false, 2.0), 0.5);
        assert!((fitted.right.length() - 0.5).abs() < 1e-12 && (fitted.up.length() - 1.0).abs() < 1e-12);
    }

    #[test]
    fn cameras_in_numbers_follow_the_convention() {
        let turned = [[0.0, 0.0, 1.0, 5.0], [0.0, 1.0, 0.0, 6.0], [-1.0, 0.0, 0.0, 7.0], [0.0, 0.0, 0.0, 1.0]];
        let camera = fixed(&FixedView { camera_to_world: turned, vfov_deg: 90.0 }, 2.0).expect("sound");
        assert_eq!((camera.origin, camera.forward), (DVec3::new(5.0, 6.0, 7.0), DVec3::NEG_X));
        assert!((camera.right - DVec3::new(0.0, 0.0, -2.0)).length() < 1e-12);
        assert!((camera.up - DVec3::Y).length() < 1e-12);
        let flat = [[0.0; 4], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0], [0.0, 0.0, 0.0, 1.0]];
        assert!(fixed(&FixedView { camera_to_world: flat, vfov_deg: 90.0 }, 1.0).is_err());
        assert!(fixed(&FixedView { camera_to_world: turned, vfov_deg: 180.0 }, 1.0).is_err());
    }
}
