//! How fast rays are found: sets of rays through a prepared scene, or out of a file, traced pass by pass.
//!
//! What is measured is geometry alone: nothing is culled or cut out by alpha.

mod columns;
mod file;
mod sets;

use crate::math::Ray;
use crate::prepare::PreparedScene;
use crate::prepare::kdtree::KdTree;
use columns::Columns;
use cpu_time::ThreadTime;
pub use file::{FileRay, RayFileError, parse};
use serde::Serialize;
pub use sets::{RaySet, sets};
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};

/// Rays that a thread takes on at once.
const SHARE: usize = 4096;
/// Passes; the best counts.
const PASSES: usize = 5;
/// CPU seconds after which there are no more passes.
const ENOUGH_SECONDS: f64 = 5.0;

/// How rays are traced.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Tracing {
    /// Whether something is met, not what is nearest.
    pub any_hit: bool,
    /// In batches, not one by one.
    pub stream: bool,
    /// Threads, at least one.
    pub threads: usize,
}

/// What a measurement gave.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Measured {
    /// Rays traced in a pass.
    pub rays: u64,
    /// Rays that met something.
    pub hits: u64,
    /// The mean distance of nearest hits, in units of their rays' directions; 0 when there is none or any hit was asked for.
    pub mean_t: f64,
    /// CPU seconds of the best pass, over all threads.
    pub cpu_seconds: f64,
    /// Millions of rays per CPU second in the best pass.
    pub mrays_per_cpu_second: f64,
}

/// What some rays gave, and the CPU seconds that they took.
#[derive(Clone, Copy, Debug, Default)]
struct Tally {
    seconds: f64,
    hits: u64,
    sum_t: f64,
}

/// Traces the rays of a file in the asset's own coordinates.
pub fn measure_file(prepared: &PreparedScene, rays: &[FileRay], how: Tracing) -> Measured {
    let placed: Vec<Ray> = rays.iter().map(|ray| ray.placed(&prepared.frame)).collect();
    // A ray's way begins at its near end, its distance at its origin.
    let before: Vec<f32> = rays.iter().map(|ray| ray.near).collect();
    measure(&prepared.tree, &placed, &before, how)
}

/// Traces a set of rays through the scene.
pub fn measure_set(prepared: &PreparedScene, set: &RaySet, how: Tracing) -> Measured {
    measure(&prepared.tree, &set.rays, &[], Tracing { any_hit: set.any_hit, ..how })
}

/// `before` is what is added to each ray's distance, or nothing at all.
fn measure(tree: &KdTree, rays: &[Ray], before: &[f32], how: Tracing) -> Measured {
    let columns = Columns::new(rays);
    let mut best = Tally { seconds: f64::INFINITY, ..Tally::default() };
    let mut spent = 0.0;
    for _ in 0..PASSES {
        let tally = pass(tree, rays, &columns, before, how);
        spent += tally.seconds;
        if tally.seconds < best.seconds {
            best = tally;
        }
        if spent > ENOUGH_SECONDS {
            break;
        }
    }
    Measured {
        rays: rays.len() as u64,
        hits: best.hits,
        mean_t: if best.hits > 0 { best.sum_t / best.hits as f64 } else { 0.0 },
        cpu_seconds: best.seconds,
        mrays_per_cpu_second: rays.len() as f64 / best.seconds * 1e-6,
    }
}

/// One pass: threads take shares of the rays in turn.
fn pass(tree: &KdTree, rays: &[Ray], columns: &Columns, before: &[f32], how: Tracing) -> Tally {
    let next = AtomicUsize::new(0);
    let tallies = Mutex::new(Vec::new());
    let work = || {
        let begin = ThreadTime::now();
        let mut shares = Vec::new();
        loop {
            let first = next.fetch_add(SHARE, Ordering::Relaxed);
            if first >= rays.len() {
                break;
            }
            let range = first..(first + SHARE).min(rays.len());
            let before = before.get(range.clone()).unwrap_or(&[]);
            shares.push((first, share(tree, &rays[range.clone()], columns, range, before, how)));
        }
        let seconds = begin.elapsed().as_secs_f64();
        let mut tallies = tallies.lock().unwrap_or_else(std::sync::PoisonError::into_inner);
        tallies.push((seconds, shares));
    };
    if how.threads <= 1 {
        work();
    } else {
        std::thread::scope(|scope| (0..how.threads).for_each(|_| drop(scope.spawn(work))));
    }
    let tallies = tallies.into_inner().unwrap_or_else(std::sync::PoisonError::into_inner);
    let seconds = tallies.iter().map(|(seconds, _)| seconds).sum();
    // Sums in the order of the rays, whoever traced them.
    let mut shares: Vec<(usize, (u64, f64))> = tallies.into_iter().flat_map(|(_, shares)| shares).collect();
    shares.sort_unstable_by_key(|(first, _)| *first);
    let add = |(hits, sum), (_, (h, s)): (usize, (u64, f64))| (hits + h, sum + s);
    let (hits, sum_t) = shares.into_iter().fold((0, 0.0), add);
    Tally { seconds, hits, sum_t }
}

/// Traces a share of the rays: hits, and the sum of their distances.
fn share(
    tree: &KdTree,
    rays: &[Ray],
    columns: &Columns,
    range: std::ops::Range<usize>,
    before: &[f32],
    how: Tracing,
) -> (u64, f64) {
    let before = |i: usize| before.get(i).copied().unwrap_or(0.0);
    if how.stream {
        return columns.trace(tree, range, before, how.any_hit);
    }
    let (mut hits, mut sum) = (0, 0.0);
    for (i, ray) in rays.iter().enumerate() {
        if how.any_hit {
            hits += u64::from(tree.occluded(ray, |_| true));
        } else if let Some(hit) = tree.closest(ray, |_| true) {
            hits += 1;
            sum += f64::from(hit.t + before(i));
        }
    }
    (hits, sum)
}
