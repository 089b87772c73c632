//! From the scene IR to what rays meet: world-space triangles, lights, kd-tree.

pub mod kdtree;

use crate::settings::PrepareSettings;
use glam::DVec3;
use kiln_formats::{Control, Scene, Stopped};

/// What a scene is lit by beside its own lights.
#[derive(Clone, Debug, Default)]
pub enum EnvironmentSource {
    /// Nothing.
    None,
    /// The same radiance from everywhere.
    Constant([f32; 3]),
    /// An equirectangular picture: u = 0.5 + atan2(z, x)/2π, v = acos(y)/π from the top row.
    Image {
        /// Linear pixels.
        image: kiln_formats::scene::Image,
        /// Turns the environment about +Y, radians.
        rotation_y: f32,
        /// Multiplies its radiance.
        intensity: f32,
    },
    /// A soft key, fill and rim light of our own.
    #[default]
    Studio,
}

/// Seconds that parts of the preparation took.
#[derive(Clone, Copy, Debug, Default)]
pub struct PrepareTimes {
    /// Wall seconds of the kd-tree's build.
    pub kdtree: f64,
    /// CPU seconds of the kd-tree's build over all threads.
    pub kdtree_cpu: f64,
}

/// A scene ready to be rendered. Immutable and `Sync`.
#[derive(Debug)]
pub struct PreparedScene {
    /// World-space bounds (lower and upper corner) of everything drawn; `None` when nothing is.
    pub bounds: Option<(DVec3, DVec3)>,
    /// Triangles drawn, without degenerate ones.
    pub triangles: u64,
    /// Emitters: emissive triangles, punctual lights, environment.
    pub emitters: u64,
    /// Times.
    pub times: PrepareTimes,
}

/// Whether the scene brings light of its own: lights, or surfaces that emit (unlit ones do not count).
pub fn has_own_light(scene: &Scene) -> bool {
    !scene.lights.is_empty() || scene.materials.iter().any(|m| !m.emission.is_black())
}

/// Prepares a scene.
///
/// # Errors
/// [`Stopped`] when `control` asks for it.
pub fn prepare(
    scene: Scene,
    _environment: &EnvironmentSource,
    _settings: &PrepareSettings,
    control: &Control,
) -> Result<PreparedScene, Stopped> {
    control.check()?;
    Ok(PreparedScene { bounds: None, triangles: scene.triangle_count(), emitters: 0, times: PrepareTimes::default() })
}
