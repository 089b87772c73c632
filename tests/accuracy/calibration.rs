//! Whether pictures are as far from the converged one as they say. `examples/calibrate.rs` asks the same of whole assets.

#[path = "../../examples/calibrate/trial.rs"]
#[allow(dead_code, reason = "the example writes all of it down")]
mod trial;

use crate::common::{add, lambert, sphere};
use crate::passes::room;
use glam::{DAffine3, DVec3};
use kiln::batch::{Outcome, Ready};
use kiln::prepare::{EnvironmentSource, PreparedScene, prepare};
use kiln::settings::{PrepareSettings, RenderSettings, Reuse};
use kiln::{Control, Scene, integrate::View};
use trial::Row;

const SEEDS: u64 = 24;
const SPP: u32 = 32;

fn rows(name: &str, (scene, view): (PreparedScene, View), reuse: Reuse) -> Vec<Row> {
    let view = View { width: 24, height: 24, ..view };
    let ready = Ready { scene, views: vec![view], exposure: 0.0, outcome: Outcome::skipped(name, 0) };
    let way = RenderSettings { spp: SPP, reuse, ..RenderSettings::default() };
    trial::run(name, &ready, &way, SEEDS, None).expect("not stopped")
}

/// A ball in the studio, seen before nothing.
fn ball() -> (PreparedScene, View) {
    let mut scene = Scene::default();
    add(&mut scene, sphere(4), lambert(0.6, 0.0), DAffine3::IDENTITY);
    let prepared = prepare(scene, &EnvironmentSource::Studio, &PrepareSettings::default(), &Control::default());
    let view = crate::common::view(DVec3::new(0.0, 1.0, 4.0), DVec3::ZERO, 32.0, 24);
    (prepared.expect("not stopped"), View { show_environment: false, ..view })
}

#[test]
fn stated_errors_are_true_and_their_bounds_hold() {
    let all = [rows("room", room(), Reuse::Off), rows("ball", ball(), Reuse::Off)];
    for rows in &all {
        // The mean of stated variances is the mean of true squared errors. Each varies by about √(2/n) with n ≈ 400
        // pixels; over 24 pictures that comes to 2 %. Four times that, and the curve's share of a few per cent.
        let of = |get: fn(&Row) -> f64| {
            let of_way = rows.iter().filter(|r| r.way == "spp 16");
            of_way.map(|r| get(r) * get(r)).sum::<f64>()
        };
        let ratio = (of(|r| r.stated.error) / of(|r| r.error)).sqrt();
        println!("{}: stated over true {ratio:.3}", rows[0].asset);
        assert!((0.95..1.08).contains(&ratio), "{}: states {ratio} times its error", rows[0].asset);
    }
    let all: Vec<&Row> = all.iter().flatten().collect();
    let looked = all.iter().filter(|r| r.way.starts_with("error")).count();
    assert!(looked > 24, "{looked} renders stopped by themselves");
    let held = all.iter().filter(|r| r.error <= r.stated.error_bound).count() as f64;
    let (n, p) = (all.len() as f64, 0.95);
    println!("{held} of {n} bounds hold");
    // Looks at one render are not independent: as if there were half of them.
    assert!(held / n > p - 4.0 * (p * (1.0 - p) / (0.5 * n)).sqrt(), "{held} of {n} bounds hold");
    let mut tightness: Vec<f64> = all.iter().map(|r| r.stated.error_bound / r.error).collect();
    tightness.sort_by(f64::total_cmp);
    let median = tightness[tightness.len() / 2];
    println!("median bound over true error {median:.3}");
    assert!(median < 1.2, "bounds are loose: {median}");
}

#[test]
fn bounds_hold_where_pixels_use_each_others_paths() {
    let rows = rows("room", room(), Reuse::On);
    let held = rows.iter().filter(|r| r.error <= r.stated.error_bound).count() as f64;
    let (n, p) = (rows.len() as f64, 0.95);
    println!("{held} of {n} bounds hold");
    assert!(held / n > p - 4.0 * (p * (1.0 - p) / (0.5 * n)).sqrt(), "{held} of {n} bounds hold");
    // Each pixel's own variance is as true as ever; of what they say together, less is independent.
    let mean = |get: fn(&Row) -> f64| rows.iter().map(|r| get(r) * get(r)).sum::<f64>();
    let ratio = (mean(|r| r.stated.error) / mean(|r| r.error)).sqrt();
    println!("stated over true {ratio:.3}");
    assert!((0.88..1.15).contains(&ratio), "states {ratio} times its error");
}
