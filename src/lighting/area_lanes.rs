//! Points on emissive triangles, sixteen at a time.

use super::{area, spherical};
use crate::geometry::{Geometry, emission};
use crate::lanes::{Floats, LANES, Lanes, Mask, V3};
use crate::math::float_error::gamma;
use glam::Vec3;
use kiln_formats::Scene;

/// Emissive triangles side by side: what [`area::sample`] reads of the geometry and the materials.
#[derive(Debug, Default)]
pub(super) struct AreaTable {
    corners: [[Vec<f32>; 3]; 3],
    /// Unit normals on the front.
    normal: [Vec<f32>; 3],
    area: Vec<f32>,
    radiance: [Vec<f32>; 3],
    /// 1 where the back emits as well, else 0.
    two_sided: Vec<f32>,
    triangle: Vec<u32>,
    /// [`area::near2`] of each.
    near2: Vec<f32>,
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
    /// Of emissive triangles, in their order. They must emit the same everywhere.
    pub fn new(scene: &Scene, geometry: &Geometry, triangles: &[u32]) -> Self {
        let mut table = Self { triangle: triangles.to_vec(), ..Self::default() };
        for triangle in triangles {
            let (corners, normal) = (geometry.corners(*triangle), area::normal(geometry, *triangle));
            let middle = [1.0 / 3.0; 3];
            let radiance = emission::radiance(scene, geometry, *triangle, middle, true);
            for k in 0..3 {
                for (corner, values) in corners.iter().zip(&mut table.corners) {
                    values[k].push(corner[k]);
                }
                table.normal[k].push(normal[k]);
                table.radiance[k].push(radiance[k]);
            }
            table.near2.push(area::near2(corners));
            table.area.push(area::of(geometry, *triangle) as f32);
            let back = emission::radiance(scene, geometry, *triangle, middle, false);
            table.two_sided.push(f32::from(u8::from(back != Vec3::ZERO)));
        }
        table
    }

    /// As [`area::sample`]. The radiance is zero where nothing is emitted.
    #[inline(always)]
    pub fn sample<L: Lanes>(&self, l: L, emitter: L::U, point: V3<L::F>, u: [L::F; 2], active: L::M) -> AreaSamples<L> {
        let at = |values: &[f32]| l.gather(values, emitter);
        let [a, b, c] = self.corners_of(l, emitter);
        let near = self.near(l, emitter, [a, b, c], point) & active;
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
            weights = [0, 1, 2].map(|k| L::F::select(found, own[k], weights[k]));
        }
        let [a, b, c] = [a * weights[0], b * weights[1], c * weights[2]];
        let on_light = a + b + c;
        let normal = V3::from_fn(|k| at(&self.normal[k]));
        let to = on_light - point;
        let distance2 = to.length_squared();
        let distance = distance2.sqrt();
        let direction = to.map(|x| x / distance);
        let cosine = -direction.dot(normal);
        let front = cosine.gt(l.splat(0.0));
        let back = cosine.lt(l.splat(0.0)) & at(&self.two_sided).gt(l.splat(0.0));
        let radiance = V3::from_fn(|k| at(&self.radiance[k])).only((front | back) & direction.is_finite());
        let area_pdf = distance2 / (cosine.abs() * at(&self.area));
        let pdf = L::F::select(spherical.gt(l.splat(0.0)), spherical, area_pdf);
        let error = (a.abs() + b.abs() + c.abs()).map(|x| x * gamma(7));
        let triangle = l.gather_words(&self.triangle, emitter);
        AreaSamples { direction, radiance, pdf, point: on_light, error, normal, triangle }
    }

    /// As [`area::pdf`], without the choice; not finite at the triangle's own plane.
    #[inline(always)]
    pub fn pdf<L: Lanes>(&self, l: L, emitter: L::U, point: V3<L::F>, on_light: V3<L::F>, active: L::M) -> L::F {
        let at = |values: &[f32]| l.gather(values, emitter);
        let to = on_light - point;
        let distance2 = to.length_squared();
        let cos_area = V3::from_fn(|k| at(&self.normal[k])).dot(to).abs() * at(&self.area);
        let by_area = distance2 * distance2.sqrt() / cos_area;
        let corners = self.corners_of(l, emitter);
        let near = self.near(l, emitter, corners, point) & active;
        if near.none() {
            return by_area;
        }
        let half = l.splat(0.5);
        let [spherical, ..] = each(l, near, corners, point, [half, half]);
        L::F::select(spherical.gt(l.splat(0.0)), spherical, by_area)
    }

    #[inline(always)]
    fn corners_of<L: Lanes>(&self, l: L, emitter: L::U) -> [V3<L::F>; 3] {
        [0, 1, 2].map(|k: usize| V3::from_fn(|c| l.gather(&self.corners[k][c], emitter)))
    }

    #[inline(always)]
    fn near<L: Lanes>(&self, l: L, emitter: L::U, [a, b, c]: [V3<L::F>; 3], point: V3<L::F>) -> L::M {
        let middle = (a + b + c).map(|x| x * (1.0 / 3.0));
        (middle - point).length_squared().lt(l.gather(&self.near2, emitter))
    }
}

/// Near triangles one by one, in double precision: the density, or 0 where the area is to be sampled, and the barycentric
/// weights of the point. Where rounding leaves no point the density is infinite.
#[inline(always)]
fn each<L: Lanes>(l: L, near: L::M, corners: [V3<L::F>; 3], point: V3<L::F>, u: [L::F; 2]) -> [L::F; 4] {
    let arrays = |v: V3<L::F>| v.components().map(Floats::array);
    let (corners, point, u) = (corners.map(arrays), arrays(point), u.map(Floats::array));
    let mut found = [[0.0; LANES]; 4];
    let bits = near.bits();
    for lane in (0..LANES).filter(|lane| bits >> lane & 1 == 1) {
        let at = |v: &[[f32; LANES]; 3]| Vec3::new(v[0][lane], v[1][lane], v[2][lane]);
        let [density, weights @ ..] = one(corners.each_ref().map(at), at(&point), [u[0][lane], u[1][lane]]);
        found[0][lane] = density;
        (0..3).for_each(|k| found[k + 1][lane] = weights[k]);
    }
    found.map(|values| l.load(&values))
}

#[inline(never)]
fn one(corners: [Vec3; 3], point: Vec3, u: [f32; 2]) -> [f32; 4] {
    let Some(seen) = area::spherical(corners, point) else { return [0.0; 4] };
    let weights = seen.sample(u).and_then(|direction| spherical::weights(corners, point, direction));
    match weights {
        Some([a, b, c]) => [(1.0 / seen.solid_angle) as f32, a, b, c],
        None => [f32::INFINITY, 1.0, 0.0, 0.0],
    }
}
