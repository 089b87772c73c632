use super::bend::{reflecting_normal, visible_normal};
use super::material;
use crate::geometry::textures::Reader;
use crate::lighting::Receiver;
use crate::math::Frame;
use crate::math::Hit;
use crate::math::float_error::{gamma, offset_point};
use crate::prepare::PreparedScene;
use crate::shading::Bsdf;
use glam::Vec3;
use kiln_formats::scene::{Layers, MaterialId};

/// How far off a plane the next ray may seem to meet it, in rounding errors of the size of a triangle in it (`kdtree::slab`): with
/// that much of a distance a ray meets neither the flat triangle that it leaves nor neighbours in its plane.
pub(super) const SAME_PLANE: u32 = 15;

/// A point on a surface, seen from one side.
#[derive(Clone, Copy, Debug)]
pub(super) struct Place {
    pub triangle: u32,
    pub material: MaterialId,
    pub point: Vec3,
    /// How far off the surface rays have to start, along each axis.
    error: Vec3,
    /// Unit geometric normal on the viewer's side.
    normal: Vec3,
    /// Whether the viewer is in front of the triangle.
    pub front: bool,
}

impl Place {
    /// The place of a hit seen against the direction `dir`.
    pub(super) fn new(prepared: &PreparedScene, hit: &Hit, dir: Vec3) -> Option<Self> {
        let geometry = &prepared.geometry;
        let corners = geometry.corners(hit.triangle);
        let [p0, p1, p2] = [corners[0] * (1.0 - hit.b1 - hit.b2), corners[1] * hit.b1, corners[2] * hit.b2];
        let outward = geometry.unit_normal(hit.triangle);
        let front = dir.dot(outward) < 0.0;
        // The point is rounded, and so is what the next ray meets.
        let rounding = (p0.abs() + p1.abs() + p2.abs()) * gamma(7);
        let [lo, hi] = [corners[0].min(corners[1]).min(corners[2]), corners[0].max(corners[1]).max(corners[2])];
        let plane = (hi - lo).max_element() * gamma(SAME_PLANE);
        Some(Self {
            triangle: hit.triangle,
            material: geometry.material(&prepared.scene, hit.triangle),
            point: p0 + p1 + p2,
            error: rounding + plane,
            normal: if front { outward } else { -outward },
            front,
        })
    }

    /// Where rays begin that leave to the viewer's side, and to the other.
    pub(super) fn sides(&self) -> (Vec3, Vec3) {
        (self.spawn(self.normal), self.spawn(-self.normal))
    }

    /// Where a ray towards `direction` begins.
    #[inline]
    pub(super) fn spawn(&self, direction: Vec3) -> Vec3 {
        offset_point(self.point, self.error, self.normal, direction)
    }
}

/// A path's vertex on a surface.
#[derive(Clone, Copy, Debug)]
pub(super) struct Vertex {
    pub place: Place,
    /// Where what is reflected starts: the place, or above it on the smooth surface that the triangle stands for.
    point: Vec3,
    /// Whether `point` is so far above the triangle that directions below its plane are open, too.
    lifted: bool,
    frame: Frame,
    wo_local: Vec3,
    pub bsdf: Bsdf,
}

/// A direction of scattering at a vertex.
#[derive(Clone, Copy, Debug)]
pub(super) struct Outgoing {
    /// In the shading frame.
    pub local: Vec3,
    /// Where the ray begins.
    pub origin: Vec3,
}

