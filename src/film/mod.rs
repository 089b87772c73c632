//! Where samples are gathered.

/// A finished picture: linear, premultiplied RGBA, row by row from the top.
#[derive(Clone, Debug, PartialEq)]
pub struct Picture {
    /// Width in pixels.
    pub width: u32,
    /// Height in pixels.
    pub height: u32,
    /// `width · height` pixels: linear Rec. 709 radiance, premultiplied by the coverage in the fourth channel.
    pub pixels: Vec<[f32; 4]>,
}
