use crate::geometry::Attributes;
use crate::geometry::textures::{color, lookup, scalar};
use crate::lighting::Receiver;
use crate::math::Frame;
use crate::math::Hit;
use crate::math::float_error::{gamma, offset_point};
use crate::prepare::PreparedScene;
use crate::shading::{Bsdf, MetalRoughParams, PhongParams};
use glam::Vec3;
use kiln_formats::scene::{Material, MaterialId, NormalMap, Phong, Surface};

/// The least cosine between the viewer and a shading normal: beyond it the normal is bent back, since a viewer below
/// the shading horizon would see black (numerics: clamp to the visible side).
const LEAST_COSINE: f32 = 0.02;

/// A point on a surface, seen from one side.
#[derive(Clone, Copy, Debug)]
pub(super) struct Place {
    pub triangle: u32,
    pub material: MaterialId,
    pub point: Vec3,
    /// Bound on the rounding error of each coordinate of `point`.
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
        let outward = geometry.front_normal(hit.triangle).try_normalize()?.as_vec3();
        let front = dir.dot(outward) < 0.0;
        Some(Self {
            triangle: hit.triangle,
            material: geometry.material(&prepared.scene, hit.triangle),
            point: p0 + p1 + p2,
            error: (p0.abs() + p1.abs() + p2.abs()) * gamma(7),
            normal: if front { outward } else { -outward },
            front,
        })
    }

    /// Where a ray towards `direction` begins.
    #[inline]
    pub(super) fn spawn(&self, direction: Vec3) -> Vec3 {
        offset_point(self.point, self.error, self.normal, direction)
    }

    /// Whether two directions lie on the same side of the surface.
    pub(super) fn same_side(&self, a: Vec3, b: Vec3) -> bool {
        (a.dot(self.normal) > 0.0) == (b.dot(self.normal) > 0.0)
    }
}

/// A path's vertex on a surface.
#[derive(Clone, Copy, Debug)]
pub(super) struct Vertex {
    pub place: Place,
    frame: Frame,
    wo_local: Vec3,
    pub bsdf: Bsdf,
}

impl Vertex {
    /// The vertex at a hit, which is at `place`, seen against the unit direction `dir`.
    pub(super) fn new(prepared: &PreparedScene, hit: &Hit, place: Place, dir: Vec3) -> Self {
        let (scene, geometry) = (&prepared.scene, &prepared.geometry);
        let b = [1.0 - hit.b1 - hit.b2, hit.b1, hit.b2];
        let (wo, front) = (-dir, place.front);
        let outward = if front { place.normal } else { -place.normal };
        let material = &scene.materials[place.material as usize];
        let attributes = geometry.attributes(scene, hit.triangle, b);
        let shading = attributes.normal.unwrap_or(outward);
        let shading = match &material.normal_map {
            Some(map) => mapped_normal(prepared, map, shading, &attributes).unwrap_or(shading),
            None => shading,
        };
        let frame = Frame::from_normal(visible_normal(shading, place.normal, wo));
        let wo_local = frame.to_local(wo);
        let bsdf = bsdf(prepared, hit.triangle, material, &attributes, b, front, wo_local.z);
        Self { place, frame, wo_local, bsdf }
    }

    /// Direction to the viewer in the shading frame.
    pub(super) fn wo_local(&self) -> Vec3 {
        self.wo_local
    }

    /// A shading-frame direction in the world, unless shading and geometric normal disagree on its side.
    pub(super) fn world_of(&self, wi_local: Vec3) -> Option<Vec3> {
        let wi = self.frame.to_world(wi_local);
        ((wi.dot(self.place.normal) > 0.0) == (wi_local.z > 0.0)).then_some(wi)
    }

    /// A world direction in the shading frame, unless shading and geometric normal disagree on its side.
    pub(super) fn local_of(&self, wi: Vec3) -> Option<Vec3> {
        let wi_local = self.frame.to_local(wi);
        ((wi.dot(self.place.normal) > 0.0) == (wi_local.z > 0.0)).then_some(wi_local)
    }

