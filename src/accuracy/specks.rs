use crate::prepare::PreparedScene;

/// Roughness at which, and below, most pictures have met so few specks that bounds by their samples alone do not hold.
const ROUGHNESS: f64 = 0.2;
/// The least and the most that bounds are moved away.
const LIMITS: (f64, f64) = (2.0, 4.0);
/// Samples per pixel from which on a bound may end a picture of a scene with specks: before, those with the smallest errors by their own
/// account are those that have met none.
pub const ENOUGH_WITH_SPECKS: u32 = 256;

/// Whether some of a scene's light comes as rare, bright samples.
pub(super) fn comes_as_specks(scene: &PreparedScene) -> bool {
    factor(scene) > 1.0
}

/// How much further away the bound of the displayed error is than the samples say: measured on scenes of our own with spheres, knots and
/// bumpy bodies of metal and glass under lights without extent (`scripts/runs/2026-11-22-specks.md`).
pub(super) fn factor(scene: &PreparedScene) -> f64 {
    match &scene.rare_light {
        Some(rare) if rare.roughness > 0.0 => (ROUGHNESS / f64::from(rare.roughness)).clamp(LIMITS.0, LIMITS.1),
        _ => 1.0,
    }
}
