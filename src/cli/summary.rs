use super::console::{Color, Console};
use kiln::batch::{Outcome, Status};

/// How many assets the summary names of those that took longest.
const SLOWEST: usize = 3;
/// How many failures the summary tells before it points to the manifest.
const FAILURES: usize = 20;

/// What became of a batch, for people.
pub fn text(console: &Console, outcomes: &[Outcome], seconds: f64, manifest: &str) -> String {
    let count = |status| outcomes.iter().filter(|o| o.status == status).count();
    let statuses = [Status::Ok, Status::Warned, Status::Partial, Status::Failed, Status::Skipped];
    let counts: Vec<String> = statuses
        .iter()
        .filter(|s| count(**s) > 0)
        .map(|s| match s {
            Status::Ok => console.paint(&format!("{} ok", count(*s)), Color::Green),
            Status::Failed => console.paint(&format!("{} failed", count(*s)), Color::Red),
            _ => console.paint(&format!("{} {}", count(*s), s.word()), Color::Yellow),
        })
        .collect();
    let pictures: usize = outcomes.iter().map(|o| o.outputs.len()).sum();
    let mut lines = vec![format!(
        "{} in {seconds:.1} s: {}; {}",
        plural(outcomes.len(), "asset"),
        counts.join(", "),
        plural(pictures, "file")
    )];
    let mut slowest: Vec<&Outcome> = outcomes.iter().filter(|o| o.status.is_done()).collect();
    slowest.sort_by(|a, b| b.seconds.total.total_cmp(&a.seconds.total));
    if slowest.len() > SLOWEST {
        let slowest: Vec<String> =
            slowest.iter().take(SLOWEST).map(|o| format!("{} {:.2} s", o.input, o.seconds.total)).collect();
        lines.push(format!("slowest: {}", slowest.join(", ")));
    }
    let failed: Vec<&Outcome> = outcomes.iter().filter(|o| o.status == Status::Failed).collect();
    for outcome in failed.iter().take(FAILURES) {
        let message = outcome.error_message.as_deref().unwrap_or_default();
        lines.push(format!("{} {}: {message}", console.paint("failed:", Color::Red), outcome.input));
    }
    if failed.len() > FAILURES {
        lines.push(format!("… and {} more", failed.len() - FAILURES));
    }
    lines.push(format!("manifest: {manifest}"));
    lines.join("\n")
}

/// `1 asset`, `2 assets`.
pub fn plural(count: usize, word: &str) -> String {
    format!("{count} {word}{}", if count == 1 { "" } else { "s" })
}