    /// The vertex as a receiver of light.
    pub(super) fn receiver(&self) -> Receiver {
        let both_sides = self.bsdf.transmits_smoothly();
        Receiver { point: self.place.point, normal: self.place.normal, both_sides }
    }
}

/// The shading normal on the viewer's side of the surface, bent towards the viewer where he would be below its
/// horizon.
fn visible_normal(shading: Vec3, normal: Vec3, wo: Vec3) -> Vec3 {
    let shading = if shading.dot(normal) < 0.0 { -shading } else { shading };
    let cosine = shading.dot(wo);
    if cosine >= LEAST_COSINE {
        return shading;
    }
    (shading + wo * (LEAST_COSINE - cosine)).try_normalize().filter(|n| n.dot(wo) > 0.0).unwrap_or(normal)
}

/// Perturbed normal from a tangent-space map: glTF's `normalize(sampled · vec3(scale, scale, 1))` in the basis of
/// tangent, bitangent and normal.
fn mapped_normal(prepared: &PreparedScene, map: &NormalMap, normal: Vec3, attributes: &Attributes) -> Option<Vec3> {
    let (tangent, handedness) = attributes.tangent?;
    let texel = lookup(&prepared.scene, &map.texture, &attributes.uv).truncate() * 2.0 - 1.0;
    let tangent = (tangent - normal * normal.dot(tangent)).try_normalize()?;
    let bitangent = normal.cross(tangent) * handedness;
    (tangent * (texel.x * map.scale) + bitangent * (texel.y * map.scale) + normal * texel.z).try_normalize()
}

fn bsdf(
    prepared: &PreparedScene,
    triangle: u32,
    material: &Material,
    attributes: &Attributes,
    b: [f32; 3],
    front: bool,
    cos_o: f32,
) -> Bsdf {
    let (scene, uv) = (&prepared.scene, &attributes.uv);
    match &material.surface {
        Surface::Unlit(_) => Bsdf::BLACK,
        Surface::MetalRough(m) => Bsdf::metal_rough(
            &MetalRoughParams {
                base_color: color(scene, &m.base_color, uv) * attributes.color.truncate(),
                metallic: scalar(scene, &m.metallic, uv),
                roughness: scalar(scene, &m.roughness, uv),
                specular: scalar(scene, &m.specular, uv),
                specular_color: color(scene, &m.specular_color, uv),
                ior: m.ior,
                transmission: scalar(scene, &m.transmission, uv),
                thin_walled: m.volume.is_none(),
                entering: front,
            },
            cos_o,
        ),
        Surface::Phong(own) => {
            let (mesh, corners) = prepared.geometry.source(scene, triangle);
            let mut p = PhongParams {
                diffuse: Vec3::ZERO,
                specular: Vec3::ZERO,
                exponent: 0.0,
                mirror: Vec3::ZERO,
                transmission: Vec3::ZERO,
                ior: 0.0,
                entering: front,
            };
            let mut add = |phong: &Phong, weight: f32| {
                p.diffuse += color(scene, &phong.diffuse, uv) * weight;
                p.specular += color(scene, &phong.specular, uv) * weight;
                p.exponent += scalar(scene, &phong.exponent, uv) * weight;
                p.mirror += color(scene, &phong.mirror, uv) * weight;
                p.transmission += color(scene, &phong.transmission, uv) * weight;
                p.ior += scalar(scene, &phong.ior, uv) * weight;
            };
            if mesh.vertex_materials.is_empty() {
                add(own, 1.0);
            } else {
                for k in 0..3 {
                    let id = mesh.vertex_materials[corners[k]];
                    if let Surface::Phong(phong) = &scene.materials[id as usize].surface {
                        add(phong, b[k]);
                    }
                }
            }
            p.diffuse *= attributes.color.truncate();
            Bsdf::phong(&p, cos_o)
        }
    }
}
