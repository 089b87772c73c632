use super::canvas::{Anchor, Canvas, Ink, color, mark};
use noto_sans_mono_bitmap::{FontWeight, RasterHeight, get_raster, get_raster_width};
use tiny_skia::{FillRule, LineJoin, Paint, Path, PathBuilder, Pixmap, Stroke, Transform};

/// Pixels that are drawn on, white at first.
pub struct Raster {
    width: u32,
    pixels: Vec<[u8; 3]>,
    map: Option<Pixmap>,
}

/// Height of letters: all that the font comes in.
const LETTERS: RasterHeight = RasterHeight::Size16;
/// From the upper edge of a letter's picture to its base line.
const BASE: i64 = 13;

impl Raster {
    /// White pixels.
    pub fn new(width: u32, height: u32) -> Self {
        Self {
            width,
            pixels: vec![[255; 3]; width as usize * height as usize],
            // `None` for a picture without pixels.
            map: Pixmap::new(width, height),
        }
    }

    /// Width in pixels.
    pub fn width(&self) -> u32 {
        self.width
    }

    /// The pixels, 8-bit sRGB, row by row from the top.
    pub fn pixels(&self) -> &[[u8; 3]] {
        &self.pixels
    }

    /// Lays a picture (sRGB) with its upper left corner there. What lies outside is left out.
    pub fn picture(&mut self, (left, top): (u32, u32), width: u32, picture: &[[u8; 3]]) {
        for (i, color) in picture.iter().enumerate() {
            let (x, y) = (left + i as u32 % width, top + i as u32 / width);
            self.blend((i64::from(x), i64::from(y)), *color, 255);
        }
    }

    fn blend(&mut self, (x, y): (i64, i64), color: [u8; 3], share: u8) {
        if x < 0 || x >= i64::from(self.width) || y < 0 {
            return;
        }
        if let Some(pixel) = self.pixels.get_mut(y as usize * self.width as usize + x as usize) {
            let mix = |under: u8, over: u8| {
                let (under, over, share) = (u32::from(under), u32::from(over), u32::from(share));
                ((under * (255 - share) + over * share + 127) / 255) as u8
            };
            *pixel = std::array::from_fn(|c| mix(pixel[c], color[c]));
        }
    }

    /// Draws a shape with smooth edges.
    fn shape(&mut self, path: Option<Path>, color: [u8; 3], stroke: Option<f64>) {
        let (Some(path), Some(mut map)) = (path, self.map.take()) else { return };
        let mut paint = Paint { anti_alias: true, ..Paint::default() };
        paint.set_color_rgba8(255, 255, 255, 255);
        match stroke {
            Some(width) => {
                let stroke = Stroke { width: width as f32, line_join: LineJoin::Round, ..Stroke::default() };
                map.stroke_path(&path, &paint, &stroke, Transform::identity(), None);
            }
            None => map.fill_path(&path, &paint, FillRule::Winding, Transform::identity(), None),
        }
        let bounds = path.bounds();
        let margin = stroke.unwrap_or(0.0) + 2.0;
        let rows = (f64::from(bounds.top()) - margin).max(0.0) as u32..(f64::from(bounds.bottom()) + margin) as u32;
        for y in rows.start..rows.end.min(map.height()) {
            let start = (y * self.width) as usize;
            for x in 0..self.width {
                let alpha = map.pixels()[start + x as usize].alpha();
                if alpha > 0 {
                    self.blend((i64::from(x), i64::from(y)), color, alpha);
                }
            }
            map.pixels_mut()[start..start + self.width as usize].fill(tiny_skia::PremultipliedColorU8::TRANSPARENT);
        }
        self.map = Some(map);
    }
}

fn paint(ink: Ink) -> [u8; 3] {
    match ink {
        Ink::Text => [34; 3],
        Ink::Grid => [221; 3],
        Ink::Series(number) => color(number),
    }
}

fn path_of(points: &[(f64, f64)], close: bool) -> Option<Path> {
    let mut path = PathBuilder::new();
    for (i, (x, y)) in points.iter().enumerate() {
        let (x, y) = (*x as f32, *y as f32);
        if i == 0 { path.move_to(x, y) } else { path.line_to(x, y) }
    }
    if close {
        path.close();
    }
    path.finish()
}

impl Canvas for Raster {
    fn line(&mut self, points: &[(f64, f64)], ink: Ink, width: f64) {
        self.shape(path_of(points, false), paint(ink), Some(width));
    }

    fn mark(&mut self, (x, y): (f64, f64), series: usize, _title: &str) {
        let path = match mark(series) {
            [] => PathBuilder::from_circle(x as f32, y as f32, 5.0),
            corners => {
                let corners: Vec<(f64, f64)> = corners.iter().map(|(a, b)| (x + a, y + b)).collect();
                path_of(&corners, true)
            }
        };
        self.shape(path, color(series), None);
    }

    fn text(&mut self, (x, y): (f64, f64), text: &str, anchor: Anchor, ink: Ink, bold: bool) {
        let advance = get_raster_width(FontWeight::Regular, LETTERS) as i64;
        let length = advance * text.chars().count() as i64;
        let mut left = x as i64
            - match anchor {
                Anchor::Start => 0,
                Anchor::Middle => length / 2,
                Anchor::End => length,
            };
        let top = y as i64 - BASE;
        for letter in text.chars() {
            // What the font does not have is shown as a question mark.
            let raster = get_raster(plain(letter), FontWeight::Regular, LETTERS)
                .or_else(|| get_raster('?', FontWeight::Regular, LETTERS));
            for (row, values) in raster.iter().flat_map(|r| r.rows().enumerate()) {
                for (column, value) in values.iter().enumerate() {
                    let at = (left + column as i64, top + row as i64);
                    self.blend(at, paint(ink), *value);
                    if bold {
                        self.blend((at.0 + 1, at.1), paint(ink), *value);
                    }
                }
            }
            left += advance;
        }
    }
}

/// Typographic signs as the font has them.
fn plain(letter: char) -> char {
    match letter {
        '’' => '\'',
        '–' | '—' | '−' => '-',
        _ => letter,
    }
}
