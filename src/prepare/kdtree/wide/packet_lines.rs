//! Triangles as a packet of rays sees them first: their edges as lines in Plücker coordinates.
//!
//! On which side of an edge from a to b a ray o + t·d passes is the sign of `d·(a × b) + (o × d)·(b − a)`, six products
//! that are fused with their sums, for as many rays as there are lanes; the edges' part of it is made once for a block and
//! kept as long as packets come by. All coordinates count from a point in the block's midst, or in the tree's if it is
//! small. These are estimates: what is within their bounds of error is decided as everywhere
//! ([`packet_exact`](super::packet_exact)).
//!
//! **The bounds.** Let u = 2⁻²⁴, and in the largest component: D the direction's length, R the greatest distance of a
//! corner from the midst, A = |o − midst| + R; and ρ the ray's distance from the midst. The exact test shears a corner
//! with an error of at most 6uA in x and y, where it is at most 3(ρ + R) away from the ray; so its edge functions differ from
//! the true ones by at most 72u·A(ρ + R), times D in the units of a side. The estimate of a side differs from the
//! true one by at most 96u·D·A(ρ + R): the corners' rounding (24 u·D·R²) and that of `o × d` (36 u·D·A·R), the edges' (21 u·D·ρ·R)
//! and the sum's (36 u·D·R² + 62 u·D·ρ·R). [`Frame::error`] is more than both, D left out: 256u·A(ρ + R). With n the
//! normal, of magnitude up to 8R², where a ray meets the plane is `n·(a − o) / n·d`: estimated with an error of 576u·A·R² in the
//! numerator and 240u·D·R² in the denominator; the exact test's weights err by four edge functions' errors over their
//! sum, each moving the point by less than 2R, which is 1152u·A·(ρ + R)·R / |n·d|. All that is below 12 · error · R / |n·d| wherever
//! n·d is more than eight times the error, plus the roundings relative to the distance itself.

use super::super::block::Block;
use super::node::WideNode;
use crate::lanes::{Floats, LANES, Lanes, Mask, V3};

/// 256 u.
const ERROR: f32 = 1.0 / 65_536.0;
/// 16 u: what distances may be off by, relative to the way.
const ROUNDING: f32 = 1.0 / 1_048_576.0;
/// What a ray's distance from the midst may be off by, relative to its origin's.
const BLUR: f32 = 1.0 / 262_144.0;
/// More than underflow takes away.
const UNDERFLOW: f32 = 1e-30;
/// Beyond it products might overflow, and nothing is certain.
const FAR: f32 = 1e9;
/// What is surely before a ray's origin: its distance is a positive number in f32 for any direction of usual length.
const SURELY_BEFORE: f32 = 1e-20;

/// Where coordinates count from, and how far corners are away from there, in the largest component.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Midst {
    point: [f32; 3],
    radius: f32,
}

impl Midst {
    /// Of boxes that hold all of the triangles: lower ends, then upper ends.
    fn of(low: [f32; 3], high: [f32; 3]) -> Self {
        let mut midst = Self::default();
        for axis in 0..3 {
            midst.point[axis] = 0.5 * low[axis] + 0.5 * high[axis];
            midst.radius = midst.radius.max(high[axis] - midst.point[axis]).max(midst.point[axis] - low[axis]);
        }
        // Somewhat more than what rounding takes away.
        midst.radius *= 1.0 + ROUNDING;
        midst
    }

    /// Of a tree that is a single node; `None` for a larger one, where each block has its own.
    pub fn of_small(nodes: &[WideNode]) -> Option<Self> {
        let [root] = nodes else { return None };
        let (mut low, mut high) = ([f32::INFINITY; 3], [f32::NEG_INFINITY; 3]);
        for slot in 0..root.count as usize {
            for axis in 0..3 {
                low[axis] = low[axis].min(root.planes[axis][slot]);
                high[axis] = high[axis].max(root.planes[axis + 3][slot]);
            }
        }
        Some(Self::of(low, high))
    }
}

/// Rows of a block's triangles: for each of the three edges its moment (x, y, z) and its direction; then normals, and their products
/// with the first corners; and the corners as they are.
const ROWS: usize = 31;
const NORMAL: usize = 18;
const ALONG: usize = 21;
const CORNERS: usize = 22;

