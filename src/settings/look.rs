use kiln_formats::Show;
use kiln_formats::ray::RayOptions;
use serde::{Deserialize, Serialize};

/// Which looks of an asset are pictured.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct LookSettings {
    /// The one look, or what all of them have in common.
    pub show: Show,
    /// Every material variant gets pictures of its own.
    pub every_variant: bool,
    /// The frames of a turntable go through the animation once, from `show.time` on.
    pub play: bool,
    /// How `.ray` files are taken.
    pub ray: RayOptions,
}

impl LookSettings {
    /// Whether the asset has to be read once for each of its looks.
    pub fn are_many(&self) -> bool {
        self.every_variant || self.play
    }
}
