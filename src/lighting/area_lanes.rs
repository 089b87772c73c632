//! Points on emissive triangles, sixteen at a time.

use super::area;
use super::emitter::{Emitter, NearPoint};
use crate::geometry::{Geometry, emission};
use crate::lanes::{Floats, LANES, Lanes, Mask, V3, Words};
use crate::math::float_error::gamma;
use glam::Vec3;
use kiln_formats::Scene;

/// Emissive triangles: what [`area::sample`] reads of the geometry and the materials.
#[derive(Debug, Default)]
pub(super) struct AreaTable {
    /// [`NUMBERS`] of each: corners in the order of [`Half::corners`](super::emitter::Half::corners), unit normal on the front, radiance,
    /// the area of its emitter if both halves were like it, negative where the back emits as well, and
    /// [`Emitter::place`]. Of up to sixteen triangles the first number of each, then the second, and so on; of more than
    /// that all of the first triangle, then those of the second.
    numbers: Vec<f32>,
    triangle: Vec<u32>,
    /// Rows of each emitter's halves, the first one with [`PAIR`] where there are two; nothing if there are none of two.
    halves: Vec<u32>,
    /// Whether any emits differently at different points: radiance is then looked up point by point.
    varied: bool,
}

/// Numbers of a triangle.
const NUMBERS: usize = 20;
/// Marks emitters of two halves.
const PAIR: u32 = 1 << 31;

/// A triangle of an emitter for each lane.
struct Row<L: Lanes> {
    corners: [V3<L::F>; 3],
    normal: V3<L::F>,
    radiance: V3<L::F>,
    area: L::F,
    two_sided: L::M,
    middle: V3<L::F>,
    near2: L::F,
}

/// What [`AreaTable::sample`] reads beside the table.
#[derive(Clone, Copy)]
pub(super) struct Emission<'a> {
    pub emitters: &'a [Emitter],
    pub scene: &'a Scene,
    pub geometry: &'a Geometry,
}

/// Points on triangles, seen from receivers.
pub(super) struct AreaSamples<L: Lanes> {
    pub direction: V3<L::F>,
    pub radiance: V3<L::F>,
    /// Solid angle density; meaningless where the radiance is zero.
    pub pdf: L::F,
    pub point: V3<L::F>,
    pub error: V3<L::F>,
    pub normal: V3<L::F>,
    pub triangle: L::U,
}

impl AreaTable {
    /// Of emitters, whose triangles are numbered by their rows. `varied` tells whether any emits differently at different points.
    pub fn new(scene: &Scene, geometry: &Geometry, emitters: &[Emitter], triangles: &[u32], varied: bool) -> Self {
        let mut table = Self { triangle: triangles.to_vec(), varied, ..Self::default() };
        table.numbers = vec![0.0; triangles.len() * NUMBERS];
        let pairs = emitters.iter().any(Emitter::is_pair);
        for emitter in emitters {
            if pairs {
                let [first, second] = emitter.halves.map(|half| half.row);
                table.halves.extend([first | if emitter.is_pair() { PAIR } else { 0 }, second]);
            }
            let (middle, near2) = emitter.place(geometry);
            for half in &emitter.halves {
                let (triangle, thirds) = (half.triangle, [1.0 / 3.0; 3]);
                let radiance = |front| emission::radiance(scene, geometry, triangle, thirds, front);
                let area = area::of(geometry, triangle) as f32 / emitter.share();
                let area = if radiance(false) == Vec3::ZERO { area } else { -area };
                let [a, b, c] = half.corners(geometry);
                let numbers = [a, b, c, area::normal(geometry, triangle), radiance(true)].map(|v| v.to_array());
                let to = &mut table.numbers[half.row as usize * NUMBERS..][..NUMBERS];
                to[..15].copy_from_slice(numbers.as_flattened());
                to[15..].copy_from_slice(&[area, middle.x, middle.y, middle.z, near2]);
            }
        }
        if triangles.len() <= LANES {
            table.transpose();
        }
        table
    }

