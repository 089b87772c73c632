//! What a build takes at its peak. A test of its own, because the peak is the process's.

#![allow(clippy::disallowed_methods, reason = "expected values may come from std's functions")]

use glam::Vec3;
use kiln::Control;
use kiln::prepare::kdtree::{BuildOptions, KdTree, Triangles};

/// A wavy grid of two million triangles, made on the fly.
struct Waves;

const SIDE: u32 = 1000;

impl Triangles for Waves {
    fn len(&self) -> usize {
        (2 * SIDE * SIDE) as usize
    }

    fn vertices(&self, triangle: u32) -> [Vec3; 3] {
        let (cell, upper) = (triangle / 2, triangle % 2);
        let (i, k) = (cell / SIDE, cell % SIDE);
        let at = |i: u32, k: u32| {
            let (x, z) = (i as f32 * 0.013, k as f32 * 0.017);
            Vec3::new(
                x + 0.3 * z,
                libm::sinf(7.0 * x) * libm::cosf(5.0 * z) + 0.2 * libm::sinf(9.0 * x + 23.0 * z),
                z - 0.2 * x,
            )
        };
        if upper == 1 { [at(i, k), at(i + 1, k + 1), at(i, k + 1)] } else { [at(i, k), at(i + 1, k), at(i + 1, k + 1)] }
    }
}

/// The largest resident size of this process so far, in bytes.
#[cfg(target_os = "linux")]
fn peak() -> u64 {
    let status = std::fs::read_to_string("/proc/self/status").unwrap();
    let line = status.lines().find(|line| line.starts_with("VmHWM:")).unwrap();
    line.split_whitespace().nth(1).unwrap().parse::<u64>().unwrap() * 1024
}

#[cfg(target_os = "linux")]
#[test]
fn a_build_takes_less_than_250_bytes_a_triangle_and_the_tree_less_than_100() {
    let before = peak();
    let tree = KdTree::build(&Waves, &BuildOptions::default(), &Control::default()).unwrap();
    let n = Waves.len() as u64;
    let at_peak = (peak() - before) / n;
    let kept = tree.statistics().bytes / n;
    println!("{at_peak} bytes a triangle at the peak, {kept} kept: {:?}", tree.statistics());
    assert!(at_peak < 250, "{at_peak} bytes a triangle at the peak");
    assert!(kept < 100, "{kept} bytes a triangle");
}
