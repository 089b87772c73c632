use super::entry::{Entry, Words};
use serde::Serialize;
use std::io::{self, Write};

/// What the page shows beside the assets.
#[derive(Serialize)]
pub(super) struct Head {
    pub title: String,
    /// The name of the earlier run's folder.
    pub against: Option<String>,
    pub kiln: &'static str,
}

/// The page's parts, in the order in which they run.
const SCRIPTS: [&str; 8] = [
    include_str!("page/data.js"),
    include_str!("page/facets.js"),
    include_str!("page/figures.js"),
    include_str!("page/turntable.js"),
    include_str!("page/grid.js"),
    include_str!("page/details.js"),
    include_str!("page/toolbar.js"),
    include_str!("page/main.js"),
];

const STYLES: [&str; 3] =
    [include_str!("page/base.css"), include_str!("page/grid.css"), include_str!("page/details.css")];

/// One HTML file that loads pictures and nothing else, written asset by asset: there may be millions.
pub(super) struct Page<W> {
    target: W,
    /// What comes after the data.
    rest: String,
    assets: usize,
}

impl<W: Write> Page<W> {
    /// Writes all that comes before the assets.
    ///
    /// # Errors
    /// Those of the target.
    pub fn begin(mut target: W, head: &Head) -> io::Result<Self> {
        // What is put in is never looked through for marks.
        let mut parts = include_str!("page/page.html").split("@@@");
        let mut part = || parts.next().unwrap_or_default();
        let before = [part(), &escape(&head.title), part(), &STYLES.concat(), part()].concat();
        let script = format!("(() => {{\n\"use strict\";\n{}}})();\n", SCRIPTS.concat());
        let rest = [part(), &script, part()].concat();
        let fields = json(head)?;
        let fields = fields.strip_suffix('}').unwrap_or(&fields);
        write!(target, "{before}{fields},\"assets\":[")?;
        Ok(Self { target, rest, assets: 0 })
    }

    /// Adds an asset.
    ///
    /// # Errors
    /// As [`Self::begin`].
    pub fn add(&mut self, entry: &Entry) -> io::Result<()> {
        let comma = if self.assets > 0 { ",\n" } else { "" };
        self.assets += 1;
        write!(self.target, "{comma}{}", json(entry)?)
    }

    /// Writes what is left: how many lines of the manifest could not be read, the texts that assets share, and the page's script.
    ///
    /// # Errors
    /// As [`Self::begin`].
    pub fn end(mut self, unreadable: usize, words: &Words) -> io::Result<()> {
        write!(self.target, "],\"unreadable\":{unreadable},\"words\":{}}}{}", json(words)?, self.rest)?;
        self.target.flush()
    }
}

/// JSON that cannot end the `script` element that it stands in.
fn json(value: &impl Serialize) -> io::Result<String> {
    Ok(serde_json::to_string(value)?.replace('<', "\\u003c"))
}

fn escape(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nothing_that_a_name_says_is_markup() {
        let evil = "</script><script>alert(1)</script><!-- \" ' @@@ \u{2028} 椅子";
        let mut page = Vec::new();
        let head = Head { title: evil.into(), against: None, kiln: "0" };
        let mut writer = Page::begin(&mut page, &head).expect("begins");
        let mut words = Words::default();
        for _ in 0..2 {
            let effects = vec![words.number(evil)];
            writer.add(&Entry { input: evil.into(), effects, ..Entry::default() }).expect("finite");
        }
        writer.end(3, &words).expect("ends");
        let page = String::from_utf8(page).expect("text");
        assert_eq!(page.matches("</script>").count(), 2, "the data's and the script's own");
        assert!(!page.contains("<!-- \""));
        let data = page.split("id=\"data\">").nth(1).and_then(|rest| rest.split("</script>").next()).expect("data");
        let data: serde_json::Value = serde_json::from_str(data).expect("JSON");
        assert_eq!(data["assets"].as_array().map(Vec::len), Some(2));
        assert_eq!(
            (&data["assets"][1]["input"], &data["title"], &data["words"][0]),
            (&evil.into(), &evil.into(), &evil.into())
        );
        assert_eq!(data["unreadable"], 3);
        assert_eq!(page.matches("\"use strict\"").count(), 1);
    }
}
