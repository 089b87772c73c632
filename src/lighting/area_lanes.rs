//! Points on emissive triangles, sixteen at a time.

use super::{area, spherical};
use crate::geometry::{Geometry, emission};
use crate::lanes::{Floats, LANES, Lanes, Mask, V3, Words};
use crate::math::float_error::gamma;
use glam::Vec3;
use kiln_formats::Scene;

/// Emissive triangles: what [`area::sample`] reads of the geometry and the materials.
#[derive(Debug, Default)]
pub(super) struct AreaTable {
    /// [`NUMBERS`] of each: corners, unit normal on the front, radiance, area, 1 where the back emits as well or else 0, and
    /// [`area::near2`]. Of up to sixteen emitters the first number of each, then the second, and so on; of more than
    /// that all of the first emitter, then those of the second.
    numbers: Vec<f32>,
    triangle: Vec<u32>,
    /// Whether any emits differently at different points: radiance is then looked up point by point.
    varied: bool,
}

/// Numbers of an emitter, and one for nothing.
const NUMBERS: usize = 20;

/// An emitter for each lane.
struct Emitter<L: Lanes> {
    corners: [V3<L::F>; 3],
    normal: V3<L::F>,
    radiance: V3<L::F>,
    area: L::F,
    two_sided: L::F,
    near2: L::F,
}

/// What [`AreaTable::sample`] reads beside the table.
#[derive(Clone, Copy)]
pub(super) struct Emission<'a> {
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
    /// Of emissive triangles, in their order. `varied` tells whether any emits differently at different points.
    pub fn new(scene: &Scene, geometry: &Geometry, triangles: &[u32], varied: bool) -> Self {
        let mut table = Self { triangle: triangles.to_vec(), varied, ..Self::default() };
        for triangle in triangles {
            let (corners, normal) = (geometry.corners(*triangle), area::normal(geometry, *triangle));
            let middle = [1.0 / 3.0; 3];
            let radiance = emission::radiance(scene, geometry, *triangle, middle, true);
            let vectors = corners.into_iter().chain([normal, radiance]);
            table.numbers.extend(vectors.flat_map(|v| v.to_array()));
            let back = emission::radiance(scene, geometry, *triangle, middle, false);
            let area = area::of(geometry, *triangle) as f32;
            let two_sided = f32::from(u8::from(back != Vec3::ZERO));
            table.numbers.extend([area, two_sided, area::near2(corners), 0.0, 0.0]);
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
    fn emitter<L: Lanes>(&self, l: L, emitter: L::U) -> Emitter<L> {
        let at = emitter * NUMBERS as u32;
        let [a, b, c, d, e] = match <&[[f32; LANES]; NUMBERS]>::try_from(self.numbers.as_chunks().0) {
            Ok(rows) => [
                of_rows(l, rows, 0, emitter),
                of_rows(l, rows, 4, emitter),
                of_rows(l, rows, 8, emitter),
                of_rows(l, rows, 12, emitter),
                of_rows(l, rows, 16, emitter),
            ],
            Err(_) => [
                l.gather_four(&self.numbers, at),
                l.gather_four(&self.numbers, at + 4),
                l.gather_four(&self.numbers, at + 8),
                l.gather_four(&self.numbers, at + 12),
                l.gather_four(&self.numbers, at + 16),
            ],
        };
        Emitter {
            corners: [V3::new(a[0], a[1], a[2]), V3::new(a[3], b[0], b[1]), V3::new(b[2], b[3], c[0])],
            normal: V3::new(c[1], c[2], c[3]),
            radiance: V3::new(d[0], d[1], d[2]),
            area: d[3],
            two_sided: e[0],
            near2: e[1],
        }
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
        let Emitter { corners, normal, radiance, area, two_sided, near2 } = self.emitter(l, emitter);
        let triangle = l.gather_words(&self.triangle, emitter);
        let [a, b, c] = corners;
        let middle = (a + b + c) * l.splat(1.0 / 3.0);
        let near = (middle - point).length_squared().lt(near2) & active;
        let upper = u[1].gt(u[0]);
        let low = L::F::select(upper, u[0], u[1]) * 0.5;
        let high = L::F::select(upper, u[1], u[0]) - low;
        let b0 = L::F::select(upper, low, high);
        let b1 = L::F::select(upper, high, low);
        let mut weights = [b0, b1, l.splat(1.0) - b0 - b1];
        let mut spherical = l.splat(0.0);
        if near.any() {
            let [seen, own @ ..] = each(l, near, [a, b, c], point, u);
            let found = seen.gt(l.splat(0.0));
            spherical = seen;
            for (weight, own) in weights.iter_mut().zip(own) {
                *weight = L::F::select(found, own, *weight);
            }
        }
        let [a, b, c] = [a * weights[0], b * weights[1], c * weights[2]];
        let on_light = a + b + c;
        let to = on_light - point;
        let distance2 = to.length_squared();
        let distance = distance2.sqrt();
        let direction = to / distance;
        let cosine = -direction.dot(normal);
        let front = cosine.gt(l.splat(0.0));
        let back = cosine.lt(l.splat(0.0)) & two_sided.gt(l.splat(0.0));
        let radiance = if self.varied {
            let usable = active & !cosine.eq(l.splat(0.0)) & direction.is_finite();
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

/// Near triangles one by one, in double precision: the density, or 0 where the area is to be sampled, and the barycentric
/// weights of the point. Where rounding leaves no point the density is infinite.
#[inline(always)]
fn each<L: Lanes>(l: L, near: L::M, corners: [V3<L::F>; 3], point: V3<L::F>, u: [L::F; 2]) -> [L::F; 4] {
    let [a, b, c] = corners;
    let found =
        each_array(near.bits(), [a.arrays(), b.arrays(), c.arrays()], point.arrays(), [u[0].array(), u[1].array()]);
    let [density, a, b, c] = &found;
    [l.load(density), l.load(a), l.load(b), l.load(c)]
}

#[inline(never)]
fn each_array(
    lanes: u32,
    corners: [[[f32; LANES]; 3]; 3],
    point: [[f32; LANES]; 3],
    u: [[f32; LANES]; 2],
) -> [[f32; LANES]; 4] {
    let mut found = [[0.0; LANES]; 4];
    for lane in (0..LANES).filter(|lane| lanes >> lane & 1 == 1) {
        let at = |v: &[[f32; LANES]; 3]| Vec3::new(v[0][lane], v[1][lane], v[2][lane]);
        let values = one(corners.each_ref().map(at), at(&point), [u[0][lane], u[1][lane]]);
        for (row, value) in found.iter_mut().zip(values) {
            row[lane] = value;
        }
    }
    found
}

fn one(corners: [Vec3; 3], point: Vec3, u: [f32; 2]) -> [f32; 4] {
    let Some(seen) = area::spherical(corners, point) else { return [0.0; 4] };
    let weights = seen.sample(u).and_then(|direction| spherical::weights(corners, point, direction));
    match weights {
        Some([a, b, c]) => [(1.0 / seen.solid_angle) as f32, a, b, c],
        None => [f32::INFINITY, 1.0, 0.0, 0.0],
    }
}
