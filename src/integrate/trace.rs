//! Rays against the prepared scene, with coverage, culling and coloured shadows.

use super::cone::Cone;
use super::medium::{Inside, through_surface};
use super::vertex::{Outgoing, Place, Vertex};
use crate::geometry::{Geometry, coverage};
use crate::lighting::{LightSample, Target};
use crate::math::float_error::offset_point;
use crate::math::{Hit, Ray};
use crate::prepare::PreparedScene;
use crate::sampling::{PathSampler, Purpose, hash_combine};
use glam::Vec3;

/// Who asks.
#[derive(Clone, Copy)]
pub(super) struct Asker {
    pub sampler: PathSampler,
    /// Number of the path's vertex that the ray leaves, 0 for the camera.
    pub vertex: u32,
    /// Number of the light sample at the vertex, from 1, or 0 for the path's own ray: each has coverage of its own.
    pub draw: u32,
    /// A camera ray, which single-sided backs do not stop.
    pub eye: bool,
}

impl Asker {
    /// One number for vertex and light sample (apart from each other up to 65 536 vertices and 8 191 light samples).
    fn address(&self) -> u32 {
        self.vertex ^ self.draw << 16
    }
}

/// Whether a surface stops a ray: culling, and coverage by a number that belongs to (path, vertex, triangle).
#[inline]
pub(super) fn stops(prepared: &PreparedScene, asker: &Asker, hit: &Hit, dir: Vec3) -> bool {
    !prepared.questions.asks(hit.triangle, asker.eye) || covers(prepared, asker, hit, dir)
}

/// [`stops`] for triangles that have to be asked.
#[inline(never)]
pub(super) fn covers(prepared: &PreparedScene, asker: &Asker, hit: &Hit, dir: Vec3) -> bool {
    let (scene, geometry) = (&prepared.scene, &prepared.geometry);
    // Most triangles of cut-outs are whole or open all over.
    let known = geometry.known_coverage(hit.triangle).filter(|_| prepared.asks.covers);
    if known == Some(false) {
        return false;
    }
    let filters = prepared.ways[geometry.part_index(hit.triangle) as usize].filters;
    if filters.culled && asker.eye && geometry.unit_normal(hit.triangle).dot(dir) > 0.0 {
        return false;
    }
    if filters.coverage && known.is_none() {
        let b = [1.0 - hit.b1 - hit.b2, hit.b1, hit.b2];
        let covered = coverage(scene, geometry, hit.triangle, b);
        if covered <= 0.0 || covered >= 1.0 {
            return covered > 0.0;
        }
        let site = coverage_site(geometry, hit.triangle, b);
        return asker.sampler.fixed(asker.address(), Purpose::Coverage(site)) < covered;
    }
    true
}

/// Names what of a triangle the point with barycentric weights `b` lies on: the triangle, or an edge or corner, which
/// neighbours that share it name alike. A ray exactly through an edge meets all triangles there; when they decide by the
/// same number whether they stop it, a sheet is a single layer at its inner edges, too.
fn coverage_site(geometry: &Geometry, triangle: u32, b: [f32; 3]) -> u32 {
    // The weight of the first corner is what is left of 1, and so only zero but for rounding.
    let on = b.map(|weight| weight > f32::EPSILON);
    if on == [true; 3] {
        return triangle;
    }
    let corners = geometry.corners(triangle);
    let name = |corner: Vec3| corner.to_array().map(|x| (x + 0.0).to_bits()).into_iter().fold(0, hash_combine);
    // A sum: neighbours run along an edge in opposite directions.
    (0..3).filter(|k| on[*k]).fold(0, |sum: u32, k| sum.wrapping_add(name(corners[k])))
}

/// The nearest surface from `origin` along the unit vector `dir`.
pub(super) fn closest(prepared: &PreparedScene, asker: &Asker, origin: Vec3, dir: Vec3) -> Option<Hit> {
    let ray = Ray { origin, dir, t_max: f32::INFINITY };
    prepared.tree.closest(&ray, |hit| stops(prepared, asker, hit, dir))
}

/// The ray that looks whether a light sample arrives.
pub(super) struct ShadowRay {
    pub ray: Ray,
    /// The triangle that it ends on, which does not block it.
    pub reaches: Option<u32>,
}

impl ShadowRay {
    /// For a light sample seen from a vertex in the direction `shading`; `None` where its end is not.
    pub fn new(vertex: &Vertex, shading: &Outgoing, light: &LightSample) -> Option<Self> {
        let origin = shading.origin;
        let it = match light.target {
            Target::Infinity => {
                let ray = Ray { origin, dir: light.direction, t_max: f32::INFINITY };
                Self { ray, reaches: None }
            }
            Target::Point(point) => {
                // Points of a disc may lie below the horizon though its centre, which shades, does not.
                let out = vertex.towards(point - vertex.receiver().point)?;
                if (out.local.z > 0.0) != (shading.local.z > 0.0) {
                    return None;
                }
                let ray = Ray { origin: out.origin, dir: point - out.origin, t_max: 1.0 };
                Self { ray, reaches: None }
            }
            Target::Triangle { triangle, point, error, normal } => {
                let point = offset_point(point, error, normal, origin - point);
                Self { ray: Ray { origin, dir: point - origin, t_max: 1.0 }, reaches: Some(triangle) }
            }
        };
        (it.ray.dir != Vec3::ZERO).then_some(it)
    }
}

