//! Closed meshes among the shared assets: no ray from inside gets out, in any tier.

use crate::common::shared;
use crate::furnaces::Numbers;
use glam::{DVec3, Vec3};
use kiln::Control;
use kiln::formats::scene::Mesh;
use kiln::formats::{ImportOptions, import};
use kiln::math::Ray;
use kiln::math::simd::SimdTier;
use kiln::prepare::kdtree::{BuildOptions, KdTree, Triangles};
use std::collections::HashMap;
use std::path::{Path, PathBuf};

struct Soup(Vec<[Vec3; 3]>);

impl Triangles for Soup {
    fn len(&self) -> usize {
        self.0.len()
    }

    fn vertices(&self, triangle: u32) -> [Vec3; 3] {
        self.0[triangle as usize]
    }
}

/// Triangles of a piece, how they run along each edge, and whether none has two equal corners.
type Piece = (Vec<usize>, HashMap<(u32, u32), i32>, bool);

/// The pieces of a mesh, corners welded by their bits, in which every edge has one triangle on either side, as oriented.
fn closed_pieces(mesh: &Mesh) -> Vec<Soup> {
    let mut numbers: HashMap<[u32; 3], u32> = HashMap::new();
    let welded: Vec<u32> = mesh
        .positions
        .iter()
        .map(|p| {
            let next = numbers.len() as u32;
            *numbers.entry(p.map(|x| (x + 0.0).to_bits())).or_insert(next)
        })
        .collect();
    let corners: Vec<[u32; 3]> = mesh.triangles.iter().map(|t| t.map(|i| welded[i as usize])).collect();
    let mut root: Vec<u32> = (0..numbers.len() as u32).collect();
    fn find(root: &mut [u32], mut i: u32) -> u32 {
        while root[i as usize] != i {
            root[i as usize] = root[root[i as usize] as usize];
            i = root[i as usize];
        }
        i
    }
    for [a, b, c] in &corners {
        for other in [b, c] {
            let (x, y) = (find(&mut root, *a), find(&mut root, *other));
            root[x as usize] = y;
        }
    }
    let mut pieces: HashMap<u32, Piece> = HashMap::new();
    for (k, t) in corners.iter().enumerate() {
        let (triangles, edges, sound) = pieces.entry(find(&mut root, t[0])).or_insert((vec![], HashMap::new(), true));
        triangles.push(k);
        for (p, q) in [(t[0], t[1]), (t[1], t[2]), (t[2], t[0])] {
            *sound &= p != q;
            // One triangle runs along the edge, the other against it.
            *edges.entry((p.min(q), p.max(q))).or_default() += if p < q { 1 } else { 1 << 16 };
        }
    }
    let mut found: Vec<_> =
        pieces.into_values().filter(|(_, edges, sound)| *sound && edges.values().all(|n| *n == 0x1_0001)).collect();
    found.sort_by_key(|(triangles, ..)| triangles[0]);
    let corner = |i: u32| Vec3::from(mesh.positions[i as usize]);
    found
        .into_iter()
        .map(|(triangles, ..)| Soup(triangles.into_iter().map(|k| mesh.triangles[k].map(corner)).collect()))
        .collect()
}

/// How often the mesh winds around a point: the sum of the solid angles of its triangles over 4π (Van Oosterom & Strackee
/// 1983), in f64.
fn winding(soup: &Soup, point: DVec3) -> f64 {
    let angle = |t: &[Vec3; 3]| {
        let [a, b, c] = t.map(|p| p.as_dvec3() - point);
        let (la, lb, lc) = (a.length(), b.length(), c.length());
        let below = la * lb * lc + a.dot(b) * lc + b.dot(c) * la + c.dot(a) * lb;
        2.0 * a.dot(b.cross(c)).atan2(below)
    };
    soup.0.iter().map(angle).sum::<f64>() / (4.0 * std::f64::consts::PI)
}

