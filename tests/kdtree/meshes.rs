//! Triangles to build trees over, and random numbers with a fixed seed.

use glam::Vec3;
use kiln::prepare::kdtree::Triangles;

/// Triangles by their corners.
pub struct Soup(pub Vec<[Vec3; 3]>);

impl Triangles for Soup {
    fn len(&self) -> usize {
        self.0.len()
    }

    fn vertices(&self, triangle: u32) -> [Vec3; 3] {
        self.0[triangle as usize]
    }
}

impl Soup {
    pub fn scaled(mut self, by: f32) -> Self {
        self.0.as_flattened_mut().iter_mut().for_each(|corner| *corner *= by);
        self
    }
}

/// splitmix64.
pub struct Random(pub u64);

impl Random {
    pub fn bits(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut x = self.0;
        x = (x ^ (x >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        x = (x ^ (x >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        x ^ (x >> 31)
    }

    pub fn below(&mut self, n: usize) -> usize {
        (self.bits() % n as u64) as usize
    }

    /// In [0, 1).
    pub fn unit(&mut self) -> f32 {
        (self.bits() >> 40) as f32 / 16_777_216.0
    }

    /// In [-1, 1)³.
    pub fn cube(&mut self) -> Vec3 {
        Vec3::new(self.unit(), self.unit(), self.unit()) * 2.0 - 1.0
    }

    /// A coordinate with few bits: points on planes, coincidences.
    pub fn lattice(&mut self) -> Vec3 {
        Vec3::new(self.below(9) as f32, self.below(9) as f32, self.below(9) as f32) * 0.25 - 1.0
    }
}

pub fn random_soup(n: usize, size: f32, seed: u64) -> Soup {
    let mut random = Random(seed);
    let triangle = |_| {
        let at = random.cube();
        [at, at + random.cube() * size, at + random.cube() * size]
    };
    Soup((0..n).map(triangle).collect())
}

/// Corners on a coarse lattice: coplanar, overlapping, axis-parallel and degenerate triangles galore.
pub fn lattice_soup(n: usize, seed: u64) -> Soup {
    let mut random = Random(seed);
    Soup((0..n).map(|_| [random.lattice(), random.lattice(), random.lattice()]).collect())
}

/// Long thin triangles.
pub fn hair(n: usize, seed: u64) -> Soup {
    let mut random = Random(seed);
    let strand = |_| {
        let root = random.cube();
        let tip = root + random.cube();
        [root, tip, root + random.cube() * 1e-3]
    };
    Soup((0..n).map(strand).collect())
}

/// Sizes from 1e-12 to 1e12 in one scene.
pub fn all_sizes(n: usize, seed: u64) -> Soup {
    let mut random = Random(seed);
    let triangle = |i: usize| {
        let size = libm::powf(10.0, (i % 25) as f32 - 12.0);
        let at = random.cube() * if i.is_multiple_of(2) { size } else { 1.0 };
        [at, at + random.cube() * size, at + random.cube() * size]
    };
    Soup((0..n).map(triangle).collect())
}

/// One triangle many times.
pub fn identical(n: usize) -> Soup {
    Soup(vec![[Vec3::new(-1.0, -1.0, 0.0), Vec3::new(1.0, -1.0, 0.2), Vec3::new(0.0, 1.0, 0.1)]; n])
}

/// A regular grid in the plane z = 0, split along diagonals.
pub fn coplanar(side: usize) -> Soup {
    let at = |i: usize, k: usize| Vec3::new(i as f32, k as f32, 0.0) / side as f32 * 2.0 - Vec3::new(1.0, 1.0, 0.0);
    let cells = (0..side * side).flat_map(|c| {
        let (i, k) = (c % side, c / side);
        let corners = [at(i, k), at(i + 1, k), at(i + 1, k + 1), at(i, k + 1)];
        [[corners[0], corners[1], corners[2]], [corners[0], corners[2], corners[3]]]
    });
    Soup(cells.collect())
}

/// Triangles without area on one line.
pub fn collinear(n: usize, seed: u64) -> Soup {
    let mut random = Random(seed);
    let dir = Vec3::new(0.6, -0.8, 0.3);
    let triangle = |_| [dir * random.unit(), dir * random.unit(), dir * (random.unit() * 2.0)];
    Soup((0..n).map(triangle).collect())
}

/// A closed mesh by its corners and faces.
pub struct Mesh {
    pub points: Vec<Vec3>,
    pub faces: Vec<[usize; 3]>,
}

impl Mesh {
    pub fn soup(&self, scale: f32, offset: Vec3) -> Soup {
        Soup(self.faces.iter().map(|f| f.map(|i| self.points[i] * scale + offset)).collect())
    }
}

/// An octahedron refined `level` times and blown up to the unit sphere.
pub fn sphere(level: usize) -> Mesh {
    let mut points = vec![Vec3::X, Vec3::NEG_X, Vec3::Y, Vec3::NEG_Y, Vec3::Z, Vec3::NEG_Z];
    let mut faces: Vec<[usize; 3]> =
        vec![[0, 2, 4], [2, 1, 4], [1, 3, 4], [3, 0, 4], [2, 0, 5], [1, 2, 5], [3, 1, 5], [0, 3, 5]];
    for _ in 0..level {
        let mut middles = std::collections::BTreeMap::new();
        let mut middle = |a: usize, b: usize, points: &mut Vec<Vec3>| {
            *middles.entry((a.min(b), a.max(b))).or_insert_with(|| {
                points.push((points[a] + points[b]).normalize());
                points.len() - 1
            })
        };
        let old = std::mem::take(&mut faces);
        for [a, b, c] in old {
            let (x, y, z) = (middle(a, b, &mut points), middle(b, c, &mut points), middle(c, a, &mut points));
            faces.extend([[a, x, z], [x, b, y], [z, y, c], [x, y, z]]);
        }
    }
    Mesh { points, faces }
}

/// A torus about the y axis, of radii 1 and 0.4, with a bumpy surface.
pub fn torus(around: usize, across: usize) -> Mesh {
    let turn = core::f32::consts::TAU;
    let point = |i: usize, k: usize| {
        let (u, v) = (turn * i as f32 / around as f32, turn * k as f32 / across as f32);
        let r = 0.4 + 0.03 * libm::sinf(9.0 * u) * libm::sinf(5.0 * v);
        let ring = 1.0 + r * libm::cosf(v);
        Vec3::new(ring * libm::cosf(u), r * libm::sinf(v), ring * libm::sinf(u))
    };
    let points = (0..around * across).map(|c| point(c / across, c % across)).collect();
    let index = |i: usize, k: usize| (i % around) * across + k % across;
    let faces = (0..around * across).flat_map(|c| {
        let (i, k) = (c / across, c % across);
        let (a, b, c, d) = (index(i, k), index(i + 1, k), index(i + 1, k + 1), index(i, k + 1));
        [[a, b, c], [a, c, d]]
    });
    Mesh { points, faces: faces.collect() }
}