impl Vertex {
    /// The vertex at a hit, which is at `place`, seen against the unit direction `dir`. `index_around` is the index of
    /// refraction around the body that the surface bounds, `width` that of the ray's cone.
    pub(super) fn new(
        prepared: &PreparedScene,
        hit: &Hit,
        place: Place,
        dir: Vec3,
        index_around: f32,
        width: f32,
    ) -> Self {
        let (scene, geometry) = (&prepared.scene, &prepared.geometry);
        let b = [1.0 - hit.b1 - hit.b2, hit.b1, hit.b2];
        let (wo, front) = (-dir, place.front);
        let outward = if front { place.normal } else { -place.normal };
        let material = &scene.materials[place.material as usize];
        let attributes = geometry.attributes(scene, hit.triangle, b);
        let unmapped = attributes.normal.unwrap_or(outward);
        let footprint = footprint(prepared, hit.triangle, width);
        let textures = Reader { scene, pyramids: &prepared.pyramids, uv: attributes.uv, footprint };
        let point =
            material::Point { prepared, triangle: hit.triangle, material, attributes: &attributes, b, front, textures };
        let shading = match &material.normal_map {
            Some(map) => point.mapped_normal(map, unmapped).unwrap_or(unmapped),
            None => unmapped,
        };
        let visible = |normal| visible_normal(normal, place.normal, wo);
        // Light samples aim from one point, and what is transmitted smoothly starts at the triangle.
        let lift = if attributes.normal.is_some() { lift(prepared, &place, b) } else { Vec3::ZERO };
        // Twice the offset of spawned rays: beyond all that rounding could feign.
        let lifted = lift.dot(place.normal) > 2.0 * place.normal.abs().dot(place.error);
        let mut normal = visible(shading);
        if !lifted
            && let Some(bent) = reflecting_normal(normal, place.normal, wo)
            && point.reflects_most()
        {
            normal = bent;
        }
        let grain = material.layers().and_then(|layers| point.grain(layers));
        let frame = match grain {
            Some((tangent, _)) => Frame::from_normal_and_tangent(normal, tangent),
            None => Frame::from_normal(normal),
        };
        let wo_local = frame.to_local(wo);
        let coat = |layers: &Layers| {
            let own = point.coat_normal(layers, unmapped);
            own.map_or(Vec3::Z, |normal| frame.to_local(visible(normal)).normalize())
        };
        let bsdf = point.bsdf(index_around, wo_local, grain.map_or(0.0, |(_, strength)| strength), coat);
        let lifted = lifted && !bsdf.transmits_smoothly();
        let point = if lifted { place.point + lift } else { place.point };
        Self { place, point, lifted, frame, wo_local, bsdf }
    }

    /// The shading normal on the viewer's side.
    pub(super) fn shading_normal(&self) -> Vec3 {
        self.frame.z
    }

    /// Direction to the viewer in the shading frame.
    pub(super) fn wo_local(&self) -> Vec3 {
        self.wo_local
    }

    /// A shading-frame direction in the world, and how its ray begins; `None` where shading and geometric normal disagree
    /// on its side and nothing mends that.
    pub(super) fn world_of(&self, wi_local: Vec3) -> Option<(Vec3, Outgoing)> {
        let wi = self.frame.to_world(wi_local);
        Some((wi, self.outgoing(wi, wi_local)?))
    }

    /// How a ray along a world direction begins; `None` where shading and geometric normal disagree on its side and nothing
    /// mends that.
    pub(super) fn towards(&self, wi: Vec3) -> Option<Outgoing> {
        self.outgoing(wi, self.frame.to_local(wi))
    }

    fn outgoing(&self, wi: Vec3, local: Vec3) -> Option<Outgoing> {
        let Place { error, normal, .. } = self.place;
        let (above, reflected) = (wi.dot(normal) > 0.0, local.z > 0.0);
        if above == reflected {
            let origin = if reflected { self.point } else { self.place.point };
            return Some(Outgoing { local, origin: offset_point(origin, error, normal, wi) });
        }
        // From above the triangle it may pass beyond its edges, or be stopped by it.
        (reflected && self.lifted).then_some(Outgoing { local, origin: self.point })
    }

    /// The vertex as a receiver of light.
    pub(super) fn receiver(&self) -> Receiver {
        Receiver { point: self.point, normal: self.frame.z, both_sides: self.bsdf.transmits_smoothly() }
    }
}

/// The area that a ray's cone covers, in each set of texture coordinates.
pub(super) fn footprint(prepared: &PreparedScene, triangle: u32, width: f32) -> [f32; 2] {
    let (scene, geometry) = (&prepared.scene, &prepared.geometry);
    match prepared.asks.textured {
        false => [0.0; 2],
        true => geometry.texture_density(scene, triangle).map(|density| width * width * density),
    }
}

/// From a place to the smooth surface that its triangle stands for: away from the chord, by the mean of what leads to the
/// planes of the corners' normals (Hanika 2021, "Hacking the Shadow Terminator", Ray Tracing Gems II, chapter 4). Zero
/// where the surface is not convex to the viewer.
///
/// Without it, directions that the shading normal says are open begin below the facets, and are lost: dark triangles along
/// every shadow's edge.
fn lift(prepared: &PreparedScene, place: &Place, b: [f32; 3]) -> Vec3 {
    let Some(normals) = prepared.geometry.corner_normals(place.triangle) else { return Vec3::ZERO };
    let corners = prepared.geometry.corners(place.triangle);
    let mut lift = Vec3::ZERO;
    for k in 0..3 {
        let unit = normals[k].normalize_or_zero();
        let normal = if place.front { unit } else { -unit };
        // A normal that disagrees with the face tells nothing of a surface near it.
        if normal.dot(place.normal) > 0.0 {
            lift -= normal * (b[k] * (place.point - corners[k]).dot(normal).min(0.0));
        }
    }
    lift
}
