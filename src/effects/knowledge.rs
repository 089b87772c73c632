use crate::settings::{Effect, EffectSet};

/// What is made of the effects that a scene calls for: what is not among the known ones is not asked about at hits.
#[derive(Clone, Copy, Debug, Default)]
pub struct Knowledge {
    /// Reckoned with whether called for or not.
    pub forced: EffectSet,
    /// Overlooked though called for: how tests see that each effect's analysis matters.
    pub overlooked: EffectSet,
}

impl Knowledge {
    /// Those of the effects called for that decide which code can do a surface.
    pub fn own(self, called: EffectSet) -> EffectSet {
        called.but(self.overlooked)
    }

    /// The effects that have to be reckoned with where these are called for.
    pub fn asked(self, called: EffectSet) -> EffectSet {
        self.own(called).and(self.forced)
    }

    /// Effects whose presence is asked about at hits by all kinds of surfaces, so that forcing them costs something (a clear coat of
    /// strength 0 is sampled and evaluated like any other). The others are models of scattering, kinds of lights, and bodies: each material and each list of lights has its own, and nothing is
    /// left out for the lack of another.
    pub const ASKED: [Effect; 11] = [
        Effect::Textures,
        Effect::NormalMaps,
        Effect::VertexColors,
        Effect::SmoothNormals,
        Effect::AlphaCutouts,
        Effect::AlphaBlending,
        Effect::Culling,
        Effect::Specular,
        Effect::Metal,
        Effect::Clearcoat,
        Effect::Emission,
    ];
}
