//! Rays a second: the kd-tree's forms against each other, and against Embree.
//!
//!     cargo run --release --example bench_rays -- [MESH...] [--passes N] [--embree PROGRAM] [--robust] [--forms planes,scalar,avx2,avx512] [--sets camera,bounce] [--threads 1,2] [--builds N] [--copies] [--table]
//!
//! A form may end in -stream or -packet: rays go to the tree in batches, as scattered or as coherent ones. Meshes are made here: scan, terrain, knot, stadium, hair, foliage,
//! straw, box, fur, clutter; scan, terrain, knot, hair and straw in any size, as scan:10000. A hundred placements of a mesh are many-MESH: shared on
//! both sides, or with --copies copied on ours. Rays come from the tree itself: a camera, one bounce
//! (diffuse) from each hit, the same shuffled, a second bounce, and a shadow ray to a point of a light above. All contenders take turns, pass
//! by pass, on one thread or on each of several numbers of threads (CPU seconds of all); the best CPU time of each counts. --table prints a
//! row for each mesh, for a record of how rays fare as meshes grow. PROGRAM is scripts/bench/embree_rays.cpp, compiled; it gets the
//! mesh and the rays as files and is asked for passes over its standard input.

#![allow(clippy::disallowed_methods)]

#[path = "bench_rays/embree.rs"]
mod embree;
#[path = "bench_rays/many.rs"]
mod many;
#[path = "bench_rays/meshes.rs"]
mod meshes;
#[path = "bench_rays/rays.rs"]
mod rays;
#[path = "bench_rays/table.rs"]
mod table;

use cpu_time::{ProcessTime, ThreadTime};
use kiln::Control;
use kiln::math::Ray;
use kiln::math::simd::SimdTier;
use kiln::prepare::kdtree::{BuildOptions, Coherence, HitBatch, KdTree, NO_TRIANGLE, RayBatch};
use kiln::settings::KdTreeBuilder;

/// What the command line asks for.
struct Arguments {
    meshes: Vec<String>,
    passes: usize,
    embree: Option<String>,
    robust: bool,
    copies: bool,
    forms: Vec<String>,
    sets: Vec<String>,
    builder: KdTreeBuilder,
    threads: Vec<usize>,
    table: bool,
    builds: u32,
}

fn arguments() -> Arguments {
    let mut asked = Arguments {
        meshes: Vec::new(),
        passes: 5,
        embree: None,
        robust: false,
        copies: false,
        forms: vec!["avx512".into()],
        sets: Vec::new(),
        builder: KdTreeBuilder::Sah,
        threads: vec![1],
        table: false,
        builds: 3,
    };
    let mut words = std::env::args().skip(1);
    while let Some(word) = words.next() {
        let mut value = || words.next().expect("a value after the option");
        match word.as_str() {
            "--passes" => asked.passes = value().parse().expect("a number of passes"),
            "--embree" => asked.embree = Some(value()),
            "--robust" => asked.robust = true,
            "--copies" => asked.copies = true,
            "--threads" => {
                asked.threads = value().split(',').map(|n| n.parse().expect("numbers of threads")).collect();
            }
            "--table" => asked.table = true,
            "--builds" => asked.builds = value().parse().expect("a number of builds"),
            "--forms" => asked.forms = value().split(',').map(String::from).collect(),
            "--sets" => asked.sets = value().split(',').map(String::from).collect(),
            "--builder" => asked.builder = serde_json::from_value(value().into()).expect("median, sampled or sah"),
            mesh => asked.meshes.push(mesh.into()),
        }
    }
    if asked.meshes.is_empty() {
        asked.meshes = meshes::NAMES.map(String::from).to_vec();
    }
    asked
}

/// One pass over rays: seconds, hits, and the sum of distances.
struct Pass {
    seconds: f64,
    hits: u64,
    sum_t: f64,
}

/// Rays of a batch.
const BATCH: usize = 1024;