/// A block's triangles by their lines.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(64))]
pub struct Lines {
    rows: [[f32; LANES]; ROWS],
    numbers: [u32; LANES],
    midst: Midst,
    len: usize,
}

impl Lines {
    /// Of no triangles.
    pub(super) const NONE: Self =
        Self { rows: [[0.0; LANES]; ROWS], numbers: [0; LANES], midst: Midst { point: [0.0; 3], radius: 0.0 }, len: 0 };

    /// Those of a block of a tree, whose midst is that of all if it is small.
    #[inline(always)]
    pub fn of_block<L: Lanes>(l: L, block: &Block, small: Option<Midst>) -> Self {
        let mut lines = Self::NONE;
        lines.set(l, block, small);
        lines
    }

    /// Triangles in the block, up to 16.
    #[inline(always)]
    pub fn len(&self) -> usize {
        self.len.min(LANES)
    }

    /// Number of the i-th triangle.
    #[inline(always)]
    pub fn number(&self, i: usize) -> u32 {
        self.numbers[i]
    }

    /// Corners of the i-th triangle.
    #[inline(always)]
    pub fn corners<L: Lanes>(&self, l: L, i: usize) -> [V3<L::F>; 3] {
        let at = |k: usize| l.splat(self.rows[CORNERS + k][i]);
        // Written out: `map` is not inlined.
        [V3::new(at(0), at(1), at(2)), V3::new(at(3), at(4), at(5)), V3::new(at(6), at(7), at(8))]
    }

    /// Makes them those of a block.
    #[inline(always)]
    pub(super) fn set<L: Lanes>(&mut self, l: L, block: &Block, small: Option<Midst>) {
        self.len = block.len.min(LANES);
        let (mut low, mut high) = ([f32::INFINITY; 3], [f32::NEG_INFINITY; 3]);
        for i in 0..self.len {
            self.numbers[i] = block.triangle(i);
            for (k, x) in block.corners(i).as_flattened().iter().enumerate() {
                self.rows[CORNERS + k][i] = *x;
                (low[k % 3], high[k % 3]) = (low[k % 3].min(*x), high[k % 3].max(*x));
            }
        }
        let own = Midst::of(low, high);
        self.midst = small.filter(|all| all.radius >= own.radius).unwrap_or(own);
        let midst = l.splat_vector(self.midst.point);
        let row = |k: usize| l.load(&self.rows[CORNERS + k]);
        let a = V3::new(row(0), row(1), row(2)) - midst;
        let b = V3::new(row(3), row(4), row(5)) - midst;
        let c = V3::new(row(6), row(7), row(8)) - midst;
        for (edge, (from, to)) in [(b, c), (c, a), (a, b)].into_iter().enumerate() {
            self.put(6 * edge, from.cross(to));
            self.put(6 * edge + 3, to - from);
        }
        let normal = (b - a).cross(c - a);
        self.put(NORMAL, normal);
        normal.dot(a).store(&mut self.rows[ALONG]);
    }

    #[inline(always)]
    fn put<F: Floats>(&mut self, row: usize, v: V3<F>) {
        v.x.store(&mut self.rows[row]);
        v.y.store(&mut self.rows[row + 1]);
        v.z.store(&mut self.rows[row + 2]);
    }
}

/// Which rays pass between the edges of a block's triangles: sets of rays, triangle by triangle.
pub struct Between {
    /// At least those that do.
    pub possible: [u32; LANES],
    /// Certainly do, among all rays.
    pub sure: [u32; LANES],
    /// The triangles that any ray may meet.
    pub triangles: u32,
}

/// Rays as the lines of a block see them.
pub struct Frame<L: Lanes> {
    midst: Midst,
    from: V3<L::F>,
    dir: V3<L::F>,
    /// `from × dir`.
    moment: V3<L::F>,
    /// Bounds on the error of a side, both ways.
    error: [L::F; 2],
    /// Planes that are met at `n·d` of no more than this tell nothing of distances.
    least_slope: L::F,
    /// Error of a distance: over `|n·d|`, and beside it.
    distance_error: [L::F; 2],
}

