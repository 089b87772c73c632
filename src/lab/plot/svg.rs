use super::canvas::{Anchor, Canvas, Ink, color, mark};
use std::fmt::Write;

/// An SVG document that is read in light and in dark.
pub struct Svg {
    text: String,
}

// Within a page the style holds for the whole page: hence the class.
const STYLE: &str = "\
.plot text{font:13px system-ui,sans-serif;fill:#222}.plot .bold{font-weight:600;font-size:15px}.plot .grid{stroke:#ddd}\
.plot .ink{stroke:#222}.plot polyline{fill:none;stroke-linejoin:round}\
@media (prefers-color-scheme:dark){.plot text{fill:#ddd}.plot .grid{stroke:#3a3a3a}.plot .ink{stroke:#ddd}}";

/// Text with what XML reserves written otherwise.
pub(crate) fn escape(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}

impl Svg {
    /// An empty document with a name and a description for those who do not see it.
    pub fn new((width, height): (f64, f64), title: &str, description: &str) -> Self {
        let text = format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" class=\"plot\" viewBox=\"0 0 {width} {height}\" role=\"img\" aria-label=\"{}\">\n\
             <title>{}</title>\n<desc>{}</desc>\n<style>{STYLE}</style>\n",
            escape(title),
            escape(title),
            escape(description)
        );
        Self { text }
    }

    /// The whole document.
    pub fn finish(mut self) -> String {
        self.text += "</svg>\n";
        self.text
    }

    fn add(&mut self, element: std::fmt::Arguments) {
        // Writing to a string does not fail.
        let _ = self.text.write_fmt(element);
        self.text.push('\n');
    }
}

fn paint(ink: Ink) -> String {
    match ink {
        Ink::Text => "class=\"ink\"".into(),
        Ink::Grid => "class=\"grid\"".into(),
        Ink::Series(number) => format!("stroke=\"{}\"", hex(number)),
    }
}

fn hex(series: usize) -> String {
    let [r, g, b] = color(series);
    format!("#{r:02x}{g:02x}{b:02x}")
}

impl Canvas for Svg {
    fn line(&mut self, points: &[(f64, f64)], ink: Ink, width: f64) {
        let points: Vec<String> = points.iter().map(|(x, y)| format!("{x:.1},{y:.1}")).collect();
        self.add(format_args!("<polyline {} stroke-width=\"{width}\" points=\"{}\"/>", paint(ink), points.join(" ")));
    }

    fn mark(&mut self, (x, y): (f64, f64), series: usize, title: &str) {
        let (fill, title) = (hex(series), escape(title));
        match mark(series) {
            [] => self.add(format_args!(
                "<circle class=\"mark\" cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"5\" fill=\"{fill}\"><title>{title}</title></circle>"
            )),
            corners => {
                let points: Vec<String> = corners.iter().map(|(a, b)| format!("{:.1},{:.1}", x + a, y + b)).collect();
                let points = points.join(" ");
                self.add(format_args!(
                    "<polygon class=\"mark\" points=\"{points}\" fill=\"{fill}\"><title>{title}</title></polygon>"
                ));
            }
        }
    }

    fn text(&mut self, (x, y): (f64, f64), text: &str, anchor: Anchor, _ink: Ink, bold: bool) {
        let anchor = match anchor {
            Anchor::Start => "start",
            Anchor::Middle => "middle",
            Anchor::End => "end",
        };
        let class = if bold { " class=\"bold\"" } else { "" };
        let text = escape(text);
        self.add(format_args!("<text x=\"{x:.1}\" y=\"{y:.1}\" text-anchor=\"{anchor}\"{class}>{text}</text>"));
    }
}