/// A pass in batches. Turning rays into columns is not part of the work: a wavefront has columns.
fn stream(tree: &KdTree, rays: &[Ray], any: bool, coherence: Coherence) -> Pass {
    let mut pass = Pass { seconds: 0.0, hits: 0, sum_t: 0.0 };
    let (mut t, mut b1, mut b2, mut triangle) = ([0.0; BATCH], [0.0; BATCH], [0.0; BATCH], [0; BATCH]);
    let mut blocked = [false; BATCH];
    let column = |number: fn(&Ray) -> f32| rays.iter().map(number).collect::<Vec<f32>>();
    let origin = [column(|r| r.origin.x), column(|r| r.origin.y), column(|r| r.origin.z)];
    let dir = [column(|r| r.dir.x), column(|r| r.dir.y), column(|r| r.dir.z)];
    let t_max = column(|r| r.t_max);
    let begin = ThreadTime::now();
    for first in (0..rays.len()).step_by(BATCH) {
        let range = first..(first + BATCH).min(rays.len());
        let n = range.len();
        let batch = RayBatch {
            origin: [0, 1, 2].map(|axis| &origin[axis][range.clone()]),
            dir: [0, 1, 2].map(|axis| &dir[axis][range.clone()]),
            t_max: &t_max[range],
            reaches: &[],
            leaves: &[],
        };
        if any {
            tree.occluded_batch(&batch, coherence, &mut blocked[..n]);
            pass.hits += blocked[..n].iter().filter(|&&b| b).count() as u64;
        } else {
            let mut hits =
                HitBatch { t: &mut t[..n], b1: &mut b1[..n], b2: &mut b2[..n], triangle: &mut triangle[..n] };
            tree.closest_batch(&batch, coherence, &mut hits);
            for (t, _) in t[..n].iter().zip(&triangle[..n]).filter(|(_, id)| **id != NO_TRIANGLE) {
                pass.hits += 1;
                pass.sum_t += f64::from(*t);
            }
        }
    }
    pass.seconds = begin.elapsed().as_secs_f64();
    pass
}

/// A pass on several threads, each with its share of the rays; CPU seconds of all.
fn pass(tree: &KdTree, form: &str, rays: &[Ray], any: bool, threads: usize) -> Pass {
    if threads <= 1 {
        return share(tree, form, rays, any);
    }
    let passes: Vec<Pass> = std::thread::scope(|scope| {
        let start = |rays| scope.spawn(move || share(tree, form, rays, any));
        let started: Vec<_> = rays.chunks(rays.len().div_ceil(threads)).map(start).collect();
        started.into_iter().map(|thread| thread.join().expect("a pass")).collect()
    });
    passes.into_iter().fold(Pass { seconds: 0.0, hits: 0, sum_t: 0.0 }, |a, b| Pass {
        seconds: a.seconds + b.seconds,
        hits: a.hits + b.hits,
        sum_t: a.sum_t + b.sum_t,
    })
}

fn share(tree: &KdTree, form: &str, rays: &[Ray], any: bool) -> Pass {
    if form.ends_with("-stream") {
        return stream(tree, rays, any, Coherence::Scattered);
    }
    if form.ends_with("-packet") {
        return stream(tree, rays, any, Coherence::Camera { pixels: u64::MAX });
    }
    let (mut hits, mut sum_t) = (0, 0.0);
    let begin = ThreadTime::now();
    for ray in rays {
        if any {
            hits += u64::from(if form == "planes" {
                tree.occluded_by_planes(ray, |_| true)
            } else {
                tree.occluded(ray, |_| true)
            });
        } else if let Some(hit) =
            if form == "planes" { tree.closest_by_planes(ray, |_| true) } else { tree.closest(ray, |_| true) }
        {
            hits += 1;
            sum_t += f64::from(hit.t);
        }
    }
    Pass { seconds: begin.elapsed().as_secs_f64(), hits, sum_t }
}

