//! What every builder owes: the same tree on any number of threads, a bound on duplicates, an end on any input.

use crate::meshes::{self, Soup};
use kiln::Control;
use kiln::prepare::kdtree::{BuildOptions, KdTree, Statistics};
use kiln::settings::KdTreeBuilder;

const BUILDERS: [KdTreeBuilder; 3] = [KdTreeBuilder::Median, KdTreeBuilder::Sampled, KdTreeBuilder::Sah];

fn build(soup: &Soup, builder: KdTreeBuilder, seed: u64) -> KdTree {
    let options = BuildOptions { builder, seed, ..BuildOptions::default() };
    KdTree::build(soup, &options, &Control::default()).unwrap()
}

fn on_threads(soup: &Soup, builder: KdTreeBuilder, threads: usize) -> KdTree {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
    pool.install(|| build(soup, builder, 3))
}

fn without_clock(statistics: Statistics) -> Statistics {
    Statistics { build_seconds: 0.0, build_cpu_seconds: 0.0, ..statistics }
}

#[test]
fn the_tree_is_the_same_on_any_number_of_threads() {
    let soup = meshes::random_soup(60_000, 0.02, 11);
    for builder in BUILDERS {
        let one = on_threads(&soup, builder, 1);
        for threads in [2, 5] {
            let other = on_threads(&soup, builder, threads);
            assert_eq!(without_clock(one.statistics()), without_clock(other.statistics()), "{builder:?}");
            assert!(one.same_as(&other), "{builder:?} on {threads} threads");
        }
    }
    let reseeded = build(&soup, KdTreeBuilder::Sampled, 4);
    assert!(!on_threads(&soup, KdTreeBuilder::Sampled, 1).same_as(&reseeded), "the seed selects the planes");
}

#[test]
fn a_tree_for_few_rays_is_not_made_for_many() {
    let soup = meshes::random_soup(20_000, 0.02, 12);
    let tree = |builder, planned_rays| {
        let options = BuildOptions { builder, planned_rays, ..BuildOptions::default() };
        KdTree::build(&soup, &options, &Control::default()).unwrap()
    };
    let (sah, sampled) = (tree(KdTreeBuilder::Sah, None), tree(KdTreeBuilder::Sampled, None));
    assert!(tree(KdTreeBuilder::Auto, None).same_as(&sah));
    assert!(tree(KdTreeBuilder::Auto, Some(1_000_000)).same_as(&sah));
    assert!(tree(KdTreeBuilder::Auto, Some(4096)).same_as(&sampled));
    assert!(tree(KdTreeBuilder::Sah, Some(4096)).same_as(&sah), "what is chosen is built");
}

#[test]
fn the_heuristic_beats_chance_and_chance_beats_halving() {
    let soup = meshes::torus(400, 100).soup(1.0, glam::Vec3::ZERO);
    let [median, sampled, sah] = BUILDERS.map(|b| build(&soup, b, 1).statistics().sah_cost);
    assert!(sah < sampled && sampled < median, "median {median}, sampled {sampled}, sah {sah}");
}

#[test]
fn hostile_scenes_end_soon_and_stay_small() {
    let scenes = [
        ("identical", meshes::identical(50_000)),
        ("coplanar", meshes::coplanar(150)),
        ("collinear", meshes::collinear(50_000, 1)),
        ("all sizes", meshes::all_sizes(50_000, 2)),
        ("lattice", meshes::lattice_soup(20_000, 3)),
        ("hair", meshes::hair(50_000, 4)),
    ];
    for (name, soup) in &scenes {
        for builder in BUILDERS {
            let tree = build(soup, builder, 1);
            let s = tree.statistics();
            let most = if builder == KdTreeBuilder::Sah { 4 } else { 3 };
            assert!(s.references <= s.triangles * most + 32, "{name}, {builder:?}: {s:?}");
            assert!(s.bytes <= s.triangles * 250, "{name}, {builder:?}: {s:?}");
            assert!(s.build_seconds < 10.0, "{name}, {builder:?}: {s:?}");
        }
    }
}

#[test]
fn a_stop_is_heeded() {
    let control = Control::default();
    control.stop();
    assert!(KdTree::build(&meshes::random_soup(10, 0.1, 1), &BuildOptions::default(), &control).is_err());
}
