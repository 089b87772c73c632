//! Light transport: from a prepared scene and a view to a film.

use crate::film::Picture;
use crate::prepare::PreparedScene;
use crate::settings::RenderSettings;
use kiln_formats::scene::Camera;
use kiln_formats::{Control, Stopped};

/// What a picture shows.
#[derive(Clone, Debug, PartialEq)]
pub struct View {
    /// The camera; its image plane already has the picture's aspect ratio.
    pub camera: Camera,
    /// Width in pixels, ≥ 1.
    pub width: u32,
    /// Height in pixels, ≥ 1.
    pub height: u32,
    /// Whether camera rays that hit nothing show the environment (alpha 1) or nothing (alpha 0).
    pub show_environment: bool,
}

/// Rays traced.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
pub struct RayCounts {
    /// From the camera.
    pub camera: u64,
    /// From surfaces, by BSDF sampling.
    pub bounce: u64,
    /// To lights.
    pub shadow: u64,
}

/// What a render gives.
#[derive(Clone, Debug)]
pub struct Rendered {
    /// The picture.
    pub picture: Picture,
    /// Samples per pixel in it.
    pub spp: u32,
    /// Rays traced for it.
    pub rays: RayCounts,
    /// Samples dropped because they were not finite.
    pub nonfinite: u64,
    /// CPU seconds over all threads.
    pub cpu_seconds: f64,
}

/// Renders a view on the current rayon pool. The progress counts pixels.
///
/// # Errors
/// [`Stopped`] when `control` asks for it.
pub fn render(
    _scene: &PreparedScene,
    view: &View,
    settings: &RenderSettings,
    control: &Control,
) -> Result<Rendered, Stopped> {
    let n = u64::from(view.width) * u64::from(view.height);
    control.begin(n);
    control.check()?;
    control.advance(n);
    let pixels = vec![[0.5, 0.25, 0.125, 1.0]; n as usize];
    Ok(Rendered {
        picture: Picture { width: view.width, height: view.height, pixels },
        spp: settings.spp,
        rays: RayCounts::default(),
        nonfinite: 0,
        cpu_seconds: 0.0,
    })
}
