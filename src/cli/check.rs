use super::console::{Color, Console, print_line};
use super::exit::{Exit, Fatal};
use super::interrupt::Interrupt;
use super::summary::plural;
use clap::Args;
use kiln::Control;
use kiln::checks::{Row, Verdict, load, run};
use kiln::settings::{Integrator, Reuse};
use serde_json::json;
use std::path::PathBuf;

const EXAMPLES: &str = "\
Examples:
  kiln check                       the checks in scenes/checks
  kiln check my_checks --json | jq '.rows[] | select(.verdict != \"pass\")'

Exit codes: 0 all as expected, 1 some not, 2 no checks, or one that cannot be read";

/// `kiln check`.
#[derive(Args)]
#[command(after_help = EXAMPLES)]
pub struct CheckCommand {
    /// A folder of checks: .toml files, each beside a scene
    #[arg(default_value = "scenes/checks")]
    folder: PathBuf,
    /// Which integrator the checks try
    #[arg(long, value_enum, default_value_t)]
    integrator: CheckedIntegrator,
    /// Whether pixels use each other's paths
    #[arg(long, value_enum, value_name = "on|off", default_value_t)]
    reuse: Reuse,
    /// Print one JSON object
    #[arg(long)]
    json: bool,
    /// Print only what is not as expected, and the summary
    #[arg(short, long)]
    quiet: bool,
}

/// The integrators that simulate light.
#[derive(Clone, Copy, Debug, Default, clap::ValueEnum)]
enum CheckedIntegrator {
    /// Thousands of paths side by side: what renders pictures
    #[default]
    Path,
    /// One path after the other: what a replay follows
    Plain,
}

impl From<CheckedIntegrator> for Integrator {
    fn from(integrator: CheckedIntegrator) -> Self {
        match integrator {
            CheckedIntegrator::Path => Self::Path,
            CheckedIntegrator::Plain => Self::Plain,
        }
    }
}

impl CheckCommand {
    /// Does it.
    ///
    /// # Errors
    /// When there are no checks, or one cannot be read.
    pub fn run(self) -> Result<Exit, Fatal> {
        let checks = load(&self.folder).map_err(|message| {
            let hint = if self.folder.is_dir() { "" } else { " (Kiln's own are in scenes/checks of its source)" };
            Fatal::usage(format!("{message}{hint}"))
        })?;
        let control = Control::default();
        let _interrupt = Interrupt::watch(&control);
        let Ok(rows) = run(&checks, (self.integrator.into(), self.reuse), &control) else {
            return Ok(Exit::Interrupted);
        };
        let good = rows.iter().all(|r| r.verdict.is_good());
        if self.json {
            let summary = Summary::of(checks.len(), &rows);
            print_line(&json!({ "summary": summary, "rows": rows }).to_string());
        } else {
            self.table(&rows);
            print_line(&Summary::of(checks.len(), &rows).text());
        }
        Ok(if good { Exit::Done } else { Exit::Failed })
    }

    fn table(&self, rows: &[Row]) {
        let console = Console::new(self.quiet, false);
        let shown = || rows.iter().filter(|r| !self.quiet || !r.verdict.is_good());
        let width = shown().map(|r| r.case.len()).max().unwrap_or(0).max(4);
        if shown().next().is_some() {
            print_line(&format!(
                "{:width$}  {:10}  {:>12}  {:>12}  {:>10}  verdict",
                "case", "strategy", "expected", "got", "std error"
            ));
        }
        for row in shown() {
            let strategy = row.strategy.map_or(String::new(), |s| format!("{s:?}").to_lowercase());
            let color = match row.verdict {
                Verdict::Pass => Color::Green,
                Verdict::Known => Color::Yellow,
                _ => Color::Red,
            };
            let verdict = console.paint(&format!("{:?}", row.verdict).to_lowercase(), color);
            let note = if row.note.is_empty() { String::new() } else { format!(": {}", row.note) };
            print_line(&format!(
                "{:width$}  {strategy:10}  {:>12}  {:>12}  {:>10}  {verdict}{note}",
                row.case,
                number(row.expected),
                number(row.got),
                if row.standard_error == 0.0 { "0".into() } else { format!("{:.1e}", row.standard_error) },
            ));
        }
    }
}

/// Six significant digits, without a power of ten where that is short.
fn number(x: f64) -> String {
    if x == 0.0 || (1e-3..1e5).contains(&x.abs()) { format!("{x:.6}") } else { format!("{x:.5e}") }
}

#[derive(serde::Serialize)]
struct Summary {
    checks: usize,
    comparisons: usize,
    passed: usize,
    known_failures: usize,
    failed: usize,
    cpu_seconds: f64,
}

impl Summary {
    fn of(checks: usize, rows: &[Row]) -> Self {
        let count = |test: fn(Verdict) -> bool| rows.iter().filter(|r| test(r.verdict)).count();
        Self {
            checks,
            comparisons: rows.len(),
            passed: count(|v| v == Verdict::Pass),
            known_failures: count(|v| v == Verdict::Known),
            failed: count(|v| !v.is_good()),
            cpu_seconds: rows.iter().map(|r| r.cpu_seconds).sum(),
        }
    }

    fn text(&self) -> String {
        let mut text = format!(
            "{}, {}: {} passed",
            plural(self.checks, "check"),
            plural(self.comparisons, "comparison"),
            self.passed
        );
        if self.known_failures > 0 {
            text += &format!(", {} fail as known", self.known_failures);
        }
        if self.failed > 0 {
            text += &format!(", {} FAILED", self.failed);
        }
        text + &format!(" ({:.1} CPU seconds)", self.cpu_seconds)
    }
}
