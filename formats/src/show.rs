/// Which of its looks an asset is shown in. What an asset does not have is no error: a chair without variants is the
/// chair in every variant.
#[derive(Clone, Debug, Default, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Show {
    /// The animation to take the pose from: its name, its index when none has the name, or `all` for all at once. `None`: the first, if there is a `time`.
    pub animation: Option<String>,
    /// Moment of the animation, seconds from its beginning. `None`: 0, if there is an `animation`; else the rest pose.
    pub time: Option<f64>,
    /// The material variant (KHR_materials_variants): its name, or its index when none has the name.
    pub variant: Option<String>,
}

impl Show {
    /// Whether a moment of an animation is asked for, and not the rest pose.
    pub fn is_animated(&self) -> bool {
        self.animation.is_some() || self.time.is_some()
    }

    /// The index of what a choice means: the first of this name, else the one with this index.
    pub(crate) fn find(names: &[String], choice: &str) -> Option<usize> {
        let by_name = names.iter().position(|name| name == choice);
        by_name.or_else(|| choice.parse().ok().filter(|index| *index < names.len()))
    }
}