/// Rays that get out of a closed mesh, of how many, and whether a place inside was found.
fn leaks(soup: &Soup, tier: SimdTier, rays: usize, numbers: &mut Numbers) -> (usize, usize) {
    let options = BuildOptions { simd: tier, ..BuildOptions::default() };
    let tree = KdTree::build(soup, &options, &Control::default()).expect("not stopped");
    let some = |numbers: &mut Numbers| soup.0[(numbers.next() * soup.0.len() as f64) as usize];
    let corners = || soup.0.as_flattened().iter().copied();
    let size = corners().fold(Vec3::MIN, Vec3::max) - corners().fold(Vec3::MAX, Vec3::min);
    let extent = f64::from(size.max_element());
    let (mut out, mut shot) = (0, 0);
    for _ in 0..6 {
        // Some way from the middle of a triangle to that of another.
        let middle = |t: [Vec3; 3]| (t[0] + t[1] + t[2]) / 3.0;
        let origin = middle(some(numbers)).lerp(middle(some(numbers)), numbers.within(0.2, 0.8) as f32);
        // Well inside: on a face the number hangs on rounding.
        let inside = |by: DVec3| winding(soup, origin.as_dvec3() + by).abs() > 0.9;
        let around = [numbers.vector(), numbers.vector(), numbers.vector()].map(|v| v * extent * 1e-3);
        if !around.into_iter().all(|v| inside(v) && inside(-v)) {
            continue;
        }
        for k in 0..rays {
            let t = some(numbers);
            let target = match k % 3 {
                0 => t[0],
                1 => t[1].lerp(t[2], numbers.next() as f32),
                _ => origin + numbers.vector().as_vec3(),
            };
            let ray = Ray { origin, dir: target - origin, t_max: f32::INFINITY };
            if ray.dir == Vec3::ZERO {
                continue;
            }
            shot += 1;
            out += usize::from(tree.closest(&ray, |_| true).is_none() || !tree.occluded(&ray, |_| true));
        }
    }
    (out, shot)
}

fn assets(folder: &Path, found: &mut Vec<PathBuf>) {
    let Ok(entries) = std::fs::read_dir(folder) else { return };
    let mut paths: Vec<_> = entries.filter_map(|e| e.ok().map(|e| e.path())).collect();
    paths.sort();
    for path in paths {
        let ending = path.extension().and_then(|e| e.to_str()).unwrap_or("").to_ascii_lowercase();
        if path.is_dir() {
            assets(&path, found);
        } else if matches!(ending.as_str(), "gltf" | "glb" | "obj" | "ray") {
            found.push(path);
        }
    }
}

/// Every piece that is a closed oriented 2-manifold and not huge, in every tier. KILN_LEAK_RAYS: rays from each place
/// (60 unless set); KILN_LEAK_TRIANGLES: the largest piece that is tried (4 000 unless set).
#[test]
fn closed_meshes_of_the_wild_are_tight() {
    let Some(shared) = shared("closed meshes of the wild") else { return };
    let number =
        |name: &str, otherwise: usize| std::env::var(name).ok().and_then(|v| v.parse().ok()).unwrap_or(otherwise);
    let (rays, largest) = (number("KILN_LEAK_RAYS", 60), number("KILN_LEAK_TRIANGLES", 4_000));
    let mut files = Vec::new();
    for folder in ["assets/gltf", "assets/obj", "scenes/ray"] {
        assets(&shared.join(folder), &mut files);
    }
    let mut numbers = Numbers(3);
    let (mut meshes, mut shots, count) = (0, [0; SimdTier::ALL.len()], files.len());
    for file in files {
        let options = ImportOptions { root: Some(shared.clone()), ..ImportOptions::default() };
        let Ok(imported) = import(&file, &options, &Control::default()) else { continue };
        for mesh in &imported.scene.meshes {
            for piece in closed_pieces(mesh).into_iter().filter(|p| p.0.len() <= largest).take(8) {
                let mut tried = false;
                let rays_of = numbers.next() * 1e18;
                for (k, tier) in SimdTier::ALL.into_iter().filter(|t| t.available() == *t).enumerate() {
                    let (out, shot) = leaks(&piece, tier, rays, &mut Numbers(rays_of as u64));
                    assert_eq!(
                        out,
                        0,
                        "{}, mesh '{}', {tier:?}: {out} of {shot} rays get out",
                        file.display(),
                        mesh.name
                    );
                    shots[k] += shot;
                    tried |= shot > 0;
                }
                meshes += usize::from(tried);
            }
        }
    }
    println!("{meshes} closed meshes in {count} files, rays by tier: {shots:?}");
    assert!(meshes > 50, "only {meshes} closed meshes");
}
