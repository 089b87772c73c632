use super::console::{Color, Console, harmless};
use kiln::batch::{Status, Tally, advice};

/// What became of a batch, for people.
pub fn text(console: &Console, tally: &Tally, seconds: f64, manifest: &str) -> String {
    let statuses = [Status::Ok, Status::Warned, Status::Partial, Status::Failed, Status::Skipped];
    let counts: Vec<String> = statuses
        .iter()
        .filter(|s| tally.count(**s) > 0)
        .map(|s| match s {
            Status::Ok => console.paint(&format!("{} ok", tally.count(*s)), Color::Green),
            Status::Failed => console.paint(&format!("{} failed", tally.count(*s)), Color::Red),
            _ => console.paint(&format!("{} {}", tally.count(*s), s.word()), Color::Yellow),
        })
        .collect();
    let kept = if tally.kept > 0 { format!(" ({} up to date)", tally.kept) } else { String::new() };
    let mut lines = vec![format!(
        "{} in {seconds:.1} s: {}{kept}; {}",
        plural(tally.all(), "asset"),
        counts.join(", "),
        plural(tally.files, "file")
    )];
    if tally.slowest.len() > 2 && tally.all() > 3 {
        let slowest: Vec<String> =
            tally.slowest.iter().map(|(name, seconds)| format!("{} {seconds:.2} s", harmless(name))).collect();
        lines.push(format!("slowest: {}", slowest.join(", ")));
    }
    for (name, message) in &tally.failures {
        let failed = console.paint("failed:", Color::Red);
        lines.push(format!("{failed} {}: {}", harmless(name), harmless(message)));
    }
    let failed = tally.count(Status::Failed);
    if failed > tally.failures.len() {
        lines.push(format!("… and {} more", failed - tally.failures.len()));
    }
    let mut warnings: Vec<_> = tally.warnings.iter().collect();
    warnings.sort_by_key(|(_, warned)| std::cmp::Reverse(warned.assets));
    for (code, warned) in warnings {
        let more = if warned.assets > warned.examples.len() { ", …" } else { "" };
        let head = format!(
            "{}: {} ({}{more})",
            console.paint(code, Color::Yellow),
            plural(warned.assets, "asset"),
            harmless(&warned.examples.join(", "))
        );
        let advised = |a: &advice::Advice| match a.remedy {
            "nothing" => format!("{head}\n  {}", a.meaning),
            remedy => format!("{head}\n  {}: {remedy}", a.meaning),
        };
        lines.push(advice::of(code).map_or(head.clone(), advised));
    }
    lines.push(format!("manifest: {manifest}"));
    lines.join("\n")
}

/// `1 asset`, `2 assets`.
pub fn plural(count: usize, word: &str) -> String {
    format!("{count} {word}{}", if count == 1 { "" } else { "s" })
}