impl<L: Lanes> Frame<L> {
    /// Rays that count from nowhere yet.
    #[inline(always)]
    pub fn none(l: L) -> Self {
        let zero = l.splat(0.0);
        let nowhere = V3::splat(zero);
        Self {
            midst: Midst { point: [0.0; 3], radius: -1.0 },
            from: nowhere,
            dir: nowhere,
            moment: nowhere,
            error: [zero; 2],
            least_slope: zero,
            distance_error: [zero; 2],
        }
    }

    /// Makes rays of an origin and a direction count from the midst of these lines, unless they do.
    #[inline(always)]
    pub fn turn_to(&mut self, l: L, lines: &Lines, origin: V3<L::F>, dir: V3<L::F>) {
        if self.midst == lines.midst {
            return;
        }
        self.midst = lines.midst;
        let radius = self.midst.radius;
        self.dir = dir;
        self.from = origin - l.splat_vector(self.midst.point);
        self.moment = self.from.cross(dir);
        let length = dir.x.abs().max(dir.y.abs()).max(dir.z.abs());
        let inv = l.splat(1.0) / length;
        let (from, moment) = (self.from.abs(), self.moment.abs());
        let away = from.x.max(from.y).max(from.z) + radius;
        let beside = (moment.x + moment.y + moment.z) * inv + away * BLUR;
        let error = away * (beside + radius) * ERROR;
        // Also where it is not a number.
        let near = away.lt(l.splat(FAR));
        let side = L::F::select(near, error * length + UNDERFLOW, l.splat(f32::INFINITY));
        self.error = [-side, side];
        self.least_slope = side * 8.0;
        self.distance_error = [error * (12.0 * radius), away * inv * ROUNDING];
    }

    /// On which side of an edge the rays pass, by the number of its first row.
    #[inline(always)]
    fn side(&self, l: L, lines: &Lines, row: usize, i: usize) -> L::F {
        let at = |k: usize| l.splat(lines.rows[row + k][i]);
        let sum = at(1).estimate_mul_add(self.dir.y, at(0) * self.dir.x);
        let sum = at(3).estimate_mul_add(self.moment.x, at(2).estimate_mul_add(self.dir.z, sum));
        at(5).estimate_mul_add(self.moment.z, at(4).estimate_mul_add(self.moment.y, sum))
    }

    /// What the edges of all triangles tell of rays: a loop without branches.
    #[inline(always)]
    pub fn between(&self, l: L, lines: &Lines, rays: u32) -> Between {
        let mut seen = Between { possible: [0; LANES], sure: [0; LANES], triangles: 0 };
        let mut triangles = 0;
        for i in 0..lines.len() {
            let [u, v, w] = [self.side(l, lines, 0, i), self.side(l, lines, 6, i), self.side(l, lines, 12, i)];
            let (least, most) = (u.min(v).min(w), u.max(v).max(w));
            let [below, above] = [least.lt(self.error[0]), most.gt(self.error[1])];
            let [all_above, all_below] = [least.gt(self.error[1]), most.lt(self.error[0])];
            let possible = rays & !(below & above).bits();
            (seen.possible[i], seen.sure[i]) = (possible, (all_above | all_below).bits());
            triangles |= u32::from(possible != 0) << i;
        }
        seen.triangles = triangles;
        seen
    }

    /// Bounds on the distance at which the rays meet the i-th triangle's plane, as the exact test has it, and where they hold.
    #[inline(always)]
    pub fn distance(&self, l: L, lines: &Lines, i: usize) -> ([L::F; 2], L::M) {
        let at = |k: usize| l.splat(lines.rows[k][i]);
        let normal = [at(NORMAL), at(NORMAL + 1), at(NORMAL + 2)];
        let along = |v: V3<L::F>| {
            let [x, y, z] = normal;
            z.estimate_mul_add(v.z, y.estimate_mul_add(v.y, x * v.x))
        };
        let slope = along(self.dir);
        let inv = l.splat(1.0) / slope;
        let t = (at(ALONG) - along(self.from)) * inv;
        let [over, beside] = self.distance_error;
        let error = inv.abs().estimate_mul_add(over, t.abs().estimate_mul_add(l.splat(ROUNDING), beside));
        ([t - error, t + error], slope.abs().gt(self.least_slope))
    }
}

/// Whether a distance is certainly before the ray's origin, by its lower bound.
#[inline(always)]
pub fn surely_ahead<L: Lanes>(l: L, low: L::F) -> L::M {
    low.gt(l.splat(SURELY_BEFORE))
}
