use super::entry::{Entry, Words};
use serde::Serialize;

/// All that the page shows.
#[derive(Serialize)]
pub(super) struct Contents {
    pub title: String,
    /// The name of the earlier run's folder.
    pub against: Option<String>,
    pub kiln: &'static str,
    /// Lines of the manifest that could not be read.
    pub unreadable: usize,
    pub words: Words,
    pub assets: Vec<Entry>,
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

/// One HTML file that loads pictures and nothing else.
///
/// # Errors
/// Only should a number not be finite, which JSON cannot say.
pub(super) fn html(contents: &Contents) -> serde_json::Result<String> {
    let data = for_script(&serde_json::to_string(contents)?);
    let script = format!("(() => {{\n\"use strict\";\n{}}})();\n", SCRIPTS.concat());
    let values = [escape(&contents.title), STYLES.concat(), data, script];
    // What is put in is never looked through for marks.
    let parts = include_str!("page/page.html").split("@@@");
    let mut values = values.into_iter();
    Ok(parts.fold(String::new(), |page, part| page + part + &values.next().unwrap_or_default()))
}

/// JSON that cannot end the `script` element that it stands in.
fn for_script(json: &str) -> String {
    json.replace('<', "\\u003c")
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
        let contents = Contents {
            title: evil.into(),
            against: None,
            kiln: "0",
            unreadable: 0,
            words: Words::default(),
            assets: vec![Entry { input: evil.into(), ..Entry::default() }],
        };
        let page = html(&contents).expect("finite");
        assert_eq!(page.matches("</script>").count(), 2, "the data's and the script's own");
        assert!(!page.contains("<!-- \""));
        let data = page.split("id=\"data\">").nth(1).and_then(|rest| rest.split("</script>").next()).expect("data");
        let data: serde_json::Value = serde_json::from_str(data).expect("JSON");
        assert_eq!(data["assets"][0]["input"], evil);
        assert_eq!(page.matches("\"use strict\"").count(), 1);
    }
}
