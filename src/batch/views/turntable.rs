use super::framing::{Extremes, inner_tangents, looking, size_of};
use super::{AZIMUTH, ELEVATION, UpFrame, points};
use glam::DVec3;
use kiln_formats::Scene;
use kiln_formats::scene::Camera;

/// The least distance of the camera from what the turning asset sweeps, as a share of the asset's size.
const LEAST_DISTANCE: f64 = 0.05;

/// `frames` cameras around the up axis through the middle of the asset, all at the same distance and height.
///
/// The frame holds what the asset sweeps in a whole turn, so no frame is cropped and the asset does not jump.
/// The first camera stands where the thumbnail's does, the others follow to the right.
pub fn frame(scene: &Scene, axes: &UpFrame, frames: u32, aspect: f64) -> Vec<Camera> {
    let (sin, cos) = (libm::sin(ELEVATION), libm::cos(ELEVATION));
    let tangents = inner_tangents(aspect);
    let (middle, eye) = match points::bounds(scene) {
        None => (DVec3::ZERO, DVec3::new(0.0, 0.0, -4.0)),
        Some(bounds) => {
            let middle = 0.5 * (bounds.0 + bounds.1);
            (middle, sweep(scene, axes, middle, tangents).camera(tangents, LEAST_DISTANCE * size_of(bounds)))
        }
    };
    (0..frames)
        .map(|k| {
            let outwards = axes.around(AZIMUTH + std::f64::consts::TAU * f64::from(k) / f64::from(frames));
            let forward = -(outwards * cos + axes.up * sin);
            let up = axes.up * cos - outwards * sin;
            // By symmetry the sweep is centred: eye.x is 0.
            looking(middle + up * eye.y + forward * eye.z, forward, up, aspect)
        })
        .collect()
}

/// The extremes over a whole turn of all points, in the axes of a camera that looks at the turning asset.
///
/// A point at radius r and height h is, at turn φ, at x = r sin φ, y = h cos ε − r cos φ sin ε and
/// z = −(r cos φ cos ε + h sin ε) for the elevation ε; the maximum of a·sin φ + b·cos φ is √(a² + b²).
fn sweep(scene: &Scene, axes: &UpFrame, middle: DVec3, (tx, ty): (f64, f64)) -> Extremes {
    let (sin, cos) = (libm::sin(ELEVATION), libm::cos(ELEVATION));
    let across = (1.0 + (tx * cos) * (tx * cos)).sqrt();
    let mut extremes = Extremes::EMPTY;
    points::for_each(scene, |p| {
        let p = p - middle;
        let h = p.dot(axes.up);
        let r = (p - axes.up * h).length();
        extremes.right = extremes.right.max(r * across + tx * sin * h);
        extremes.left = -extremes.right;
        extremes.top = extremes.top.max(r * (ty * cos - sin).abs() + h * (cos + ty * sin));
        extremes.bottom = extremes.bottom.min(h * (cos - ty * sin) - r * (ty * cos + sin));
        extremes.near = extremes.near.min(-(r * cos + h * sin));
    });
    extremes
}

#[cfg(test)]
mod tests {
    use super::super::MARGIN;
    use super::super::framing::tests::{cloud, reach};
    use super::*;
    use crate::settings::UpChoice;
    use glam::DAffine3;
    use kiln_formats::scene::UpAxis;
    use proptest::prelude::*;

    proptest! {
        #![proptest_config(ProptestConfig { cases: 128, ..ProptestConfig::default() })]
        #[test]
        fn no_frame_is_cropped_and_a_full_turn_fills_the_frame(
            points in proptest::collection::vec([-1.0f32..1.0, -3.0f32..3.0, -2.0f32..2.0], 3..30),
            aspect in 0.3f64..3.0,
            z_up in any::<bool>(),
        ) {
            let up = if z_up { UpAxis::Z } else { UpAxis::Y };
            let scene = cloud(&points, DAffine3::IDENTITY, up);
            let axes = UpFrame::of(&scene, UpChoice::Auto);
            let inner = 1.0 - 2.0 * MARGIN;
            let mut widest = 0.0f64;
            let cameras = frame(&scene, &axes, 720, aspect);
            let middle = 0.5 * (points::bounds(&scene).unwrap().0 + points::bounds(&scene).unwrap().1);
            let distance = (cameras[0].origin - middle).length();
            for camera in &cameras {
                let (x, y) = reach(camera, &scene);
                prop_assert!(x <= inner + 1e-9 && y <= inner + 1e-9, "cropped: {x} {y}");
                prop_assert!(((camera.origin - middle).length() - distance).abs() < 1e-9 * distance);
                widest = widest.max(x).max(y);
            }
            prop_assert!(widest > inner - 1e-3, "loose: {widest}");
        }
    }

    #[test]
    fn empty_and_single_frames_are_fine() {
        let axes = UpFrame::of(&Scene::default(), UpChoice::Auto);
        let cameras = frame(&Scene::default(), &axes, 1, 1.5);
        assert_eq!(cameras.len(), 1);
        assert!(cameras[0].origin.is_finite());
    }
}