    /// Up to sixteen are looked up fastest in tables of sixteen.
    fn transpose(&mut self) {
        self.numbers.resize(LANES * NUMBERS, 0.0);
        let number = |k: usize| self.numbers[k % LANES * NUMBERS + k / LANES];
        self.numbers = (0..LANES * NUMBERS).map(number).collect();
        self.triangle.resize(LANES, 0);
    }

    #[inline(always)]
    fn row<L: Lanes>(&self, l: L, row: L::U) -> Row<L> {
        let at = row * NUMBERS as u32;
        let [a, b, c, d, e] = match <&[[f32; LANES]; NUMBERS]>::try_from(self.numbers.as_chunks().0) {
            Ok(rows) => [
                of_rows(l, rows, 0, row),
                of_rows(l, rows, 4, row),
                of_rows(l, rows, 8, row),
                of_rows(l, rows, 12, row),
                of_rows(l, rows, 16, row),
            ],
            Err(_) => [
                l.gather_four(&self.numbers, at),
                l.gather_four(&self.numbers, at + 4),
                l.gather_four(&self.numbers, at + 8),
                l.gather_four(&self.numbers, at + 12),
                l.gather_four(&self.numbers, at + 16),
            ],
        };
        Row {
            corners: [V3::new(a[0], a[1], a[2]), V3::new(a[3], b[0], b[1]), V3::new(b[2], b[3], c[0])],
            normal: V3::new(c[1], c[2], c[3]),
            radiance: V3::new(d[0], d[1], d[2]),
            area: d[3].abs(),
            two_sided: d[3].lt(l.splat(0.0)),
            middle: V3::new(e[0], e[1], e[2]),
            near2: e[3],
        }
    }

    /// Rows and barycentric weights of points uniform over areas: as [`Emitter::sample_area`].
    #[inline(always)]
    fn sample_area<L: Lanes>(&self, l: L, emitter: L::U, [u, v]: [L::F; 2]) -> (L::U, [L::F; 3]) {
        let one = l.splat(1.0);
        let upper = v.gt(u);
        let low = L::F::select(upper, u, v) * 0.5;
        let high = L::F::select(upper, v, u) - low;
        let b0 = L::F::select(upper, low, high);
        let b1 = L::F::select(upper, high, low);
        let alone = [b0, b1, one - b0 - b1];
        if self.halves.is_empty() {
            return (emitter, alone);
        }
        let at = emitter.shl::<1>();
        let (first, second) = (l.gather_words(&self.halves, at), l.gather_words(&self.halves, at + 1));
        let pair = !first.lt(l.word(PAIR));
        let flip = pair & (u + v).gt(one);
        let (u, v) = (L::F::select(flip, one - u, u), L::F::select(flip, one - v, v));
        let [a, b, c] = alone;
        // Written out: `map` is not inlined.
        let weights = [L::F::select(pair, one - u - v, a), L::F::select(pair, u, b), L::F::select(pair, v, c)];
        (L::U::select(flip, second, first & !PAIR), weights)
    }

