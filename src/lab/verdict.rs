use super::analysis::{Analysis, Curve};
use super::point::interpolate;
use crate::metrics::flip::just_noticeable;
use serde::Serialize;

/// What a person can do with a study of an asset.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Verdict {
    /// How many times as long half the error takes with the first way.
    pub half_costs: Option<f64>,
    /// The error below which nobody sees it, levels: there ꟻLIP is below what is just noticeable in 95 % of the picture.
    pub invisible_below: Option<f64>,
    /// Samples per pixel with which the first way comes there.
    pub invisible_spp: Option<u32>,
    /// CPU seconds in all that it takes.
    pub invisible_seconds: Option<f64>,
    /// All of it in sentences.
    pub text: String,
}

impl Verdict {
    /// Of an analysis; `None` when there is no curve.
    pub fn of(analysis: &Analysis) -> Option<Self> {
        let first = analysis.curves.first()?;
        let half_costs = first.slope.filter(|s| *s < -0.05).map(|s| libm::exp2(-1.0 / s));
        let seen = just_noticeable();
        let at = |wanted: &dyn Fn(&super::Point) -> f64| interpolate(&first.points, seen, |p| p.flip_p95, wanted);
        let invisible_below = at(&|p| p.error);
        let invisible_spp = at(&|p| f64::from(p.spp)).map(|spp| spp.ceil() as u32);
        let invisible_seconds = at(&|p| p.cpu_seconds.total);
        let mut verdict = Self { half_costs, invisible_below, invisible_spp, invisible_seconds, text: String::new() };
        verdict.text = verdict.sentences(analysis, first);
        Some(verdict)
    }

    fn sentences(&self, analysis: &Analysis, first: &Curve) -> String {
        let mut sentences = Vec::new();
        if let Some(factor) = self.half_costs {
            sentences.push(format!("Half the error costs {factor:.1} times the time."));
        }
        match (self.invisible_below, self.invisible_spp, self.invisible_seconds) {
            (Some(error), Some(spp), Some(seconds)) => sentences.push(format!(
                "Below {} levels of error hardly anybody sees it: {} (--spp {spp}, {} of CPU for a picture of this size).",
                digits(error),
                advice(error),
                time(seconds),
            )),
            _ => sentences.push(match first.points.last() {
                Some(last) => format!(
                    "The noise can still be seen with the most samples tried ({}, {} levels of error): study with a larger \
                     --budget to learn when it cannot.",
                    last.spp,
                    digits(last.error)
                ),
                None => "Nothing was measured.".into(),
            }),
        }
        if let Some(text) = best(analysis, first) {
            sentences.push(text);
        }
        let names = |of: fn(&Curve) -> bool| -> Vec<&str> {
            analysis.curves.iter().filter(|c| of(c)).map(|c| c.way.as_str()).collect()
        };
        let (biased, unsettled) = (names(|c| c.biased), names(|c| c.unsettled));
        if !biased.is_empty() {
            let word = if biased.len() == 1 { "is" } else { "are" };
            sentences.push(format!("{} {word} biased: no number of samples gives the true picture.", list(&biased)));
        }
        if !unsettled.is_empty() {
            let (has, it) = if unsettled.len() == 1 { ("has", "it finds") } else { ("have", "they find") };
            let who = list(&unsettled);
            sentences.push(format!("{who} {has} not settled on a brightness yet: {it} some of the light too rarely."));
        }
        sentences.join(" ")
    }
}

/// The error to ask for.
fn advice(error: f64) -> String {
    // In steps that a person would choose, and on the safe side.
    let steps = [0.25, 0.5, 0.75, 1.0, 1.5, 2.0, 3.0, 4.0, 5.0, 6.0, 8.0, 10.0, 12.0, 16.0];
    match steps.iter().rev().find(|s| **s <= error) {
        Some(step) => format!("use --error {step}"),
        None => "use --error 0.25".into(),
    }
}

/// Which way is faster than the first, and how the slowest compares.
fn best(analysis: &Analysis, first: &Curve) -> Option<String> {
    let fair = || analysis.curves.iter().filter(|c| !c.biased).filter_map(|c| Some((c, c.versus?)));
    let mut sentences = Vec::new();
    let fastest = fair().min_by(|a, b| a.1.ratio().total_cmp(&b.1.ratio()));
    if let Some((way, versus)) = fastest.filter(|f| f.1.ratio() < 0.9 && !f.1.at_least) {
        let (own, theirs) = (time(versus.first_seconds), time(versus.seconds));
        let error = digits(versus.error);
        sentences.push(format!(
            "Here {} is faster than {}: {theirs} instead of {own} for {error} levels.",
            way.way, first.way
        ));
    }
    let slowest = fair().max_by(|a, b| a.1.ratio().total_cmp(&b.1.ratio()));
    if let Some((way, versus)) = slowest.filter(|s| s.1.ratio() > 1.5) {
        let more = if versus.at_least { "more than " } else { "" };
        let (error, ratio) = (digits(versus.error), versus.ratio());
        sentences
            .push(format!("{} needs {more}{ratio:.1} times as long as {} for {error} levels.", way.way, first.way));
    }
    (!sentences.is_empty()).then(|| sentences.join(" "))
}

fn list(words: &[&str]) -> String {
    match words {
        [] => String::new(),
        [one] => (*one).into(),
        [all @ .., last] => format!("{} and {last}", all.join(", ")),
    }
}

/// A number with two or three digits that count.
pub(super) fn digits(x: f64) -> String {
    match x.abs() {
        a if a >= 100.0 => format!("{x:.0}"),
        a if a >= 10.0 => format!("{x:.1}"),
        a if a >= 0.1 || a == 0.0 => format!("{x:.2}"),
        a if a >= 1e-3 => format!("{x:.4}"),
        _ => format!("{x:.1e}"),
    }
}

/// Seconds for people.
pub(super) fn time(seconds: f64) -> String {
    match seconds {
        s if s >= 120.0 => format!("{:.0} min", s / 60.0),
        s if s >= 1.0 => format!("{s:.1} s"),
        s if s >= 0.01 => format!("{s:.2} s"),
        s => format!("{:.1} ms", 1e3 * s),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_for_people() {
        assert_eq!([0.0, 0.04567, 0.456, 12.34, 1234.5].map(digits), ["0.00", "0.0457", "0.46", "12.3", "1234"]);
        assert_eq!([0.0021, 0.5, 12.34, 600.0].map(time), ["2.1 ms", "0.50 s", "12.3 s", "10 min"]);
        assert_eq!(list(&["a", "b", "c"]), "a, b and c");
        assert_eq!((advice(2.9), advice(0.1)), ("use --error 2".into(), "use --error 0.25".into()));
    }
}
