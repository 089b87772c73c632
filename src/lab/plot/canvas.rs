/// Where a text lies beside its place.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Anchor {
    /// It begins there.
    Start,
    /// Its middle is there.
    Middle,
    /// It ends there.
    End,
}

/// What something is drawn with.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Ink {
    /// Black on white, or the other way round where it is dark.
    Text,
    /// Faint.
    Grid,
    /// The colour of a series, by its number.
    Series(usize),
}

/// What plots are drawn on. Places are (x, y) from the upper left corner.
pub trait Canvas {
    /// A line through points.
    fn line(&mut self, points: &[(f64, f64)], ink: Ink, width: f64);
    /// The mark of a series, by its number, and what it stands for.
    fn mark(&mut self, at: (f64, f64), series: usize, title: &str);
    /// A text on one line; `at` is on its base line.
    fn text(&mut self, at: (f64, f64), text: &str, anchor: Anchor, ink: Ink, bold: bool);
}

/// Colours that people with any colour vision tell apart (Okabe & Ito 2008), yellow darkened, and some more; sRGB.
const COLORS: [[u8; 3]; 10] = [
    [0, 114, 178],
    [213, 94, 0],
    [0, 158, 115],
    [204, 121, 167],
    [86, 180, 233],
    [230, 159, 0],
    [120, 94, 240],
    [176, 150, 20],
    [136, 136, 136],
    [150, 75, 60],
];

/// The colour of a series, sRGB.
pub(super) fn color(series: usize) -> [u8; 3] {
    COLORS[series % COLORS.len()]
}

/// The corners of a series' mark around its place; empty for a circle. When colours come again, they come with other marks.
pub(super) fn mark(series: usize) -> &'static [(f64, f64)] {
    match (series + series / COLORS.len()) % 5 {
        1 => &[(-4.5, -4.5), (4.5, -4.5), (4.5, 4.5), (-4.5, 4.5)],
        2 => &[(0.0, -6.0), (6.0, 5.0), (-6.0, 5.0)],
        3 => &[(0.0, -6.5), (6.5, 0.0), (0.0, 6.5), (-6.5, 0.0)],
        4 => &[(-6.0, -5.0), (6.0, -5.0), (0.0, 6.0)],
        _ => &[],
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn fifty_series_can_be_told_apart() {
        let looks: Vec<_> =
            (0..50).map(|series| (color(series), mark(series).len(), mark(series).first().copied())).collect();
        for (k, look) in looks.iter().enumerate() {
            assert!(!looks[..k].contains(look), "{k}");
        }
    }
}
