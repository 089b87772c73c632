//! Log-log plots, as SVG and as pixels.

mod axis;
mod canvas;
mod raster;
mod svg;

pub use canvas::{Anchor, Canvas, Ink};
pub use raster::Raster;
pub use svg::Svg;
pub(super) use svg::escape;

use axis::Axis;

/// Size of plots, in pixels and units of SVG.
pub const SIZE: (f64, f64) = (960.0, 560.0);
/// Left, top, right and bottom of the area that the curves are in.
const AREA: [f64; 4] = [78.0, 46.0, 700.0, 492.0];

/// A line with marks.
#[derive(Clone, Debug, PartialEq)]
pub struct Series {
    /// What the legend calls it.
    pub name: String,
    /// Points (x, y), both > 0; others are left out.
    pub points: Vec<(f64, f64)>,
    /// What each point is, for those who ask; as many as points.
    pub titles: Vec<String>,
}

/// A plot with logarithmic axes.
#[derive(Clone, Debug, PartialEq)]
pub struct LogLog {
    /// Above it.
    pub title: String,
    /// Below it.
    pub x: String,
    /// Beside it.
    pub y: String,
    /// The lines.
    pub series: Vec<Series>,
    /// A horizontal line with a word.
    pub level: Option<(f64, String)>,
}

impl LogLog {
    /// As an SVG document.
    pub fn to_svg(&self) -> String {
        let mut svg = Svg::new(SIZE, &self.title, &self.description());
        self.draw(&mut svg);
        svg.finish()
    }

    /// As pixels on white, 8-bit sRGB, row by row from the top.
    pub fn to_pixels(&self) -> Raster {
        let mut raster = Raster::new(SIZE.0 as u32, SIZE.1 as u32);
        self.draw(&mut raster);
        raster
    }

    /// What can be seen, in words.
    fn description(&self) -> String {
        let of = |s: &Series| match (s.points.first(), s.points.last()) {
            (Some(a), Some(b)) => format!("{}: from {:.3} at {:.3} to {:.3} at {:.3}", s.name, a.1, a.0, b.1, b.0),
            _ => format!("{}: nothing", s.name),
        };
        let lines: Vec<String> = self.series.iter().map(of).collect();
        format!("{} against {}, both logarithmic. {}.", self.y, self.x, lines.join("; "))
    }

    fn draw(&self, canvas: &mut dyn Canvas) {
        let [left, top, right, bottom] = AREA;
        let points = || self.series.iter().flat_map(|s| &s.points).filter(|p| p.0 > 0.0 && p.1 > 0.0);
        let level = self.level.as_ref().map(|l| l.0);
        let x = Axis::covering(points().map(|p| p.0), (left, right));
        let y = Axis::covering(points().map(|p| p.1).chain(level), (bottom, top));
        canvas.text((left, 26.0), &self.title, Anchor::Start, Ink::Text, true);
        for (value, label) in x.ticks() {
            let at = x.place(value);
            canvas.line(&[(at, top), (at, bottom)], Ink::Grid, 1.0);
            if let Some(label) = label {
                canvas.text((at, bottom + 20.0), &label, Anchor::Middle, Ink::Text, false);
            }
        }
        for (value, label) in y.ticks() {
            let at = y.place(value);
            canvas.line(&[(left, at), (right, at)], Ink::Grid, 1.0);
            if let Some(label) = label {
                canvas.text((left - 8.0, at + 5.0), &label, Anchor::End, Ink::Text, false);
            }
        }
        canvas.text((0.5 * (left + right), bottom + 46.0), &self.x, Anchor::Middle, Ink::Text, false);
        canvas.text((left, top - 4.0), &self.y, Anchor::Start, Ink::Text, false);
        if let Some((value, word)) = &self.level {
            let at = y.place(*value);
            canvas.line(&[(left, at), (right, at)], Ink::Text, 1.5);
            canvas.text((right - 6.0, at - 6.0), word, Anchor::End, Ink::Text, false);
        }
        for (number, series) in self.series.iter().enumerate() {
            let ink = Ink::Series(number);
            let kept: Vec<_> =
                series.points.iter().zip(&series.titles).filter(|(p, _)| p.0 > 0.0 && p.1 > 0.0).collect();
            let places: Vec<(f64, f64)> = kept.iter().map(|(p, _)| (x.place(p.0), y.place(p.1))).collect();
            canvas.line(&places, ink, 2.0);
            for (place, (_, title)) in places.iter().zip(&kept) {
                canvas.mark(*place, number, title);
            }
            let row = top + 12.0 + 24.0 * number as f64;
            canvas.line(&[(right + 22.0, row), (right + 50.0, row)], ink, 2.0);
            canvas.mark((right + 36.0, row), number, &series.name);
            canvas.text((right + 60.0, row + 5.0), &series.name, Anchor::Start, Ink::Text, false);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn plot() -> LogLog {
        let series = |name: &str, scale: f64| Series {
            name: name.into(),
            points: (0..5)
                .map(|i| (0.01 * f64::from(1 << (2 * i)), scale / f64::from(1 << i)))
                .chain([(1.0, 0.0)])
                .collect(),
            titles: (0..6).map(|i| format!("{i} <samples>")).collect(),
        };
        LogLog {
            title: "Error & time".into(),
            x: "seconds".into(),
            y: "levels".into(),
            series: vec![series("a<b", 8.0), series("c", 30.0)],
            level: Some((1.5, "seen".into())),
        }
    }

    #[test]
    fn the_svg_is_well_formed_and_tells_what_it_shows() {
        let svg = plot().to_svg();
        let mut open = Vec::new();
        for tag in svg.split('<').skip(1) {
            let (tag, rest) = tag.split_once('>').expect("every < is closed");
            assert!(
                !rest.contains('>') && !rest.contains('&') || rest.contains("&lt;") || rest.contains("&amp;"),
                "{rest}"
            );
            match tag.strip_prefix('/') {
                Some(name) => assert_eq!(open.pop(), Some(name.to_string())),
                None if tag.ends_with('/') => (),
                None => open.push(tag.split_whitespace().next().expect("a name").to_string()),
            }
        }
        assert!(open.is_empty(), "{open:?}");
        assert!(svg.contains("Error &amp; time") && svg.contains("a&lt;b") && svg.contains("role=\"img\""));
        // Five points and a mark in the legend for each of two series; the point at 0 has no place on a logarithmic axis.
        assert_eq!(svg.matches("class=\"mark").count(), 12);
    }

    #[test]
    fn the_pixels_show_the_curves_in_their_colours() {
        let raster = plot().to_pixels();
        assert_eq!(raster.pixels().len(), (SIZE.0 * SIZE.1) as usize);
        for number in 0..2 {
            let color = canvas::color(number);
            let count = raster.pixels().iter().filter(|p| p.iter().zip(color).all(|(a, b)| a.abs_diff(b) < 3)).count();
            assert!(count > 100, "series {number}: {count} pixels");
        }
    }
}