/// The share of a light sample that arrives at a vertex by its direction `shading`: zero, or what bodies on the way let
/// through. `inside` tells what the shadow ray begins in, `walls` how it passes smooth walls.
pub(super) fn visibility(
    prepared: &PreparedScene,
    asker: &Asker,
    vertex: &Vertex,
    shading: &Outgoing,
    inside: Inside,
    light: &LightSample,
    walls: Walls,
) -> Vec3 {
    let Some(ShadowRay { ray, reaches: end }) = ShadowRay::new(vertex, shading, light) else {
        return Vec3::ZERO;
    };
    let tints = |hit: &Hit| {
        let material = prepared.geometry.material(&prepared.scene, hit.triangle);
        light.through_glass && prepared.filters[material as usize].tints
    };
    let (mut tinted, mut walled) = (false, Vec::<Hit>::new());
    let blocked = prepared.tree.occluded(&ray, |hit| {
        if end == Some(hit.triangle) || !stops(prepared, asker, hit, ray.dir) {
            return false;
        }
        let (tints, wall) = (light.through_glass && tints(hit), is_wall(prepared, hit));
        tinted |= tints;
        if wall && !walled.iter().any(|known| known.triangle == hit.triangle) {
            if walled.len() >= most_triangles(walls.most) {
                return true;
            }
            walled.push(*hit);
        }
        !tints && !wall
    });
    if blocked {
        return Vec3::ZERO;
    }
    if tinted {
        return straight_transmittance(prepared, asker, &ray, inside, tints);
    }
    rest(prepared, inside, &ray) * through_walls(prepared, (ray.origin, ray.dir), &mut walled, walls)
}

/// Whether light may go straight through a surface that bounds no body.
#[inline]
pub(super) fn is_wall(prepared: &PreparedScene, hit: &Hit) -> bool {
    let of_part = || prepared.ways[prepared.geometry.part_index(hit.triangle) as usize].filters.walls;
    prepared.asks.walls && prepared.questions.wall(hit.triangle).unwrap_or_else(of_part)
}

/// How a shadow ray passes smooth walls: as a path in its place would.
#[derive(Clone, Copy)]
pub(super) struct Walls {
    /// Of the path, by which textures are filtered.
    pub cone: Cone,
    /// So many it may pass: a path scatters at each.
    pub most: u32,
}

/// More triangles of walls than this are more than so many walls, whatever lies upon each other: a bound for memory and time.
pub(super) fn most_triangles(most_walls: u32) -> usize {
    16 * (most_walls as usize + 1)
}

/// The share of a shadow ray's light that smooth walls let through, which it has met at `hits`, each triangle once; zero where they are too many.
pub(super) fn through_walls(
    prepared: &PreparedScene,
    (origin, dir): (Vec3, Vec3),
    hits: &mut [Hit],
    mut walls: Walls,
) -> Vec3 {
    // One order, whoever traced the ray. Distances are not negative, and so in the order of their bits.
    hits.sort_unstable_by_key(|hit| (hit.t.to_bits(), hit.triangle));
    let (distance, unit) = (dir.length(), dir.normalize());
    let (mut passed, mut beyond) = (Vec3::ONE, f32::NEG_INFINITY);
    for hit in hits {
        // A path begins anew beyond whatever is in one place: triangles on both sides of an edge, or upon each other.
        if hit.t * distance <= beyond {
            continue;
        }
        let wall = || {
            walls.most = walls.most.checked_sub(1)?;
            let place = Place::new(prepared, hit, unit)?;
            let vertex = Vertex::new(prepared, hit, place, unit, 1.0, walls.cone.at(hit.t * distance).width);
            Some((vertex.towards(unit)?, vertex.bsdf.straight(vertex.wo_local())))
        };
        let Some((outgoing, straight)) = { wall }() else { return Vec3::ZERO };
        beyond = (outgoing.origin - origin).dot(unit);
        passed *= straight;
    }
    passed
}

/// Transmittance of what is left of a shadow ray. One to infinity leaves a body that is open, as paths do that meet
/// nothing more.
pub(super) fn rest(prepared: &PreparedScene, inside: Inside, ray: &Ray) -> Vec3 {
    if ray.t_max.is_finite() { inside.transmittance(prepared, ray.dir.length() * ray.t_max) } else { Vec3::ONE }
}

/// Transmittance of all `.ray` bodies on a straight line: k_t to the power of the length inside each
/// (ray-format.md, section 10). Crossings are met one after the other, front to back.
fn straight_transmittance(
    prepared: &PreparedScene,
    asker: &Asker,
    ray: &Ray,
    mut inside: Inside,
    tints: impl Fn(&Hit) -> bool,
) -> Vec3 {
    // A line meets each triangle once, and once more where rounding has it so: the loop must end.
    let most_crossings = 2 * prepared.geometry.len();
    let mut transmittance = Vec3::ONE;
    let mut origin = ray.origin;
    let end = ray.origin + ray.dir * if ray.t_max.is_finite() { ray.t_max } else { 0.0 };
    for _ in 0..=most_crossings {
        let (dir, t_max) = if ray.t_max.is_finite() { (end - origin, 1.0) } else { (ray.dir, f32::INFINITY) };
        let segment = Ray { origin, dir, t_max };
        let Some(hit) = prepared.tree.closest(&segment, |hit| tints(hit) && stops(prepared, asker, hit, dir)) else {
            return transmittance * rest(prepared, inside, &segment);
        };
        let Some(place) = Place::new(prepared, &hit, dir) else { return transmittance };
        inside = inside.met(prepared, &place);
        transmittance *= inside.transmittance(prepared, hit.t * dir.length());
        transmittance *= through_surface(prepared, place.material);
        if transmittance == Vec3::ZERO {
            break;
        }
        inside = inside.crossed(prepared, &place);
        origin = place.spawn(dir);
    }
    Vec3::ZERO
}
