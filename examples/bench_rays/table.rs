//! A row for each mesh: how building and tracing fare as meshes grow.

use kiln::prepare::kdtree::Statistics;
use std::fmt::{Display, Formatter, Result};

/// What was measured on one mesh.
pub struct Row {
    name: String,
    triangles: u64,
    bytes: f64,
    build_cpu: f64,
    speeds: Vec<f64>,
}

/// Prints the head of the table.
pub fn head(forms: &[String], sets: &[String]) {
    println!("Millions of rays a CPU second: of {}, each as {}.", sets.join(", "), forms.join(" and "));
    println!("| mesh | triangles | build, CPU s | bytes a triangle | Mrays/s |\n|---|---|---|---|---|");
}

impl Row {
    /// Of a mesh whose tree is like this and was built in so many CPU seconds.
    pub fn new(name: &str, statistics: &Statistics, build_cpu: f64) -> Self {
        Self {
            name: name.into(),
            triangles: statistics.triangles,
            bytes: statistics.bytes as f64 / statistics.triangles as f64,
            build_cpu,
            speeds: Vec::new(),
        }
    }

    /// Adds how fast rays of the next kind were.
    pub fn add(&mut self, speed: f64) {
        self.speeds.push(speed);
    }
}

impl Display for Row {
    fn fmt(&self, f: &mut Formatter) -> Result {
        let speeds: Vec<String> = self.speeds.iter().map(|speed| format!("{speed:.2}")).collect();
        let speeds = speeds.join(" · ");
        let Self { name, triangles, bytes, build_cpu, .. } = self;
        write!(f, "| {name} | {triangles} | {build_cpu:.3} | {bytes:.0} | {speeds} |")
    }
}
