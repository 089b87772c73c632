//! Which texels of an image have a property, and whether all have it that a triangle can show.

use kiln_formats::scene::{Image, Texture, TextureRef, Wrap};
use std::ops::Range;

/// A bit for each texel.
pub(super) struct Marks {
    bits: Vec<u64>,
    /// Words of a row.
    pitch: usize,
}

impl Marks {
    /// Of an image of this size; `marked` tells by column and row.
    pub fn new(width: u32, height: u32, marked: impl Fn(u32, u32) -> bool) -> Self {
        let pitch = width.div_ceil(64) as usize;
        let mut bits = vec![0; pitch * height as usize];
        for (y, row) in (0..height).zip(bits.chunks_exact_mut(pitch.max(1))) {
            for x in 0..width {
                row[x as usize / 64] |= u64::from(marked(x, y)) << (x % 64);
            }
        }
        Self { bits, pitch }
    }

    /// Whether all texels of an area are marked. `words` is how many words may be read, and goes down by those that were;
    /// false when there are too few left.
    pub fn all_in(&self, area: &Area, words: &mut u64) -> bool {
        for y in area.rows.iter().cloned().flatten() {
            for columns in &area.columns {
                if !self.all_between(y as usize, columns, words) {
                    return false;
                }
            }
        }
        true
    }

    fn all_between(&self, y: usize, columns: &Range<u32>, words: &mut u64) -> bool {
        if columns.is_empty() {
            return true;
        }
        let (first, last) = (columns.start as usize / 64, (columns.end as usize - 1) / 64);
        for k in first..=last {
            let from = if k == first { !0 << (columns.start % 64) } else { !0 };
            let to = if k == last { !0 >> (63 - (columns.end - 1) % 64) } else { !0 };
            let wanted: u64 = from & to;
            if *words == 0 || self.bits[y * self.pitch + k] & wanted != wanted {
                return false;
            }
            *words -= 1;
        }
        true
    }
}

/// Texels that a triangle can show, or more: columns and rows, each in up to two runs.
#[derive(Debug, PartialEq)]
pub(super) struct Area {
    columns: [Range<u32>; 2],
    rows: [Range<u32>; 2],
}

/// Texture coordinates beyond so many texels are too coarse to tell which texels they mean.
const FARTHEST: f32 = 524_288.0;

impl Area {
    /// Of a triangle with these coordinates at its corners, before the reference's transform. `None` where they are no
    /// numbers or too large.
    pub fn of(image: &Image, texture: &Texture, reference: &TextureRef, corners: [[f32; 2]; 3]) -> Option<Self> {
        let uvs = corners.map(|uv| reference.transform.apply(uv));
        // Points between are mixed before the transform, which may take large numbers back to small ones.
        let largest = corners.iter().flatten().fold(0.0, |largest: f32, x| largest.max(x.abs()));
        let linear = [[1.0, 0.0], [0.0, 1.0]].map(|unit| {
            let (at, zero) = (reference.transform.apply(unit), reference.transform.apply([0.0; 2]));
            (at[0] - zero[0]).abs().max((at[1] - zero[1]).abs())
        });
        let reach = largest * (linear[0] + linear[1]) * image.width.max(image.height) as f32;
        if !(reach < FARTHEST) {
            return None;
        }
        let span = |axis: usize, size: u32, wrap: Wrap| {
            let along = uvs.map(|uv| uv[axis] * size as f32);
            let near = along.iter().all(|x| x.abs() < FARTHEST);
            near.then(|| {
                span(along.into_iter().fold(along[0], f32::min), along.into_iter().fold(along[0], f32::max), size, wrap)
            })
        };
        let columns = span(0, image.width, texture.wrap_u)?;
        let rows = span(1, image.height, texture.wrap_v)?;
        Some(Self { columns, rows })
    }
}

/// Texels between two places along an axis, with those that are mixed in from both sides and one more for rounding.
fn span(low: f32, high: f32, size: u32, wrap: Wrap) -> [Range<u32>; 2] {
    let (low, high, count) = ((low - 0.5).floor() as i64 - 1, (high - 0.5).floor() as i64 + 2, i64::from(size));
    let whole = [0..size, 0..0];
    match wrap {
        Wrap::Clamp => [low.clamp(0, count - 1) as u32..high.clamp(0, count - 1) as u32 + 1, 0..0],
        _ if high - low >= count - 1 => whole,
        // Inside the image all are alike.
        _ if low >= 0 && high < count => [low as u32..high as u32 + 1, 0..0],
        Wrap::Mirror => whole,
        Wrap::Repeat => {
            let (low, high) = (low.rem_euclid(count) as u32, high.rem_euclid(count) as u32);
            if low <= high { [low..high + 1, 0..0] } else { [low..size, 0..high + 1] }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn areas_wrap_as_textures_do() {
        let at = |low, high, wrap| span(low, high, 16, wrap);
        assert_eq!(at(4.6, 6.4, Wrap::Repeat), [3..8, 0..0]);
        assert_eq!(at(0.2, 1.0, Wrap::Repeat), [14..16, 0..3]);
        assert_eq!(at(0.2, 1.0, Wrap::Clamp), [0..3, 0..0]);
        assert_eq!(at(0.2, 1.0, Wrap::Mirror), [0..16, 0..0]);
        assert_eq!(at(36.6, 38.4, Wrap::Repeat), at(4.6, 6.4, Wrap::Repeat));
        assert_eq!(at(36.6, 38.4, Wrap::Clamp), [15..16, 0..0]);
        assert_eq!(at(-20.0, 20.0, Wrap::Repeat), [0..16, 0..0]);
    }

    #[test]
    fn all_texels_of_an_area_are_asked_and_no_others() {
        let marks = Marks::new(150, 3, |x, y| y == 1 && (60..130).contains(&x));
        let all = |columns, y: u32| {
            let area = Area { columns: [columns, 0..0], rows: [y..y + 1, 0..0] };
            marks.all_in(&area, &mut 1000)
        };
        assert!(all(60..130, 1) && all(64..128, 1) && all(100..101, 1));
        assert!(!all(59..130, 1) && !all(60..131, 1) && !all(60..61, 0) && !all(149..150, 1));
        let area = Area { columns: [60..130, 0..0], rows: [1..2, 0..0] };
        assert!(!marks.all_in(&area, &mut 2), "three words are needed");
    }
}
