//! The scenes with known light, as `kiln check` runs them.

#![allow(clippy::disallowed_methods, reason = "expected values may come from std's functions")]

use kiln::Control;
use kiln::checks::{load, run};
use kiln::settings::{Integrator, Reuse};
use std::path::Path;

#[test]
fn every_check_comes_out_as_its_file_says() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/checks");
    let checks = load(&folder).expect("checks that can be read");
    assert!(checks.len() >= 80, "only {} checks", checks.len());
    let rows = run(&checks, (Integrator::Path, Reuse::Off), &Control::default()).expect("not stopped");
    let bad: Vec<String> = rows
        .iter()
        .filter(|r| !r.verdict.is_good())
        .map(|r| {
            format!(
                "{} {:?}: {:?}: expected {}, got {} ± {} {}",
                r.case, r.strategy, r.verdict, r.expected, r.got, r.standard_error, r.note
            )
        })
        .collect();
    assert!(bad.is_empty(), "{}", bad.join("\n"));
    assert!(rows.iter().map(|r| r.cpu_seconds).sum::<f64>() < 120.0, "the checks have become slow");
}
