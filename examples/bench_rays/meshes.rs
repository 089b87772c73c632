//! Meshes of our own making.

use glam::Vec3;
use kiln::prepare::kdtree::Triangles;

pub const NAMES: [&str; 10] =
    ["scan", "terrain", "knot", "stadium", "hair", "foliage", "straw", "box", "fur", "clutter"];

/// Corners and faces.
pub struct Mesh {
    pub points: Vec<Vec3>,
    pub faces: Vec<[u32; 3]>,
}

impl Triangles for Mesh {
    fn len(&self) -> usize {
        self.faces.len()
    }

    fn vertices(&self, triangle: u32) -> [Vec3; 3] {
        self.faces[triangle as usize].map(|i| self.points[i as usize])
    }
}

pub fn hash(i: u32, k: u32) -> f32 {
    let mut x = u64::from(i) << 32 | u64::from(k);
    x = (x ^ (x >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9).wrapping_add(0x1234_5678_9abc);
    x = (x ^ (x >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    ((x ^ (x >> 31)) >> 40) as f32 / 16_777_216.0
}

fn grid(nu: u32, nv: u32, point: impl Fn(f32, f32) -> Vec3) -> Mesh {
    let points = (0..=nu)
        .flat_map(|i| (0..=nv).map(move |k| (i, k)))
        .map(|(i, k)| point(i as f32 / nu as f32, k as f32 / nv as f32))
        .collect();
    let at = |i: u32, k: u32| i * (nv + 1) + k;
    let faces = (0..nu)
        .flat_map(|i| (0..nv).map(move |k| (i, k)))
        .flat_map(|(i, k)| [[at(i, k), at(i + 1, k), at(i + 1, k + 1)], [at(i, k), at(i + 1, k + 1), at(i, k + 1)]]);
    Mesh { faces: faces.collect(), points }
}

fn noise(x: f32, z: f32) -> f32 {
    let (i, k) = (x.floor(), z.floor());
    let smooth = |f: f32| f * f * (3.0 - 2.0 * f);
    let (fx, fz) = (smooth(x - i), smooth(z - k));
    let h = |a: f32, b: f32| hash((i + a) as i32 as u32, (k + b) as i32 as u32);
    let (low, high) = (h(0.0, 0.0) * (1.0 - fx) + h(1.0, 0.0) * fx, h(0.0, 1.0) * (1.0 - fx) + h(1.0, 1.0) * fx);
    low * (1.0 - fz) + high * fz
}

fn fractal(x: f32, z: f32, octaves: u32, first: f32) -> f32 {
    let (mut sum, mut amplitude, mut frequency) = (0.0, 0.5, first);
    for octave in 0..octaves {
        let n = noise(x * frequency + 13.7 * octave as f32, z * frequency + 7.1 * octave as f32);
        sum += amplitude * if octave < 4 { 1.0 - (2.0 * n - 1.0).abs() } else { n };
        amplitude *= 0.5;
        frequency *= 2.0;
    }
    sum
}

/// Cells along the sides of a grid of so many triangles, or of the usual sides.
fn sides([nu, nv]: [u32; 2], triangles: Option<u32>) -> [u32; 2] {
    let Some(triangles) = triangles else { return [nu, nv] };
    let scale = (f64::from(triangles) / f64::from(2 * nu * nv)).sqrt();
    [nu, nv].map(|n| ((f64::from(n) * scale).round() as u32).max(2))
}

/// A lumpy body, triangles of like size in rows, as range scanners make them.
fn scan(triangles: Option<u32>) -> Mesh {
    let [nu, nv] = sides([560, 270], triangles);
    grid(nu, nv, |u, v| {
        let (a, b) = (core::f32::consts::TAU * u, core::f32::consts::PI * (0.02 + 0.96 * v));
        let dir = Vec3::new(libm::sinf(b) * libm::cosf(a), libm::cosf(b), libm::sinf(b) * libm::sinf(a));
        let lumps = 0.25 * libm::sinf(3.0 * dir.x + 1.0) * libm::sinf(4.0 * dir.y) * libm::sinf(3.0 * dir.z + 2.0);
        let detail = 0.03 * libm::sinf(23.0 * dir.x) * libm::sinf(19.0 * dir.y) * libm::sinf(29.0 * dir.z);
        let grain = 0.003 * hash((u * nu as f32) as u32, (v * nv as f32) as u32);
        dir * (1.0 + lumps + detail + grain)
    })
}

fn terrain(triangles: Option<u32>) -> Mesh {
    let [nu, nv] = sides([1000, 500], triangles);
    grid(nu, nv, |u, v| {
        let (x, z) = (20.0 * u - 10.0, 10.0 * v - 5.0);
        Vec3::new(x, 2.4 * fractal(x + 40.0, z + 40.0, 9, 0.35), z)
    })
}

fn knot(triangles: Option<u32>) -> Mesh {
    let [nu, nv] = sides([2200, 350], triangles);
    let centre = |t: f32| {
        let r = 2.0 + libm::cosf(3.0 * t);
        Vec3::new(r * 0.5 * libm::cosf(2.0 * t), libm::sinf(3.0 * t) * 0.5, r * 0.5 * libm::sinf(2.0 * t))
    };
    grid(nu, nv, |u, v| {
        let (a, b) = (core::f32::consts::TAU * u, core::f32::consts::TAU * v);
        let along = (centre(a + 1e-2) - centre(a - 1e-2)).normalize();
        let side = along.cross(centre(a)).normalize();
        let up = side.cross(along);
        let bumps = 1.0
            + 0.12 * libm::sinf(40.0 * a) * libm::sinf(8.0 * b)
            + 0.03 * libm::sinf(210.0 * a) * libm::cosf(32.0 * b);
        centre(a) + (up * libm::cosf(b) + side * libm::sinf(b)) * (0.3 * bumps)
    })
}

fn push(mesh: &mut Mesh, part: Mesh) {
    let base = mesh.points.len() as u32;
    mesh.points.extend(part.points);
    mesh.faces.extend(part.faces.iter().map(|f| f.map(|i| i + base)));
}

/// A few huge triangles around, rows of seats, and a dense ball in the middle: the teapot in a stadium.
fn stadium() -> Mesh {
    let mut all = grid(1, 1, |u, v| Vec3::new(200.0 * u - 100.0, 0.0, 200.0 * v - 100.0));
    for side in 0..24 {
        let angle = core::f32::consts::TAU * side as f32 / 24.0;
        let next = core::f32::consts::TAU * (side + 1) as f32 / 24.0;
        push(
            &mut all,
            grid(1, 12, |u, v| {
                let a = angle + u * (next - angle);
                Vec3::new((40.0 + 30.0 * v) * libm::cosf(a), 20.0 * v, (40.0 + 30.0 * v) * libm::sinf(a))
            }),
        );
    }
    for seat in 0..3000u32 {
        let (row, place) = (seat / 150, seat % 150);
        let a = core::f32::consts::TAU * place as f32 / 150.0;
        let r = 42.0 + 1.4 * row as f32;
        let at = Vec3::new(r * libm::cosf(a), 0.95 * row as f32 + 1.2, r * libm::sinf(a));
        push(&mut all, grid(2, 2, |u, v| at + Vec3::new(u * 0.6, v * 0.6, u * v * 0.5)));
    }
    push(
        &mut all,
        grid(220, 170, |u, v| {
            let (a, b) = (core::f32::consts::TAU * u, core::f32::consts::PI * v);
            let r = 1.0 + 0.05 * libm::sinf(12.0 * a) * libm::sinf(9.0 * b);
            Vec3::new(r * libm::sinf(b) * libm::cosf(a), 1.0 + r * libm::cosf(b), r * libm::sinf(b) * libm::sinf(a))
        }),
    );
    all
}

/// Curved strands of thin triangles on a ball.
fn hair(triangles: Option<u32>) -> Mesh {
    let mut all = Mesh { points: Vec::new(), faces: Vec::new() };
    for strand in 0..triangles.unwrap_or(224_000) / 16 {
        let (z, a) = (1.0 - 2.0 * hash(strand, 0), core::f32::consts::TAU * hash(strand, 1));
        let r = (1.0 - z * z).max(0.0).sqrt();
        let root = Vec3::new(r * libm::cosf(a), z, r * libm::sinf(a));
        let lean = Vec3::new(hash(strand, 2) - 0.5, -0.6, hash(strand, 3) - 0.5);
        let side = root.cross(lean).normalize() * 0.0015;
        let point = move |s: f32| root * (1.0 + 0.9 * s) + lean * (s * s);
        push(&mut all, grid(8, 1, |u, v| point(u) + side * (2.0 * v - 1.0) * (1.0 - 0.9 * u)));
    }
    all
}

/// Many small leaves at all angles.
fn foliage() -> Mesh {
    let mut all = Mesh { points: Vec::new(), faces: Vec::new() };
    for leaf in 0..100_000u32 {
        let h = |k: u32| hash(leaf, k) * 2.0 - 1.0;
        let at = Vec3::new(h(0), h(1), h(2)) * (0.4 + 0.6 * hash(leaf, 3));
        let (along, across) = (Vec3::new(h(4), h(5), h(6)) * 0.03, Vec3::new(h(7), h(8), h(9)) * 0.012);
        push(
            &mut all,
            grid(2, 1, |u, v| at + along * u + across * ((2.0 * v - 1.0) * (1.0 - (2.0 * u - 1.0).abs() * 0.8))),
        );
    }
    all
}

/// Few triangles: five walls, and two blocks within.
fn cornell_box() -> Mesh {
    let mut all = Mesh { points: Vec::new(), faces: Vec::new() };
    let mut wall = |at: Vec3, a: Vec3, b: Vec3| push(&mut all, grid(1, 1, |u, v| at + a * u + b * v));
    let mut block = |at: Vec3, [x, y, z]: [Vec3; 3], open: bool| {
        wall(at, x, y);
        wall(at, y, z);
        wall(at, z, x);
        wall(at + x, y, z);
        wall(at + y, z, x);
        if !open {
            wall(at + z, x, y);
        }
    };
    let turned = |angle: f32, size: f32, height: f32| {
        let (s, c) = (libm::sinf(angle), libm::cosf(angle));
        [Vec3::new(c, 0.0, s) * size, Vec3::Y * height, Vec3::new(-s, 0.0, c) * size]
    };
    block(Vec3::splat(-1.0), [Vec3::X * 2.0, Vec3::Y * 2.0, Vec3::Z * 2.0], true);
    block(Vec3::new(-0.6, -0.99, -0.6), turned(0.3, 0.6, 1.2), false);
    block(Vec3::new(0.2, -0.99, 0.0), turned(-0.3, 0.6, 0.6), false);
    all
}

/// Long thin triangles in all directions.
fn straw(triangles: Option<u32>) -> Mesh {
    let mut all = Mesh { points: Vec::new(), faces: Vec::new() };
    for stalk in 0..triangles.unwrap_or(225_000) / 2 {
        let h = |k: u32| hash(stalk, k) * 2.0 - 1.0;
        let at = Vec3::new(h(0), h(1), h(2));
        let along = Vec3::new(h(3), h(4), h(5)).normalize_or(Vec3::X) * (0.1 + 0.3 * hash(stalk, 6));
        let across = along.cross(Vec3::new(h(7), h(8), h(9))).normalize_or(Vec3::Y) * 0.001;
        push(&mut all, grid(1, 1, |u, v| at + along * u + across * v));
    }
    all
}

/// Blades that lean over a hilly ground, each of three long segments.
fn fur() -> Mesh {
    let ground = |x: f32, z: f32| 0.15 * libm::sinf(3.0 * x) * libm::cosf(2.0 * z);
    let mut all = grid(100, 100, |u, v| {
        let (x, z) = (2.0 * u - 1.0, 2.0 * v - 1.0);
        Vec3::new(x, ground(x, z), z)
    });
    for blade in 0..60_000u32 {
        let h = |k: u32| hash(blade, k) * 2.0 - 1.0;
        let root = Vec3::new(h(0), ground(h(0), h(1)), h(1));
        let (lean, side) =
            (Vec3::new(h(2), 0.0, h(3)) * 0.15, Vec3::new(h(4), 0.0, h(5)).normalize_or(Vec3::X) * 0.001);
        let height = 0.12 + 0.08 * hash(blade, 6);
        push(
            &mut all,
            grid(3, 1, |u, v| {
                root + Vec3::Y * (height * u) + lean * (u * u) + side * ((2.0 * v - 1.0) * (1.0 - 0.8 * u))
            }),
        );
    }
    all
}

/// Small round bodies of many sizes, strewn about.
fn clutter() -> Mesh {
    let mut all = grid(4, 4, |u, v| Vec3::new(20.0 * u - 10.0, 0.0, 20.0 * v - 10.0));
    for body in 0..1500u32 {
        let h = |k: u32| hash(body, k) * 2.0 - 1.0;
        let size = 0.04 + 0.5 * libm::powf(hash(body, 3), 6.0);
        let at = Vec3::new(9.0 * h(0), size + 1.5 * hash(body, 1) * hash(body, 1), 9.0 * h(2));
        push(
            &mut all,
            grid(24, 12, |u, v| {
                let (a, b) = (core::f32::consts::TAU * u, core::f32::consts::PI * v);
                let r = size * (1.0 + 0.2 * libm::sinf(3.0 * a + body as f32) * libm::sinf(b));
                at + Vec3::new(libm::sinf(b) * libm::cosf(a), libm::cosf(b), libm::sinf(b) * libm::sinf(a)) * r
            }),
        );
    }
    all
}

/// A mesh by its name; scan, terrain, knot, hair and straw may be followed by a colon and the number of triangles, about.
pub fn make(name: &str) -> Mesh {
    let (name, triangles) = match name.split_once(':') {
        Some((name, number)) => (name, Some(number.parse().expect("a number of triangles"))),
        None => (name, None),
    };
    match name {
        "scan" => scan(triangles),
        "terrain" => terrain(triangles),
        "knot" => knot(triangles),
        "stadium" => stadium(),
        "hair" => hair(triangles),
        "foliage" => foliage(),
        "box" => cornell_box(),
        "straw" => straw(triangles),
        "fur" => fur(),
        "clutter" => clutter(),
        other => panic!("unknown mesh {other}: {NAMES:?}"),
    }
}