    /// As [`area::sample`]. The radiance is zero where nothing is emitted.
    #[inline(always)]
    pub fn sample<L: Lanes>(
        &self,
        l: L,
        emission: Emission,
        emitter: L::U,
        point: V3<L::F>,
        u: [L::F; 2],
        active: L::M,
    ) -> AreaSamples<L> {
        let (mut row, mut weights) = self.sample_area(l, emitter, u);
        let mut of = self.row(l, row);
        let near = (of.middle - point).length_squared().lt(of.near2) & active;
        let mut spherical = l.splat(0.0);
        if near.any() {
            let own = emission.each(near.bits(), &emitter.array(), &point.arrays(), &[u[0].array(), u[1].array()]);
            spherical = l.load(&own.density);
            let found = spherical.gt(l.splat(0.0));
            for (weight, own) in weights.iter_mut().zip(&own.weights) {
                *weight = L::F::select(found, l.load(own), *weight);
            }
            row = L::U::select(found, l.load_words(&own.row), row);
            if !self.halves.is_empty() {
                of = self.row(l, row);
            }
        }
        let Row { corners: [a, b, c], normal, radiance, area, two_sided, .. } = of;
        let triangle = l.gather_words(&self.triangle, row);
        let [a, b, c] = [a * weights[0], b * weights[1], c * weights[2]];
        let on_light = a + b + c;
        let to = on_light - point;
        let distance2 = to.length_squared();
        let distance = distance2.sqrt();
        let direction = to / distance;
        let cosine = -direction.dot(normal);
        let front = cosine.gt(l.splat(0.0));
        let back = cosine.lt(l.splat(0.0)) & two_sided;
        let radiance = if self.varied {
            let usable = active & !cosine.eq(l.splat(0.0)) & direction.is_finite();
            // Quadrilaterals, whose corners are in another order, emit the same everywhere.
            let weights = [weights[0].array(), weights[1].array(), weights[2].array()];
            l.load_vector(&emission.radiance(usable.bits(), front.bits(), &triangle.array(), &weights))
        } else {
            radiance.only((front | back) & direction.is_finite())
        };
        let area_pdf = distance2 / (cosine.abs() * area);
        let pdf = L::F::select(spherical.gt(l.splat(0.0)), spherical, area_pdf);
        let error = (a.abs() + b.abs() + c.abs()) * l.splat(gamma(7));
        AreaSamples { direction, radiance, pdf, point: on_light, error, normal, triangle }
    }
}

/// Four numbers of each lane's emitter, of tables of sixteen.
#[inline(always)]
fn of_rows<L: Lanes>(l: L, rows: &[[f32; LANES]; NUMBERS], first: usize, emitter: L::U) -> [L::F; 4] {
    let [a, b, c, d] = [&rows[first], &rows[first + 1], &rows[first + 2], &rows[first + 3]];
    [l.gather(a, emitter), l.gather(b, emitter), l.gather(c, emitter), l.gather(d, emitter)]
}

impl Emission<'_> {
    /// Radiance at points with these weights, one after the other: towards the front or the back of their triangles.
    #[inline(never)]
    fn radiance(
        &self,
        lanes: u32,
        front: u32,
        triangle: &[u32; LANES],
        weights: &[[f32; LANES]; 3],
    ) -> [[f32; LANES]; 3] {
        let mut found = [[0.0; LANES]; 3];
        for lane in (0..LANES).filter(|lane| lanes >> lane & 1 == 1) {
            let (b, front) = (weights.map(|w| w[lane]), front >> lane & 1 == 1);
            let radiance = emission::radiance(self.scene, self.geometry, triangle[lane], b, front);
            for (row, value) in found.iter_mut().zip(radiance.to_array()) {
                row[lane] = value;
            }
        }
        found
    }
}

/// Points on near emitters.
struct Near {
    /// Over solid angle; 0 where the area is to be sampled. Where rounding leaves no point it is infinite.
    density: [f32; LANES],
    weights: [[f32; LANES]; 3],
    row: [u32; LANES],
}

impl Emission<'_> {
    /// Near emitters one by one, in double precision.
    #[inline(never)]
    fn each(&self, lanes: u32, emitter: &[u32; LANES], point: &[[f32; LANES]; 3], u: &[[f32; LANES]; 2]) -> Near {
        let mut found = Near { density: [0.0; LANES], weights: [[0.0; LANES]; 3], row: [0; LANES] };
        for lane in (0..LANES).filter(|lane| lanes >> lane & 1 == 1) {
            let emitter = &self.emitters[emitter[lane] as usize];
            let point = Vec3::new(point[0][lane], point[1][lane], point[2][lane]);
            let Some(own) = emitter.sample_near(self.geometry, point, [u[0][lane], u[1][lane]]) else { continue };
            let nothing = NearPoint { half: 0, weights: [1.0, 0.0, 0.0], pdf: f32::INFINITY };
            let NearPoint { half, weights, pdf } = own.unwrap_or(nothing);
            (found.density[lane], found.row[lane]) = (pdf, emitter.halves[half].row);
            (0..3).for_each(|k| found.weights[k][lane] = weights[k]);
        }
        found
    }
}