fn main() {
    let asked = arguments();
    if asked.table {
        table::head(&asked.forms, &asked.sets);
    } else {
        println!("mesh\trays\tcontender\tthreads\tMrays/s\tratio\thits\tmean_t");
    }
    let mut logs: Vec<f64> = Vec::new();
    for name in &asked.meshes {
        // As many-scan:10000: a hundred placements.
        let shared = name.strip_prefix("many-").map(meshes::make);
        let many = shared.as_ref().map(many::Many::new);
        let whole = if many.is_none() { Some(meshes::make(name)) } else { None };
        let mesh = whole.as_ref().or(many.as_ref().map(|many| &many.all)).expect("one of them");
        let build = |simd| {
            let options = BuildOptions { builder: asked.builder, seed: 1, simd, ..BuildOptions::default() };
            if let (Some(many), Some(shared), false) = (&many, &shared, asked.copies) {
                return many.tree(shared, &options);
            }
            KdTree::build(mesh, &options, &Control::default()).expect("not stopped")
        };
        let tier = |form: &str| -> SimdTier {
            form.trim_end_matches("-stream").trim_end_matches("-packet").parse().unwrap_or(SimdTier::Scalar)
        };
        let mut built: Vec<(SimdTier, KdTree)> = Vec::new();
        for form in &asked.forms {
            if built.iter().all(|(have, _)| *have != tier(form)) {
                built.push((tier(form), build(tier(form))));
            }
        }
        let tree_of = |form: &String| built.iter().find(|(have, _)| *have == tier(form)).map(|(_, tree)| tree);
        let trees: Vec<(String, &KdTree)> =
            asked.forms.iter().map(|form| (form.clone(), tree_of(form).expect("built above"))).collect();
        let statistics = trees[0].1.statistics();
        let begin = ProcessTime::now();
        let best_build =
            (0..asked.builds).map(|_| build(SimdTier::detect()).statistics().build_seconds).fold(f64::MAX, f64::min);
        let build_cpu = begin.elapsed().as_secs_f64() / f64::from(asked.builds);
        let mut row = table::Row::new(name, &statistics, build_cpu);
        let tell = |line: String| {
            if !asked.table {
                println!("{line}")
            }
        };
        tell(format!(
            "# {name}: {} triangles, {:.2} references, {:.1} a leaf, depth {}, cost {:.2}, {:.1} bytes each, built in {best_build:.3} s ({build_cpu:.3} CPU)",
            statistics.triangles,
            statistics.references as f64 / statistics.triangles as f64,
            statistics.references as f64 / statistics.leaves as f64,
            statistics.depth,
            statistics.sah_cost,
            statistics.bytes as f64 / statistics.triangles as f64,
        ));
        let sets = rays::sets(mesh, trees[0].1);
        let mut rival = asked.embree.as_ref().map(|program| {
            let maps = many.as_ref().map_or(&[][..], |many| &many.maps);
            embree::Rival::new(program, shared.as_ref().unwrap_or(mesh), maps, asked.robust)
        });
        if let Some(rival) = &rival {
            tell(format!("# {name}: embree built in {:.3} s ({:.3} CPU)", rival.build_seconds, rival.build_cpu));
        }
        for set in sets.iter().filter(|set| asked.sets.is_empty() || asked.sets.iter().any(|s| s == set.name)) {
            if let Some(rival) = &mut rival {
                rival.load(set);
            }
            for &threads in &asked.threads {
                let none = || Pass { seconds: f64::MAX, hits: 0, sum_t: 0.0 };
                let mut best: Vec<Pass> = trees.iter().map(|_| none()).collect();
                let mut theirs = none();
                for _ in 0..asked.passes {
                    for ((form, tree), best) in trees.iter().zip(&mut best) {
                        let now = pass(tree, form, &set.rays, set.any, threads);
                        *best = if now.seconds < best.seconds { now } else { Pass { seconds: best.seconds, ..now } };
                    }
                    if let Some(rival) = &mut rival {
                        let now = rival.pass(threads);
                        theirs = if now.seconds < theirs.seconds { now } else { theirs };
                    }
                }
                let n = set.rays.len() as f64;
                let mut print = |who: &str, p: &Pass, ratio: f64| {
                    let mean_t = p.sum_t / p.hits.max(1) as f64;
                    let speed = n / p.seconds * 1e-6;
                    row.add(speed);
                    tell(format!(
                        "{name}\t{}\t{who}\t{threads}\t{speed:.2}\t{ratio:.2}\t{}\t{mean_t:.6}",
                        set.name, p.hits
                    ));
                };
                let base = if rival.is_some() { theirs.seconds } else { best[0].seconds };
                for ((form, _), p) in trees.iter().zip(&best) {
                    print(form, p, base / p.seconds);
                }
                if rival.is_some() {
                    print("embree", &theirs, 1.0);
                    if let Some(last) = best.last() {
                        logs.push((theirs.seconds / last.seconds).ln());
                    }
                }
            }
        }
        if asked.table {
            println!("{row}");
        }
    }
    if !logs.is_empty() {
        println!("# geometric mean of the last form: {:.3}", (logs.iter().sum::<f64>() / logs.len() as f64).exp());
    }
}
