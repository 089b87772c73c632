/// What a file says about itself beyond the scene that is made of it. Only glTF files say so much.
#[derive(Clone, Debug, Default, PartialEq, serde::Serialize)]
pub struct Contents {
    /// The tool that wrote the file, or empty.
    pub generator: String,
    /// Extensions that the file uses, in its order.
    pub extensions_used: Vec<String>,
    /// Those of them without which it does not want to be read.
    pub extensions_required: Vec<String>,
    /// Its animations.
    pub animations: Vec<Clip>,
    /// Names of its material variants (KHR_materials_variants).
    pub variants: Vec<String>,
    /// All its materials, used or not.
    pub materials: Vec<SourceMaterial>,
}

/// An animation.
#[derive(Clone, Debug, Default, PartialEq, serde::Serialize)]
pub struct Clip {
    /// Its name, or empty.
    pub name: String,
    /// Time of the last key, as the file states it; `None` where it does not.
    pub seconds: Option<f64>,
    /// Number of properties that it moves.
    pub channels: u64,
}

/// A material as the file has it.
#[derive(Clone, Debug, Default, PartialEq, serde::Serialize)]
pub struct SourceMaterial {
    /// Its name, or empty.
    pub name: String,
    /// The extensions on it, sorted.
    pub extensions: Vec<String>,
}
