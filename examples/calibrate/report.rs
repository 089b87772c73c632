use crate::trial::{FIXED, Row, TARGETS};

fn ways() -> Vec<String> {
    let targets = TARGETS.iter().map(|t| format!("error {t}"));
    targets.chain(FIXED.iter().map(|n| format!("spp {n}"))).collect()
}

fn median(values: impl Iterator<Item = f64>) -> f64 {
    let mut values: Vec<f64> = values.collect();
    values.sort_by(f64::total_cmp);
    values.get(values.len() / 2).copied().unwrap_or(f64::NAN)
}

/// Share of the renders whose error lies at or under the bound, in percent. An error below a thousandth of a level is none.
fn covered(rows: &[&Row]) -> f64 {
    let held = rows.iter().filter(|r| r.error <= r.stated.error_bound.max(1e-3)).count();
    100.0 * held as f64 / rows.len() as f64
}

fn relmse_covered(rows: &[&Row]) -> f64 {
    let held = rows.iter().filter(|r| r.relmse <= r.stated.relmse_bound.max(1e-9)).count();
    100.0 * held as f64 / rows.len() as f64
}

fn line(rows: &[&Row]) -> String {
    let ratio = |get: fn(&Row) -> f64| median(rows.iter().filter(|r| r.error > 1e-3).map(|r| get(r)));
    format!(
        "{:4} renders, spp {:5}, error {:6.3}, stated/true {:5.3}, bound/true {:5.3}, holds {:5.1} %; relMSE {:9.2e}, \
         stated/true {:5.3}, holds {:5.1} %",
        rows.len(),
        median(rows.iter().map(|r| f64::from(r.spp))),
        median(rows.iter().map(|r| r.error)),
        ratio(|r| r.stated.error / r.error),
        ratio(|r| r.stated.error_bound / r.error),
        covered(rows),
        median(rows.iter().map(|r| r.relmse)),
        ratio(|r| r.stated.relmse / r.relmse),
        relmse_covered(rows),
    )
}

/// The lines about one asset.
pub fn asset(name: &str, rows: &[Row], cpu_seconds: f64) {
    println!("{name}: {cpu_seconds:.1} CPU s");
    for way in ways() {
        let rows: Vec<&Row> = rows.iter().filter(|r| r.way == way).collect();
        if !rows.is_empty() {
            println!("  {way:8} {}", line(&rows));
        }
    }
}

/// All assets together, and the assets on which bounds hold least.
pub fn total(rows: &[Row]) {
    println!("all assets");
    for way in ways() {
        let rows: Vec<&Row> = rows.iter().filter(|r| r.way == way).collect();
        if !rows.is_empty() {
            println!("  {way:8} {}", line(&rows));
        }
    }
    println!("  pooled   {}", line(&rows.iter().collect::<Vec<_>>()));
    let mut names: Vec<&str> = rows.iter().map(|r| r.asset.as_str()).collect();
    names.dedup();
    let of = |name: &str| covered(&rows.iter().filter(|r| r.asset == name).collect::<Vec<_>>());
    let mut least: Vec<(f64, &str)> = names.iter().map(|name| (of(name), *name)).collect();
    least.sort_by(|a, b| a.0.total_cmp(&b.0));
    println!("{} assets; bounds hold least on:", names.len());
    least.iter().take(8).for_each(|(share, name)| println!("  {share:5.1} %  {name}"));
}

/// One line a look.
pub fn csv(rows: &[Row]) -> String {
    let head = "asset,way,seed,spp,error,stated,bound,relmse,stated_relmse,relmse_bound\n".to_string();
    rows.iter().fold(head, |text, r| {
        let s = &r.stated;
        text + &format!(
            "{},{},{},{},{},{},{},{},{},{}\n",
            r.asset, r.way, r.seed, r.spp, r.error, s.error, s.error_bound, r.relmse, s.relmse, s.relmse_bound
        )
    })
}
