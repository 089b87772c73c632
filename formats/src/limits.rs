/// Bounds on what an asset may ask for. Exceeding one is [`crate::ErrorCode::TooLarge`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
pub struct Limits {
    /// Bytes of any single file.
    pub max_file_bytes: u64,
    /// Triangles drawn, counted once per instance.
    pub max_triangles: u64,
    /// Texels of all images together.
    pub max_texels: u64,
    /// Nesting of groups, transforms and nodes.
    pub max_nesting: u32,
}

impl Default for Limits {
    /// 4 GiB a file, 100 M triangles, 1 G texels, 1000 levels.
    fn default() -> Self {
        Self { max_file_bytes: 4 << 30, max_triangles: 100_000_000, max_texels: 1 << 30, max_nesting: 1000 }
    }
}
