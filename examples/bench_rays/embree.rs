//! The other side of the race: a child process that runs Embree on the same rays.

use crate::Pass;
use crate::meshes::Mesh;
use crate::rays::Set;
use glam::DAffine3;
use std::io::{BufRead, BufReader, Write};
use std::process::{Child, ChildStdin, ChildStdout, Command, Stdio};

/// `scripts/bench/embree_rays.cpp` at work on one mesh.
pub struct Rival {
    child: Child,
    to: ChildStdin,
    from: BufReader<ChildStdout>,
    folder: std::path::PathBuf,
    pub build_seconds: f64,
    pub build_cpu: f64,
}

impl Rival {
    /// Over a mesh, or over placements of it.
    pub fn new(program: &str, mesh: &Mesh, maps: &[DAffine3], robust: bool) -> Self {
        let folder = std::env::temp_dir().join(format!("bench_rays_{}", std::process::id()));
        std::fs::create_dir_all(&folder).expect("a temporary folder");
        let mut bytes = Vec::new();
        bytes.extend((mesh.points.len() as u32).to_le_bytes());
        bytes.extend((mesh.faces.len() as u32).to_le_bytes());
        bytes.extend(mesh.points.iter().flat_map(|p| p.to_array()).flat_map(f32::to_le_bytes));
        bytes.extend(mesh.faces.as_flattened().iter().flat_map(|i| i.to_le_bytes()));
        let path = folder.join("mesh.bin");
        std::fs::write(&path, bytes).expect("a writable temporary folder");
        let placements = folder.join("placements.bin");
        let columns = maps.iter().flat_map(|map| map.to_cols_array()).flat_map(|x| (x as f32).to_le_bytes());
        std::fs::write(&placements, columns.collect::<Vec<u8>>()).expect("a writable temporary folder");
        let mut child = Command::new(program)
            .arg(path)
            .args(robust.then_some("robust"))
            .args((!maps.is_empty()).then_some(placements))
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .spawn()
            .expect("the Embree program starts");
        let to = child.stdin.take().expect("piped");
        let from = BufReader::new(child.stdout.take().expect("piped"));
        let mut rival = Self { child, to, from, folder, build_seconds: 0.0, build_cpu: 0.0 };
        let answer = rival.answer();
        (rival.build_seconds, rival.build_cpu) = (answer[0], answer[1]);
        rival
    }

    pub fn load(&mut self, set: &Set) {
        let mut bytes = (set.rays.len() as u32).to_le_bytes().to_vec();
        for ray in &set.rays {
            let [o, d] = [ray.origin.to_array(), ray.dir.to_array()];
            bytes.extend([o[0], o[1], o[2], 0.0, d[0], d[1], d[2], ray.t_max].into_iter().flat_map(f32::to_le_bytes));
        }
        let path = self.folder.join("set.rays");
        std::fs::write(&path, bytes).expect("a writable temporary folder");
        writeln!(self.to, "{} {}", if set.any { "any" } else { "closest" }, path.display()).expect("Embree listens");
        self.answer();
    }

    pub fn pass(&mut self, threads: usize) -> Pass {
        writeln!(self.to, "pass {threads}").expect("Embree listens");
        let answer = self.answer();
        Pass { seconds: answer[0], hits: answer[1] as u64, sum_t: answer[2] }
    }

    fn answer(&mut self) -> Vec<f64> {
        let mut line = String::new();
        self.from.read_line(&mut line).expect("Embree answers");
        line.split_whitespace().map(|word| word.parse().expect("a number")).collect()
    }
}

impl Drop for Rival {
    fn drop(&mut self) {
        let _ = writeln!(self.to, "quit");
        let _ = self.child.wait();
        let _ = std::fs::remove_dir_all(&self.folder);
    }
}
