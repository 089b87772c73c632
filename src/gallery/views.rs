use super::record::{Output, Record};
use serde::Serialize;

/// The pictures of an asset.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub(super) struct Views {
    pub width: u32,
    pub height: u32,
    /// PNG files below the folder, view by view.
    #[serde(skip_serializing_if = "Paths::is_empty")]
    pub png: Paths,
    /// EXR files.
    #[serde(skip_serializing_if = "Paths::is_empty")]
    pub exr: Paths,
    /// PNG files without noise.
    #[serde(skip_serializing_if = "Paths::is_empty")]
    pub denoised: Paths,
    /// Samples per pixel of each view.
    pub spp: Same<u32>,
    /// Exposure, EV.
    pub exposure: f64,
    /// Stated error of each view, levels of 255.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub error: Vec<Option<f64>>,
    /// Upper 95 % bound of it.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub bound: Vec<Option<f64>>,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub relmse: Vec<Option<f64>>,
    /// Whether all views reached the error that was asked for.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub met: Option<bool>,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub bias: Vec<String>,
}

impl Views {
    /// `None`: there is no picture.
    pub fn of(record: &Record) -> Option<Self> {
        let first = record.outputs.first()?;
        let all = |wanted: &dyn Fn(&Output) -> bool| -> Vec<&Output> {
            let mut outputs: Vec<&Output> = record.outputs.iter().filter(|o| wanted(o)).collect();
            outputs.sort_by_key(|o| o.view);
            outputs
        };
        let (png, exr) = (all(&|o| o.is_rendered("png")), all(&|o| o.is_rendered("exr")));
        let denoised = all(&Output::is_denoised_png);
        let views = if png.is_empty() { &exr } else { &png };
        let each = |of: fn(&Output) -> Option<f64>| -> Vec<Option<f64>> {
            let values: Vec<_> = views.iter().map(|o| of(o).map(rounded)).collect();
            if values.iter().all(Option::is_none) { Vec::new() } else { values }
        };
        let met: Vec<bool> = views.iter().filter_map(|o| o.target_met).collect();
        Some(Self {
            width: first.width,
            height: first.height,
            spp: Same(views.iter().map(|o| o.spp).collect()),
            exposure: rounded(first.exposure),
            error: each(|o| o.error),
            bound: each(|o| o.error_bound),
            relmse: each(|o| o.relmse),
            met: (!met.is_empty()).then(|| met.iter().all(|met| *met)),
            bias: first.bias.clone(),
            png: Paths::of(&png),
            exr: Paths::of(&exr),
            denoised: Paths::of(&denoised),
        })
    }
}

/// Four digits are more than a page shows.
pub(super) fn rounded(value: f64) -> f64 {
    // What is parsed from text with four digits is written with four digits.
    format!("{value:.3e}").parse().unwrap_or(value)
}

/// Files, view by view.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(untagged)]
pub(super) enum Paths {
    /// Any files.
    List(Vec<String>),
    /// Numbered from 000 with at least three digits, as turntables are.
    Numbered { before: String, after: String, count: usize },
}

impl Default for Paths {
    fn default() -> Self {
        Self::List(Vec::new())
    }
}

impl Paths {
    fn of(outputs: &[&Output]) -> Self {
        let numbered = || {
            let (before, after) = outputs.first()?.path.rsplit_once("000")?;
            let is = |(index, output): (usize, &&Output)| output.path == format!("{before}{index:03}{after}");
            let numbered = outputs.len() > 1 && outputs.iter().enumerate().all(is);
            numbered.then(|| Self::Numbered { before: before.into(), after: after.into(), count: outputs.len() })
        };
        numbered().unwrap_or_else(|| Self::List(outputs.iter().map(|o| o.path.clone()).collect()))
    }

    pub fn is_empty(&self) -> bool {
        matches!(self, Self::List(list) if list.is_empty())
    }

    /// Each path with something put before it.
    pub fn below(self, folder: &str) -> Self {
        match self {
            Self::List(list) => Self::List(list.into_iter().map(|path| format!("{folder}{path}")).collect()),
            Self::Numbered { before, after, count } => {
                Self::Numbered { before: format!("{folder}{before}"), after, count }
            }
        }
    }
}

/// Values that are one value where they are equal.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Same<T>(pub Vec<T>);

impl<T: Serialize + PartialEq> Serialize for Same<T> {
    fn serialize<S: serde::Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        match &self.0[..] {
            [first, rest @ ..] if rest.iter().all(|v| v == first) => first.serialize(serializer),
            all => all.serialize(serializer),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn output(path: &str, view: u32) -> Output {
        Output { path: path.into(), format: "png".into(), view, spp: 4, ..Output::default() }
    }

    #[test]
    fn turntables_are_told_in_short() {
        let outputs: Vec<Output> = (0..1100).map(|k| output(&format!("000/a.glb.{k:03}.png"), k)).collect();
        let paths = Paths::of(&outputs.iter().collect::<Vec<_>>());
        let want = Paths::Numbered { before: "000/a.glb.".into(), after: ".png".into(), count: 1100 };
        assert_eq!(paths, want);
        let one = [output("a.000.png", 0)];
        assert_eq!(Paths::of(&[&one[0]]), Paths::List(vec!["a.000.png".into()]));
        let gap = [output("a.000.png", 0), output("a.002.png", 2)];
        assert_eq!(Paths::of(&[&gap[0], &gap[1]]), Paths::List(vec!["a.000.png".into(), "a.002.png".into()]));
    }

    #[test]
    fn views_are_in_order_whatever_the_files_order() {
        let record = Record { outputs: vec![output("a.001.png", 1), output("a.000.png", 0)], ..Record::default() };
        let views = Views::of(&record).expect("pictures");
        assert_eq!(views.png, Paths::Numbered { before: "a.".into(), after: ".png".into(), count: 2 });
        let json = serde_json::to_value(&views).expect("finite");
        assert_eq!(json["spp"], 4, "equal values are one");
    }

    #[test]
    fn four_digits_are_kept() {
        assert_eq!(rounded(12345.678), 12350.0);
        assert_eq!(rounded(0.001_234_56), 0.001_235);
        assert_eq!(rounded(0.0), 0.0);
    }
}
