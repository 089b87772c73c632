//! A batch finds what its rays find one by one.

use kiln::math::{Hit, Ray};
use kiln::prepare::kdtree::{Coherence, HitBatch, KdTree, NO_TRIANGLE, RayBatch};

/// Rays side by side, with the triangles that they may not meet.
struct Columns {
    origin: [Vec<f32>; 3],
    dir: [Vec<f32>; 3],
    t_max: Vec<f32>,
    reaches: Vec<u32>,
    leaves: Vec<u32>,
}

impl Columns {
    fn new(rays: &[Ray], reaches: Vec<u32>) -> Self {
        let origin = [0, 1, 2].map(|axis| rays.iter().map(|r| r.origin[axis]).collect());
        let dir = [0, 1, 2].map(|axis| rays.iter().map(|r| r.dir[axis]).collect());
        Self { origin, dir, t_max: rays.iter().map(|r| r.t_max).collect(), reaches, leaves: vec![] }
    }

    fn batch(&self) -> RayBatch<'_> {
        let [origin, dir] = [&self.origin, &self.dir].map(|rows| [&rows[0][..], &rows[1][..], &rows[2][..]]);
        RayBatch { origin, dir, t_max: &self.t_max, reaches: &self.reaches, leaves: &self.leaves }
    }
}

fn closest(
    tree: &KdTree,
    rays: &RayBatch,
    coherence: Coherence,
    stops: Option<&dyn Fn(&Hit) -> bool>,
) -> Vec<[u32; 4]> {
    let n = rays.len();
    let (mut t, mut b1, mut b2, mut triangle) = (vec![-1.0; n], vec![-1.0; n], vec![-1.0; n], vec![7; n]);
    let mut hits = HitBatch { t: &mut t, b1: &mut b1, b2: &mut b2, triangle: &mut triangle };
    match stops {
        Some(stops) => tree.closest_batch_where(rays, coherence, &mut hits, |_, hit| stops(hit)),
        None => tree.closest_batch(rays, coherence, &mut hits),
    }
    (0..n).map(|i| [t[i].to_bits(), triangle[i], b1[i].to_bits(), b2[i].to_bits()]).collect()
}

fn word(ray: &Ray, hit: Option<Hit>) -> [u32; 4] {
    let hit = hit.unwrap_or(Hit { t: ray.t_max, triangle: NO_TRIANGLE, b1: 0.0, b2: 0.0 });
    [hit.t.to_bits(), hit.triangle, hit.b1.to_bits(), hit.b2.to_bits()]
}

/// Compares batches of several lengths with single rays: all hits, those of a cut-out, and those on other triangles than the one
/// that each ray may not meet, its nearest.
pub fn check(name: &str, tree: &KdTree, rays: &[Ray], cut_out: fn(&Hit) -> bool) {
    let lengths = [rays.len(), 1, 17];
    for length in lengths.into_iter().filter(|&n| n <= rays.len()) {
        let rays = &rays[..length];
        let first: Vec<Option<Hit>> = rays.iter().map(|r| tree.closest(r, |_| true)).collect();
        let reaches: Vec<u32> = first.iter().map(|h| h.map_or(NO_TRIANGLE, |h| h.triangle)).collect();
        let back = |r: &Ray| Ray { dir: -r.dir, t_max: f32::INFINITY, ..*r };
        let behind: Vec<u32> =
            rays.iter().map(|r| tree.closest(&back(r), |_| true).map_or(NO_TRIANGLE, |h| h.triangle)).collect();
        let barred = |i: usize, h: &Hit| h.triangle == reaches[i];
        let (free, bound) = (Columns::new(rays, vec![]), Columns::new(rays, reaches.clone()));
        for coherence in [Coherence::Camera { pixels: u64::MAX }, Coherence::Lamps, Coherence::Scattered] {
            let name = format!("{name}, {length} rays, {coherence:?}");
            let expect = |accept: &dyn Fn(usize, &Hit) -> bool| -> Vec<[u32; 4]> {
                rays.iter().enumerate().map(|(i, r)| word(r, tree.closest(r, |h| accept(i, h)))).collect()
            };
            let any_cut: &dyn Fn(&Hit) -> bool = &cut_out;
            assert_eq!(closest(tree, &free.batch(), coherence, None), expect(&|_, _| true), "{name}");
            assert_eq!(closest(tree, &free.batch(), coherence, Some(any_cut)), expect(&|_, h| cut_out(h)), "{name}");
            assert_eq!(closest(tree, &bound.batch(), coherence, None), expect(&|i, h| !barred(i, h)), "{name}");
            // A plane that is met behind a ray's origin is not met before it: to be told so changes nothing.
            let told = Columns { leaves: behind.clone(), ..Columns::new(rays, vec![]) };
            assert_eq!(closest(tree, &told.batch(), coherence, None), expect(&|_, _| true), "{name}, behind");
            let both = expect(&|i, h| !barred(i, h) && cut_out(h));
            assert_eq!(closest(tree, &bound.batch(), coherence, Some(any_cut)), both, "{name}, both");

            let mut blocked = vec![false; length];
            tree.occluded_batch(&free.batch(), coherence, &mut blocked);
            let expected: Vec<bool> = first.iter().map(Option::is_some).collect();
            assert_eq!(blocked, expected, "{name}, occluded");
            tree.occluded_batch(&bound.batch(), coherence, &mut blocked);
            let open = |i: usize| tree.occluded(&rays[i], |h| !barred(i, h));
            assert_eq!(blocked, (0..length).map(open).collect::<Vec<_>>(), "{name}, occluded, barred");
            tree.occluded_batch_where(&bound.batch(), coherence, &mut blocked, |_, h| cut_out(h));
            let open = |i: usize| tree.occluded(&rays[i], |h| !barred(i, h) && cut_out(h));
            assert_eq!(blocked, (0..length).map(open).collect::<Vec<_>>(), "{name}, occluded, both");
        }
    }
}
