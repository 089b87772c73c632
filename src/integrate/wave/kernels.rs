//! What shading is compiled for: sets of effects, so that what a scene lacks is no question in its loops.
//!
//! One source, with the same operations in the same order: the same bytes from each kernel that has what a scene calls for. A third one
//! between the two, for metal-rough surfaces without coats and glass, made nothing faster (scripts/runs/2026-11-22-effects.md).

/// Effects that the surfaces of a scene may have; what is not among them is left out when shading is compiled.
pub(super) trait SurfaceEffects {
    /// Whatever a flat surface of one diffuse colour has not: other lobes, textures, normals at corners, layers, glass.
    const ANY: bool;
}

/// Flat surfaces of one diffuse colour each.
pub(super) struct Diffuse;

/// Everything.
pub(super) struct Full;

impl SurfaceEffects for Diffuse {
    const ANY: bool = false;
}

impl SurfaceEffects for Full {
    const ANY: bool = true;
}
