//! Which pictures are taken of an asset: its own camera, an auto-framed one, a turntable.

mod camera;
mod framing;
mod points;
mod side;
mod turntable;

pub use points::{bounds, for_each as for_each_point};

use crate::integrate::View;
use crate::settings::{CameraChoice, UpChoice, ViewSettings};
use glam::DVec3;
use kiln_formats::Scene;
use kiln_formats::scene::{Camera, UpAxis};

/// The views of an asset, at least one.
///
/// # Errors
/// A sentence, when a camera is asked for that the asset does not have, or a camera in numbers is degenerate.
pub fn plan(scene: &Scene, settings: &ViewSettings, show_environment: bool) -> Result<Vec<View>, String> {
    let (width, height) = (settings.width.max(1), settings.height.max(1));
    let aspect = f64::from(width) / f64::from(height);
    let cameras = cameras(scene, settings, aspect)?;
    Ok(cameras.into_iter().map(|camera| View { camera, width, height, show_environment }).collect())
}

fn cameras(scene: &Scene, settings: &ViewSettings, aspect: f64) -> Result<Vec<Camera>, String> {
    let axes = UpFrame::of(scene, settings.up);
    if let Some(fixed) = &settings.fixed {
        return Ok(vec![camera::fixed(fixed, aspect)?]);
    }
    if let Some(frames) = settings.turntable {
        return Ok(turntable::frame(scene, &axes, frames.max(1), aspect));
    }
    let own = match &settings.camera {
        CameraChoice::Auto => None,
        CameraChoice::Default => scene.cameras.first(),
        CameraChoice::Named(name) => Some(camera::find(scene, name)?),
    };
    Ok(vec![match own {
        Some(own) => camera::fit(own, aspect),
        None => framing::frame(scene, &axes, aspect),
    }])
}

/// Elevation of automatic cameras above the horizon, radians (20°).
const ELEVATION: f64 = 0.349_065_850_398_865_9;
/// How far automatic cameras stand to the right of the front, radians (35°).
const AZIMUTH: f64 = 0.610_865_238_198_015_3;
/// Half the field of view along the picture's shorter side, radians (14°).
const HALF_FIELD: f64 = 0.244_346_095_279_206_1;
/// Share of the picture's width and height that stays free at each edge.
const MARGIN: f64 = 0.04;

/// World axes as an asset means them.
struct UpFrame {
    up: DVec3,
    front: DVec3,
    right: DVec3,
}

impl UpFrame {
    /// Y up: the front looks along +Z (glTF). Z up: along −Y (Blender, 3ds Max).
    fn of(scene: &Scene, choice: UpChoice) -> Self {
        let up = match choice {
            UpChoice::Auto => scene.up,
            UpChoice::Y => UpAxis::Y,
            UpChoice::Z => UpAxis::Z,
        };
        match up {
            UpAxis::Y => Self { up: DVec3::Y, front: DVec3::Z, right: DVec3::X },
            UpAxis::Z => Self { up: DVec3::Z, front: DVec3::NEG_Y, right: DVec3::X },
        }
    }

    /// The horizontal unit vector towards a camera at this angle from the front, to the right.
    fn around(&self, azimuth: f64) -> DVec3 {
        self.front * libm::cos(azimuth) + self.right * libm::sin(azimuth)
    }
}

/// Half the field of view of automatic cameras as tangents: across, up.
fn half_tangents(aspect: f64) -> (f64, f64) {
    let half = libm::tan(HALF_FIELD);
    if aspect >= 1.0 { (half * aspect, half) } else { (half, half / aspect) }
}
